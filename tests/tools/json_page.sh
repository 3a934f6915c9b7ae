# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The examples of docs/json.md are what the program answers: every command is run, its replies are
# compared with those on the page, numbers to the digits that are printed there.
. "$(dirname "$0")/check.sh"

source=$(cd "$(dirname "$0")/../.." && pwd)
PATH=$bin:$PATH
export PATH

# commands into $work/N.sh, the replies after them into $work/N.want
awk -v work="$work" '
    /^```sh$/ { examples++; file = work "/" examples ".sh"; printf "" > file; next }
    /^```json$/ { file = work "/" examples ".want"; next }
    /^```$/ { file = ""; next }
    file { print > file }
    END { print examples }' "$source/docs/json.md" >"$work/count"
count=$(cat "$work/count")
[ "$count" -ge 11 ] || fail "only $count examples"

# agree WANT FOUND: the same text; numbers within 1e-4 of each other, 1e-8, or above 1e12 both
agree() {
    awk '
        function number(x) {
            if (!match(x, /-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?/))
                return 0
            before = substr(x, 1, RSTART - 1)
            value = substr(x, RSTART, RLENGTH)
            rest = substr(x, RSTART + RLENGTH)
            return 1
        }
        { text[FNR == NR ? 1 : 2] = text[FNR == NR ? 1 : 2] $0 }
        END {
            a = text[1]
            b = text[2]
            while (number(a)) {
                wanted = before
                x = value
                a = rest
                if (!number(b) || before != wanted)
                    exit 1
                y = value
                b = rest
                d = x > y ? x - y : y - x
                size = x > 0 ? x : -x
                if (d > 1e-4 * size + 1e-8 && !(x > 1e12 && y > 1e12))
                    exit 1
            }
            exit number(b) || a != b || text[1] == ""
        }' "$1" "$2"
}

k=0
while [ $k -lt "$count" ]; do
    k=$((k + 1))
    (cd "$source" && sh "$work/$k.sh") 2>"$work/err" | sed 's/,"model":"[0-9a-f]*"}$/}/' >"$work/$k.found"
    agree "$work/$k.want" "$work/$k.found" || {
        fail "example $k of docs/json.md: $(cat "$work/$k.sh")"
        cat "$work/err" "$work/$k.found"
    }
done

# and every op, word and key has its place on the page
for word in forward_dynamics inverse_dynamics operational_inertia mass_matrix kinematics bias \
    task_torques derivatives inverse_dynamics_derivatives constrained_dynamics impact \
    constrained_inverse_dynamics regressor; do
    grep -q "^### \`$word\`" "$source/docs/json.md" || fail "no op $word on the page"
done
keys=$(sed -n 's/^    {"\([a-z_]*\)", .*/\1/p' "$source/tools/jsonl/jsonl_read.c"
    sed -n 's/^    X([A-Z_]*, [a-z_]*, "\([A-Za-z_]*\)", .*/\1/p
        s/^    X(\([a-z_]*\), TFA_OPS_.*/\1/p' "$source/lib/interface/fields.h")
[ "$(echo "$keys" | wc -l)" -ge 58 ] || fail "the tables of keys are not found"
for key in $keys; do
    grep -q "\`$key\`" "$source/docs/json.md" || fail "no key $key on the page"
done
words=$(echo '{"op":"kinematics","want":["?"]}' | "$tool" solve "$data/arm.urdf" | sed 's/.*there are \([^"]*\)".*/\1/')
for word in $(echo "$words" | tr -d ,); do
    grep -q "^| \`$word\` |" "$source/docs/json.md" || fail "no word $word on the page"
done
finish
