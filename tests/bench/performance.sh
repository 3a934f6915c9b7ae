#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Everything of docs/performance.md that is measured, in one go: builds this tree with the peers that
# are installed, runs the suite for every instruction set, counts instructions under callgrind,
# measures the share of the peak, draws, and puts the tables into the page and the pictures beside it.
#
#   tests/bench/performance.sh [--quick] [--robots FOLDER] [--only STEP] [--build FOLDER]
#       [--page FOLDER]
#
# Eight minutes on two free processors, --quick one; the first time building takes longer. STEP: one
# of build, suite, isa, count, peak, draw, page. CSV files and the tables that the page does not show
# (isa.md, instructions.md, peak.md) stay in BUILD/performance, BUILD being build/peers.
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
    cmake --build "$build" --target totalforce totalforce_tool bench_suite bench_count >/dev/null
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

# Valgrind knows AVX2, not AVX-512. One thread, a fixed number of calls, each counted.
step_count() {
    command -v valgrind >/dev/null || { say "no valgrind: no instructions" && return 0; }
    say "instructions, avx2"
    work=$(mktemp -d)
    tasks=fd,fd+estimate,fd+lambda,lambda,lambda-4,batch-f64,scan,tfa-cr more="humanoid58 chain1000"
    [ -z "$quick" ] || tasks=fd,lambda,batch-f64 more=
    TFA_ISA=avx2 valgrind --tool=callgrind --collect-atstart=no -q \
        --callgrind-out-file="$work/calls" "$bin/bench_suite" \
        --library "$build/lib/libtotalforce.so" --count --tasks $tasks \
        $own humanoid30 chain64 $more >/dev/null 2>&1
    { head_of
        echo "robot,base,joints,task,contestant,instructions,per_joint"
        for file in $(ls "$work" | sort -t. -k2n); do
            awk '/^desc: Trigger: Client Request: row / { row = substr($0, 36) }
                 /^totals: / && row != "" { n = split(row, f, ","); total = $2 / f[n]
                     printf "%s,%s,%s,%s,%s,%.0f,%.1f\n", f[1], f[2], f[3], f[4], f[5], total,
                         total / f[3] }' "$work/$file"
        done
    } >"$output/instructions.csv"
    rm -rf "$work"
}

# Operations of a state by bench_count over the times of the suite
step_peak() {
    say "share of the peak"
    tasks=batch-f64,batch-f64+lambda,batch-f64-crba,batch-f64-tfa,batch-id,batch-mass,batch-lambda
    { head_of
        echo "robot,bodies,precision,what,how,isa,ns,times,flop,gflops,peak,share"
        for isa in $(isas); do
            { TFA_ISA=$isa "$bin/bench_count" --flops $own $humanoid | sed 's/^/flop,/'
                for precision in f64 f32; do
                    suite "$isa" --tasks $tasks --precision $precision --one-by-one $own $humanoid |
                        sed 's/^/one by one,/'
                    suite "$isa" --tasks $tasks,batch-f64-2 --precision $precision $own $humanoid |
                        sed 's/^/lanes,/'
                done
            } | awk -F, -v isa="$isa" '
                $2 == "robot" { next }
                $1 == "flop" {
                    bodies[$2] = $3; flop[$2, $4] = $5; peak["f64"] = $6; peak["f32"] = $7
                    next
                }
                $6 != "now" { next }
                { task = $5; how = $1
                  if (sub(/-2$/, "", task)) how = "lanes, pool of 2"
                  if (how == "one by one") one[$2, task, $11] = $13
                  printf "%s,%s,%s,%s,%s,%s,%s,%.2f", $2, bodies[$2], $11, task, how, isa, $13,
                      one[$2, task, $11] / $13
                  if (how == "lanes") {
                      gflops = flop[$2, task] / $13
                      printf ",%s,%.1f,%s,%.0f%%\n", flop[$2, task], gflops, peak[$11],
                          100 * gflops / peak[$11]
                  } else
                      print ",,,,"
                }'
            [ -z "$quick" ] || break
        done
    } >"$output/peak.csv"
}

step_draw() {
    command -v gnuplot >/dev/null || { say "no gnuplot: no pictures" && return 0; }
    say "drawing"
    for name in robots chains batches; do
        gnuplot -e "folder='$output'" "$source/tests/bench/suite/$name.gp"
        cp "$output/$name.svg" "$docs/pictures/"
    done
}

# Each block between <!-- table NAME --> and <!-- end --> is made anew.
step_page() {
    say "the page"
    tables=$source/tests/bench/suite/tables.awk
    for name in isa instructions peak; do
        awk -f "$tables" -v table=$name -v folder="$output" >"$output/$name.md"
    done
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
for step in suite isa count peak draw page; do
    ! wanted $step || step_$step
done
say "done: $page"
