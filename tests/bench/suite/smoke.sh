#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The suite runs, its rows are whole, both libraries answer alike, and tables can be made of them.
# No time is compared. The same with a robot's specialised kernel.
#   smoke.sh BENCH_SUITE LIBRARY
set -eu
here=$(cd "$(dirname "$0")" && pwd)
robots=$here/../../../config/robots
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$1" --library "$2" --baseline "$2" --rounds 2 --turn-us 5 \
    --tasks fd,fd-chained,fd-cold,fd+lambda,lambda,batch-f64,batch-f64-2,scan-2 \
    "$robots/arm7.urdf" "$robots/quadruped.urdf:floating" chain64 >"$work/suite.csv"
awk -F, '
    NR == 1 { columns = NF; next }
    NF != columns { print "fields: " $0; bad = 1 }
    !($12 > 0) || !($13 > 0) || !($15 > 0) || !($16 < 1e-6) { print "numbers: " $0; bad = 1 }
    $5 == "now" { now++ }
    $5 == "former" { former++; if ($16 != 0) { print "another answer: " $0; bad = 1 } }
    END { if (now != 7 + 6 + 8 || former != now) { print "rows: " now ", " former; bad = 1 }
          exit bad }' "$work/suite.csv"
sed -i '1i# command\n# date\n# machine\n# compiler' "$work/suite.csv" # as performance.sh
for table in machine robots chains; do
    awk -f "$here/tables.awk" -v table=$table -v folder="$work" >"$work/$table"
done
[ "$(cat "$work/machine")" = 'Measured by `command`, date,
machine, compiler' ]
grep -q '^| arm7 | [0-9]' "$work/robots"
grep -q '^| quadruped, floating | [0-9]' "$work/robots"
grep -q '^| scan-2 | [0-9]' "$work/chains"

# every task runs, and its error is small but in float
"$1" --library "$2" --rounds 1 --turn-us 1 --error "$robots/humanoid.urdf" >"$work/all.csv"
awk -F, 'NR > 1 { rows++ }
    NR > 1 && $19 > ($10 == "f32" ? 1e-2 : 1e-7) { print "error: " $0; bad = 1 }
    END { if (rows != 80) { print "rows: " rows; bad = 1 } exit bad }' "$work/all.csv"

"$1" --library "$2" --kernels "$work" --snap 1e-6 --rounds 2 --turn-us 5 \
    --tasks fd,fd-chained,lambda,fd+payload,batch-f64 "$robots/arm7.urdf" >"$work/specialised.csv"
awk -F, '
    NR == 1 { next }
    NF != 19 { print "fields: " $0; bad = 1 }
    !($12 >= 0) || ($16 != "" && !($16 < 1e-6)) { print "numbers: " $0; bad = 1 }
    $5 == "specialised" { specialised++ }
    $5 == "now" { now++ }
    END { if (specialised != 5 + 5 || now != 5) { print "rows: " specialised ", " now; bad = 1 }
          exit bad }' "$work/specialised.csv"
for table in cold page loads; do
    awk -f "$here/../specialised_tables.awk" -v table=$table "$work/specialised.csv" >"$work/$table"
done
grep -q '^| arm7 | [0-9]' "$work/cold"
grep -q '^| arm7 | 7 | ' "$work/loads"
grep -q "^| arm7 | [0-9]" "$work/page"
"$1" --library "$2" --kernels "$work" --snap 1e-6 --rounds 1 --turn-us 1 --tasks fd \
    "$robots/arm7.urdf" >"$work/again"
if grep -q compile_s "$work/again"; then echo "built twice"; exit 1; fi
[ "$("$1" 2>&1 | wc -l)" -eq 2 ]
[ "$("$1" --list | wc -l)" -ge 70 ]
