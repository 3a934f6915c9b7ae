#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The suite runs, its rows are whole, both libraries answer alike, and tables can be made of them.
# No time is judged.
#   smoke.sh BENCH_SUITE LIBRARY
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$1" --library "$2" --baseline "$2" --rounds 2 --turn-us 5 \
    --tasks fd,fd-chained,fd-cold,fd+lambda,lambda,batch-f64,batch-f64-2,scan-2 \
    "$here/../../../config/robots/arm7.urdf" humanoid30:floating chain64 >"$work/suite.csv"
awk -F, '
    NR == 1 { columns = NF; next }
    NF != columns { print "fields: " $0; bad = 1 }
    !($12 > 0) || !($13 > 0) || !($15 > 0) || !($16 < 1e-6) { print "numbers: " $0; bad = 1 }
    $5 == "now" { now++ }
    $5 == "former" { former++; if ($16 != 0) { print "another answer: " $0; bad = 1 } }
    END { if (now != 7 + 6 + 8 || former != now) { print "rows: " now ", " former; bad = 1 }
          exit bad }' "$work/suite.csv"
for table in machine robots chains; do
    awk -f "$here/tables.awk" -v table=$table -v folder="$work" >"$work/$table"
done
grep -q '^| arm7 | 7 | [0-9]' "$work/robots"
grep -q '^| humanoid30, floating | 30 | ' "$work/robots"
grep -q '^| scan-2 | [0-9]' "$work/chains"
[ "$("$1" 2>&1 | wc -l)" -eq 2 ]
