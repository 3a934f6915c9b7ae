# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce chain` and `totalforce chart`: mechanisms load back to the same numbers, and every row
# of a chart is an answer with a finite error or a refusal by name.
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
says "$work/err" "no mechanism 'knot'; there are straight, zigzag"
status 3 "$tool" chain random --bodies 0
status 3 "$tool" chain random --curl 2
says "$work/err" "curl: 2, must be 0 (straight) to 1 (curled)"
status 3 "$tool" chain random --radius -1
says "$work/err" "radius: -1"
"$tool" chain random >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chain does not notice a full disk"

header="mechanism,bodies,rhs,method,refine,precision,threads,status,about,answered_by,error,worst_component,floor,estimate,time_us,aba_us,time_ratio,samples,front"
# peers come on top of what is counted here
methods=crba,aba,tfa,tfa-cr,hessenberg,cfa,cfa-cr,dca,scan,scan-two-pass
status 0 "$tool" chart --bodies 2,5 --budget-ms 1 --states 2 --methods $methods
cp "$work/out" "$work/chart.csv"
says "$work/chart.csv" "# command: "
[ "$(grep -v '^#' "$work/chart.csv" | head -1)" = "$header" ] || fail "another header"
# 13 mechanisms, 2 sizes, 3 right-hand sides, 2 refinements, and at least aba, crba and tfa
grep -v '^#' "$work/chart.csv" | awk -F, '
    NR == 1 { next }
    NF != 19 { print "fields: " $0; bad = 1 }
    { rows++; methods[$4] = 1; key = $1 "," $2 "," $3; keys[key] = 1; if ($19) front[key] = 1 }
    $8 == "ok" || $8 == "fallback" {
        if ($11 !~ /^[0-9.]+e[-+][0-9]+$/ || $12 == "" || $15 <= 0 || $16 <= 0 || $17 <= 0) {
            print "not finite: " $0; bad = 1
        }
        if ($4 == "aba" && $11 > 1e-6) { print "aba is far off: " $0; bad = 1 }
        next
    }
    $8 !~ /^E_/ || $11 != "" || $9 == "" { print "refused without a name: " $0; bad = 1 }
    $8 == "E_SINGULAR" && $9 !~ /^body link/ { print "no body named: " $0; bad = 1 }
    END {
        for (key in keys) { n++; if (!front[key]) { print "no front: " key; bad = 1 } }
        for (m in methods) count++
        if (n != 78) { print "cells: " n; bad = 1 }
        if (count < 10 || rows != n * count * 2) { print "rows: " rows; bad = 1 }
        exit bad
    }' || fail "the rows of the chart"
grep -q '^rank-deficient,5,qdd,tfa,0,f64,1,E_SINGULAR,body link' "$work/chart.csv" ||
    fail "tfa is not refused on a rank-deficient body"

# a robot, floating, as JSON; the theory of a thin chain
status 0 "$tool" chart --urdf "$data/arm.urdf" --base floating --rhs tau --refine 0 --json --budget-ms 1
says "$work/out" '"mechanism":"arm"'
says "$work/out" '"rhs":"tau","method":"aba","refine":0,"precision":"f64","threads":1,"status":"ok"'
status 0 "$tool" chart --mechanisms thin --bodies 24 --methods aba,tfa --rhs qdd --refine 0 --budget-ms 1
grep -v '^#' "$work/out" | awk -F, '$4 == "aba" { a = $11 } $4 == "tfa" { t = $11 }
    END { exit !(a > 0 && t > 1e3 * a) }' || fail "tfa is not seen to fail on thin rods"
# the chain of a chart is the chain of `totalforce chain`
"$tool" chain random --bodies 6 >"$work/chain.urdf"
for source in "--mechanisms random --bodies 6" "--urdf $work/chain.urdf"; do
    status 0 "$tool" chart $source --turn 1 --methods aba,tfa,crba --rhs tau --refine 0 --budget-ms 1
    grep -v '^#' "$work/out" | sed 1d | cut -d, -f 3-14 >"$work/errors.$(expr "$source" : '--u')"
done
same "$work/errors.0" "$work/errors.3" "a mechanism and its file do not give the same errors"

status 3 "$tool" chart --mechanisms knot
says "$work/err" "--mechanisms: no 'knot'"
status 3 "$tool" chart --methods magic
status 3 "$tool" chart --rhs sideways
says "$work/err" "--rhs: no 'sideways'; there are qdd, tau, gravity"
status 3 "$tool" chart --refine 3
status 3 "$tool" chart one
status 2 "$tool" chart --urdf "$work/absent.urdf"
status 2 "$tool" chart --mechanisms random --bodies 2 --output "$work/absent/folder"
"$tool" chart --mechanisms random --bodies 2 --budget-ms 1 >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chart does not notice a full disk"

# pictures, where there is gnuplot
status 2 "$tool" chart --mechanisms random --bodies 2 --budget-ms 1 --output "$work/p" --scripts "$work/absent"
says "$work/err" "--scripts says where they are"
if command -v gnuplot >/dev/null; then
    status 0 "$tool" chart --mechanisms random,heavy-tip:1e3,rank-deficient --bodies 3,6 \
        --budget-ms 1 --output "$work/p"
    [ -s "$work/err" ] && fail "gnuplot complains: $(cat "$work/err")"
    for picture in random-3 random-6 heavy-tip-1e3-6 rank-deficient-3 overview; do
        [ -s "$work/p/$picture.png" ] || fail "no $picture.png"
        grep -q '</svg>' "$work/p/$picture.svg" || fail "no whole $picture.svg"
    done
    says "$work/p/random-3.svg" "hessenberg"
else
    echo "gnuplot is not installed: pictures are not tested"
fi
finish
