#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Verifies the model of the ring with SPIN, exhaustively, then that each fault of mutations.txt is
# found. Prints a table; exit 1 if the model fails or a fault is not found as expected, 77 without
# spin or gcc.
#
#   ring_spin.sh [MACRO]     MACRO: only this fault, with its trail
set -eu
here=$(cd "$(dirname "$0")" && pwd)
for tool in spin gcc; do
    command -v $tool >/dev/null || { echo "ring_spin: skipped: $tool is missing"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
cd "$work"
cp "$here/ring.pml" .
failed=0

# build GCC_OPTIONS MODEL_OPTIONS
build() {
    begin=$(date +%s%N)
    # shellcheck disable=SC2086
    if ! spin -a $2 ring.pml >log 2>&1 || ! gcc $1 -w -o pan pan.c >>log 2>&1; then
        cat log
        exit 1
    fi
}

# verify PAN_OPTIONS: sets finding, states and seconds (since the last build or row)
verify() {
    rm -f ring.pml.trail
    # shellcheck disable=SC2086
    ./pan -m100000 $1 >out 2>&1 || true
    finding=$(sed -n 's/^pan:1: \(invalid end\|assertion\|acceptance\).*/\1/p' out)
    case $finding in
        "invalid end") finding=deadlock ;;
        acceptance) finding=${1##* } ;;
        assertion) ;;
        *) if grep -q 'errors: 0' out; then finding=none; else finding=failure; fi ;;
    esac
    # a search that stopped early has shown nothing
    if [ "$finding" = none ] && grep -q 'max search depth too small\|not completed' out; then
        finding=incomplete
    fi
    states=$(sed -n 's/^ *\([0-9.e+]*\) states, stored.*/\1/p' out)
    now=$(date +%s%N)
    took=$(((now - begin) / 10000000))
    begin=$now
    seconds=$((took / 100)).$(printf %02d $((took % 100)))
}

# row NAME EXPECTED
row() {
    note=
    if [ "$finding" != "$2" ]; then
        note="  <- expected: $2"
        failed=1
    fi
    printf '%-48s %-10s %9s %6s%s\n' "$1" "$finding" "$states" "$seconds" "$note"
}

safety="-DSAFETY -DNOCLAIM"

# model NAME MODEL_OPTIONS REQUESTS LIVE_REQUESTS: deadlocks and assertions, then, with fewer
# requests because its states are more, liveness under weak fairness (0: not)
model() {
    build "-O1 $safety" "$2 -DREQUESTS=$3"
    verify -w22
    row "$1, $3 requests: safety" none
    [ "$4" -gt 0 ] || return 0
    build -O1 "$2 -DREQUESTS=$4"
    for claim in answered worker_wakes client_wakes; do
        verify "-w22 -a -f -N $claim"
        row "$1, $4 requests: $claim" none
    done
}

# mutation MACRO EXPECTED MODEL_OPTIONS
mutation() {
    case $2 in
        answered | worker_wakes | client_wakes)
            build -O0 "-D$1 $3"
            verify "-w18 -a -f -N $2" ;;
        *)
            build "-O0 $safety" "-D$1 $3"
            verify -w18 ;;
    esac
    row "$(echo "$1" | sed 's/^MUTATE_//')" "$2"
}

printf '%-48s %-10s %9s %6s\n' "model or fault" finding states seconds
if [ $# -eq 0 ]; then
    alone="-DCLIENT_CRASHES=0 -DDAEMON_CRASHES=0"
    model "2 slots" "$alone" 6 5
    model "3 slots" "$alone -DSLOTS=3" 7 4
    model "client crashes" -DDAEMON_CRASHES=0 5 3
    model "daemon crashes" -DCLIENT_CRASHES=0 4 3
    model "daemon crashes twice" "-DCLIENT_CRASHES=0 -DDAEMON_CRASHES=2" 3 0
    model "both crash" "" 3 2
    model "both crash, spinning" -DSPIN_MODE 5 3
fi
grep -v '^#' "$here/mutations.txt" | sed 's/ *| */|/g' >list
while IFS='|' read -r name expected options _; do
    [ $# -eq 0 ] || [ "$name" = "$1" ] || continue
    mutation "$name" "$expected" "-DREQUESTS=4 $options"
    if [ $# -gt 0 ] && [ -f ring.pml.trail ]; then
        # shellcheck disable=SC2086
        spin -t -p -g "-D$name" -DREQUESTS=4 $options ring.pml
    fi
done <list
exit $failed
