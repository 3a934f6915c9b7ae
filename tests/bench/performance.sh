#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Everything of docs/performance.md that is measured, in one go: builds this tree with the peers that
# are installed, runs the suite for every instruction set, draws, and puts the tables into the page and
# the pictures beside it.
#
#   tests/bench/performance.sh [--quick] [--robots FOLDER] [--only STEP] [--build FOLDER]
#       [--page FOLDER]
#
# Eight minutes on two free processors, --quick one; the first time building takes longer. STEP: one
# of build, suite, isa, draw, page. CSV files and the table of instruction sets (isa.md) stay in
# BUILD/performance, BUILD being build/peers.
# --page FOLDER: writes performance.md and pictures/ there, not in docs.
set -eu
source=$(cd "$(dirname "$0")/../.." && pwd)
build=$source/build/peers
docs=$source/docs
robots=
only=
quick=
command=tests/bench/performance.sh
while [ $# -gt 0 ]; do
    case $1 in
    --quick) quick=yes command="$command --quick" ;;
    --robots) robots=$2 command="$command --robots $(basename "$2")" && shift ;;
    --only) only=$2 && shift ;;
    --build) build=$(realpath -m "$2") && shift ;;
    --page) docs=$2 && shift ;;
    *) sed -n '5,16s/^# \{0,1\}//p' "$0" >&2 && exit 3 ;;
    esac
    shift
done
output=$build/performance
page=$docs/performance.md
bin=$build/bin
made="humanoid30 humanoid58"
own="$source/config/robots/arm7.urdf $source/config/robots/quadruped.urdf"
humanoid=$source/config/robots/humanoid.urdf
rounds=31 turn=1000
[ -z "$quick" ] || rounds=9 turn=300
mkdir -p "$output" "$docs/pictures"

say() { printf '%s %s\n' "$(date +%T)" "$*" >&2; }
wanted() { [ -z "$only" ] || [ "$only" = "$1" ]; }

# The head of every file: what was measured, on what, when, how
head_of() {
    printf '# %s\n' "$command"
    printf '# %s, commit %s\n' "$(date -u +%F)" \
        "$(git -C "$source" rev-parse --short HEAD 2>/dev/null || echo unknown)"
    printf '# %s, %s processors, Linux %s\n' \
        "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1) (family $(sed -n \
            's/^cpu family[^:]*: //p' /proc/cpuinfo | head -1), model $(sed -n \
            's/^model[^a-z]*: //p' /proc/cpuinfo | head -1))" "$(nproc)" "$(uname -r | cut -d. -f1,2)"
    printf '# %s\n' "$(cc --version | head -1)"
}

build_tree() {
    say "building"
    [ -e "$build/build.ninja" ] ||
        cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTFA_PEERS=ON -DTFA_COUNT=ON >/dev/null
    cmake --build "$build" --target totalforce totalforce_tool totalforce_python_tools bench_suite \
        bench_count >/dev/null
}

suite() { # ISA, then arguments of bench_suite
    isa=$1 && shift
    TFA_ISA=$isa "$bin/bench_suite" --library "$build/lib/libtotalforce.so" --rounds $rounds \
        --turn-us $turn "$@"
}

# What the environment may choose here, best first
isas() {
    for isa in avx512 avx2 base; do
        TFA_ISA=$isa "$bin/bench_suite" --library "$build/lib/libtotalforce.so" --rounds 1 \
            --turn-us 1 --tasks fd "$source/config/robots/arm7.urdf" |
            awk -F, -v isa=$isa 'NR > 1 && $5 == "now" && $11 == isa { print isa; exit }'
    done
}

all_robots() {
    for robot in $own $humanoid $made; do
        echo "$robot"
        echo "$robot:floating"
    done
    echo "$source/config/robots/snake64.urdf"
    [ -n "$quick" ] && echo chain64 chain1000 || echo chain64 chain256 chain1000 chain4096
    [ -z "$robots" ] || for robot in "$robots"/*.urdf; do echo "$robot"; done
}

step_suite() {
    best=$(isas | head -1)
    say "suite, $best"
    # shellcheck disable=SC2046
    { head_of && suite "$best" $(all_robots); } >"$output/suite.csv"
}

step_isa() {
    { head_of
        head=1
        for isa in $(isas | sed 1d); do
            say "suite, $isa"
            suite "$isa" --tasks fd,lambda,batch-f64,batch-f32,scan,scan-2,tfa-cr,tfa-cr-2 \
                $own $made chain1000 | awk -v head=$head 'NR > 1 || head'
            head=0
        done
    } >"$output/isa.csv"
}

step_draw() {
    say "drawing"
    PYTHONPATH=$build/python:$source/docs/charts /usr/bin/python3 -B \
        "$source/tests/bench/suite/pictures.py" "$output/suite.csv" "$docs/pictures"
}

# Each block between <!-- table NAME --> and <!-- end --> is made anew.
step_page() {
    say "the page"
    tables=$source/tests/bench/suite/tables.awk
    awk -f "$tables" -v table=isa -v folder="$output" >"$output/isa.md"
    [ "$docs" = "$source/docs" ] || cp "$source/docs/performance.md" "$page"
    awk -v folder="$output" -v tables="$tables" '
        /^<!-- table [a-z]+ -->$/ {
            print
            print ""
            run = "awk -f " tables " -v table=" $3 " -v folder=" folder
            while ((run | getline line) > 0) print line
            if (close(run) != 0) exit 1
            print ""
            inside = 1
        }
        /^<!-- end -->$/ { inside = 0 }
        !inside && !/^<!-- table [a-z]+ -->$/ { print }' "$page" >"$page.new"
    mv "$page.new" "$page"
}

! wanted build || build_tree
for step in suite isa draw page; do
    ! wanted $step || step_$step
done
say "done: $page"
