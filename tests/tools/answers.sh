#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Hashes of answers: rows are whole and unlike, two runs agree, and the comparison finds a row that
# differs, one that is missing and one that is new.
#   answers.sh BIN_DIR DATA_DIR
set -eu
compare=$(cd "$(dirname "$0")/../../tools/lab" && pwd)/compare-answers
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

fail()
{
    echo "$1"
    cat result
    exit 1
}

for run in one two; do
    "$1/answer_hashes" --every 2000 --policies "$2/arm.urdf" "$2/hand.urdf" >$run
done
awk '!/^#/ && (NF != 9 || seen[$1 $2 $3 $4 $5 " " $6 " " $7 " " $8]++) { print; bad = 1 }
     $9 ~ /^[0-9a-f]+$/ && length($9) == 16 { hashes[$9] }
     END { exit bad || length(hashes) < 100 }' one >result || fail "rows:"
sh "$compare" one two >result || fail "two runs differ:"
grep -q ': [0-9]* equal, 0 differ, 0 missing, 0 new' result || fail "counts:"

# one row of method aba changed, one removed, one added
awk '/ fd aba plain/ && !a++ { $9 = "0" } / fd scan plain/ && !s++ { next } { print }
     END { print "other fixed fd aba plain+default 1 1 f64 0" }' one >changed
if sh "$compare" one changed >result; then fail "a change was not found:"; fi
grep -q ', 1 differ, 1 missing, 1 new; expected: 0 differ, 0 missing, 0 new$' result ||
    fail "counts of a change:"
sh "$compare" one changed ' fd (aba|scan) ' >result || fail "expected rows:"
grep -q ', 0 differ, 0 missing, 0 new; expected: 1 differ, 1 missing, 1 new$' result ||
    fail "counts of expected rows:"
status=0
sh "$compare" one /dev/null 2>result || status=$?
[ "$status" -eq 2 ] || fail "an empty output was compared:"
