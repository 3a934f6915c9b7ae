#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Measures everything that docs/charts, docs/atlas and docs/accuracy.md show, draws their pictures and
# writes their tables: what stands between `<!-- made: NAME -->` and `<!-- end -->` in a page.
#
#   cmake --preset peers && cmake --build --preset peers     # release with MuJoCo and Orocos KDL
#   sh docs/charts/make.sh build/peers                       # some 10 minutes; nothing else should run
#
#   sh docs/charts/make.sh BUILD --quick FOLDER    a few small cells, pages and pictures in FOLDER
#
# Needs gnuplot. CSV files and the pictures that no page shows stay in BUILD/charts.
set -eu

usage="usage: sh docs/charts/make.sh BUILD [--quick FOLDER]"
[ $# -eq 1 ] || { [ $# -eq 3 ] && [ "$2" = --quick ]; } || { echo "$usage" >&2; exit 3; }
here=$(cd "$(dirname "$0")" && pwd)
source=$(cd "$here/../.." && pwd)
build=$(cd "$1" && pwd)
tool=$build/bin/totalforce
docs=$source/docs
work=$build/charts
sizes=8,32,128,1024,4096 few=8,128,1024 one=128 budget=10
chains="" maps="" points=13
if [ $# -eq 3 ]; then
    docs=$3 work=$3/work
    sizes=4,48 few=4,48 one=48 budget=1
    chains="--mechanisms random,heavy-tip,alternating,rank-deficient,side-branches --seeds 2"
    maps="--maps ratio,curl --bodies 4,48 --states 1 --seeds 2" points=3
    mkdir -p "$docs/charts" "$docs/atlas"
    cp "$source/docs/charts/README.md" "$docs/charts/"
    cp "$source/docs/atlas/README.md" "$docs/atlas/"
    cp "$source/docs/accuracy.md" "$docs/"
fi
rm -rf "$work"
mkdir -p "$work/blocks"
cd "$source" # the heads of the CSV files name files of robots from here

# run NAME COMMAND...: into $work/NAME, with its command line and time in the table `runs`
run() {
    name=$1
    shift
    begin=$(date +%s)
    echo "$name: totalforce $*" >&2
    # 1: an estimate breaks its promise, as the page then says
    "$tool" "$@" --output "$work/$name" || [ $? -eq 1 ]
    echo "$name|$*|$(($(date +%s) - begin))" >>"$work/runs"
}

# robots FILE...: as options
robots() {
    for name in "$@"; do
        printf ' --urdf config/robots/%s.urdf' "$name"
    done
}

chart="chart --budget-ms $budget"
run mechanisms $chart --bodies $sizes $chains
run robots $chart $(robots arm7 quadruped humanoid snake64)
run precision $chart --mechanisms random --bodies $one --methods crba,aba,tfa,tfa-cr,cfa,dca,scan \
    --refine 0,1,2 --precision f64,f32,f32+f64,f64+f128
run threads $chart --mechanisms random --bodies $few --threads 1,2
for kind in principal full; do
    run inertia-$kind $chart --urdf docs/charts/inertia-$kind.urdf --refine 0
done
for rhs in qdd tau gravity; do
    run atlas-$rhs atlas --rhs $rhs --points $points $maps
done

# what the pages show; the rest stays where it is
cp "$work/mechanisms/overview.png" "$docs/charts/mechanisms.png"
cp "$work/robots/overview.png" "$docs/charts/robots.png"
cp "$work/precision/random-$one.png" "$docs/charts/precision.png"
for mechanism in random heavy-tip alternating; do
    cp "$work/mechanisms/$mechanism-$one.png" "$docs/charts/$mechanism.png"
done
for picture in "$work"/atlas-qdd/*.png; do
    cp "$picture" "$docs/atlas/"
done
for map in ratio heavy-tip; do
    [ ! -f "$work/atlas-tau/$map.png" ] || cp "$work/atlas-tau/$map.png" "$docs/atlas/$map-tau.png"
done

for program in test_reference test_laws; do
    [ $# -eq 3 ] || [ ! -x "$build/bin/$program" ] || "$build/bin/$program" >"$work/$program.txt" 2>&1 || true
done
sh "$here/tables.sh" "$work" "$one"
for page in charts/README.md atlas/README.md accuracy.md; do
    awk -v folder="$work/blocks" -f "$here/fill.awk" "$docs/$page" >"$work/page"
    cp "$work/page" "$docs/$page"
done
