# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce chain`: mechanisms load back to the same numbers; `totalforce chart` as a program.
. "$(dirname "$0")/check.sh"

mechanisms="straight zigzag helix random taper heavy-tip alternating thin light-heavy massless
    rank-deficient side-branches planar"
for name in $mechanisms; do
    for bodies in 1 2 9; do
        status 0 "$tool" chain $name --bodies $bodies
        cp "$work/out" "$work/chain.urdf"
        status 0 "$tool" chain $name --bodies $bodies
        same "$work/out" "$work/chain.urdf" "chain $name is not the same twice"
        status 0 "$tool" model --json "$work/chain.urdf"
        says "$work/out" "\"robot\": \"$name-$bodies\""
    done
done
status 0 "$tool" chain random --bodies 3 --seed 1
cp "$work/out" "$work/one"
status 0 "$tool" chain random --bodies 3 --seed 2
cmp -s "$work/out" "$work/one" && fail "the seed makes no difference"
status 0 "$tool" chain heavy-tip --bodies 3 --mass-ratio 123456.75
says "$work/out" '<mass value="123456.75"/>'
status 0 "$tool" chain helix --bodies 3 --curl 0
says "$work/out" 'rpy="0 0 0"'
status 3 "$tool" chain
status 3 "$tool" chain knot
says "$work/err" "no mechanism 'knot'; nearest: "
says "$work/err" "; there are straight, zigzag"
status 3 "$tool" chain random --bodies 0
status 3 "$tool" chain random --curl 2
says "$work/err" "curl: 2, must be 0 (straight) to 1 (curled)"
status 3 "$tool" chain random --radius -1
says "$work/err" "radius: -1"
"$tool" chain random >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chain does not notice a full disk"

# the chart as a program; its rows, pictures and pages: tests/python/chart.py
status 0 "$tool" chart --mechanisms random --bodies 2 --methods aba --budget-ms 1 --html "$work/page.html"
says "$work/out" "# command: totalforce chart --mechanisms random"
says "$work/page.html" "random: exact to rounding in "
status 3 "$tool" chart --mechanisms knot
says "$work/err" "totalforce chart: --mechanisms: no 'knot'; \`totalforce chain --help\` lists them"
status 2 "$tool" chart --urdf "$work/absent.urdf"
says "$work/err" "[unreadable]"
grep -q bodies "$work/err" && fail "a file that was refused has bodies: $(cat "$work/err")"
"$tool" chart --mechanisms random --bodies 2,256 --methods aba --budget-ms 1 \
    --html "$work/full.html" >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chart does not notice a full disk"
says "$work/err" "totalforce chart: output: No space left on device"
says "$work/full.html" "random-2"
grep -q 'random-256' "$work/full.html" && fail "chart goes on with a full disk"

# a program that is missing is named with its package; it may stand in PATH
mkdir "$work/bin"
cp "$tool" "$work/bin/totalforce"
status 2 env PATH=/nonexistent "$work/bin/totalforce" chart --help
[ "$(cat "$work/err")" = "totalforce: chart is the program totalforce-chart, which is not installed: \
install the package totalforce-tools-python" ] || fail "a missing program: $(cat "$work/err")"
status 0 env PATH="$bin:$PATH" "$work/bin/totalforce" chart --version
finish
