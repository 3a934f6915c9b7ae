#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Measures everything that docs/accuracy.md shows and the answers of docs/which-method.md, draws its pictures and writes its tables: the lines
# between `<!-- made: NAME -->` and `<!-- end -->`.
#
#   cmake --preset peers && cmake --build --preset peers     # release with MuJoCo and Orocos KDL
#   sh docs/charts/make.sh build/peers                       # some 13 minutes; nothing else should run
#
#   sh docs/charts/make.sh BUILD --quick FOLDER    a few small cells; page and pictures in FOLDER
#
# Needs gnuplot. CSV files, all other pictures (each mechanism and size; each map of the atlas) and the
# tables that the page does not show (blocks/) stay in BUILD/charts.
set -eu

usage="usage: sh docs/charts/make.sh BUILD [--quick FOLDER]"
[ $# -eq 1 ] || { [ $# -eq 3 ] && [ "$2" = --quick ]; } || { echo "$usage" >&2; exit 3; }
here=$(cd "$(dirname "$0")" && pwd)
source=$(cd "$here/../.." && pwd)
build=$(cd "$1" && pwd)
tool=$build/bin/totalforce
docs=$source/docs
work=$build/charts
sizes=8,32,128,1024,4096 one=128 map_bodies=64 budget=10
chains="" maps="" points=13
hero="arm7 quadruped humanoid" strategies=single,batch,specialised,specialised-batch
cores=8,32,128,512,1024,2048,4096 single=32,128 lambda=128 seconds=10 samples=100
if [ $# -eq 3 ]; then
    docs=$(realpath -m "$3") work=$(realpath -m "$3")/work
    sizes=4,48 one=48 map_bodies=48 budget=1
    chains="--mechanisms random,heavy-tip,alternating,rank-deficient,side-branches,thin,taper --seeds 2"
    maps="--bodies 4,48 --states 1 --seeds 2" points=3
    hero=arm7 strategies=single,batch
    cores=8,32 single=8 lambda=8 seconds=0.4 samples=10
    mkdir -p "$docs"
    cp "$source/docs/accuracy.md" "$source/docs/which-method.md" "$docs/"
fi
mkdir -p "$docs/pictures"
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
kernels=$work/kernels
mkdir "$kernels"
for robot in $hero; do
    case $strategies in
    *specialised*) "$tool" specialise "config/robots/$robot.urdf" -o "$kernels" >/dev/null ;;
    esac
done
lambda_methods=auto,crba,tfa,tfa-one-sided,propagation,tfa-cr,hessenberg,cfa,cfa-cr,dca,scan,efpa,pv-osimr
peers= # those of this build
for peer in mujoco kdl; do
    if "$tool" chart --mechanisms straight --bodies 1 --methods $peer >/dev/null 2>&1; then
        peers=$peers,$peer
    fi
done
run hero $chart $(robots $hero) --methods "auto$peers" --rhs qdd --refine 0 --threads 1,2 \
    --strategies $strategies --precision f64,f32 --kernels "$kernels"
run lambda $chart $(robots $hero) --mechanisms random --bodies $lambda --op operational_inertia \
    --methods $lambda_methods${peers%,kdl} --refine 0 --strategies $strategies --kernels "$kernels"
run cores $chart --mechanisms random --bodies $cores --methods auto --rhs qdd --refine 0 --threads 1,2 \
    --strategies single,batch
run single $chart $(robots arm7 humanoid) --mechanisms random --bodies $single --methods aba --rhs qdd \
    --refine 0,1 --precision f64,f32,f32+f64 --strategies single,batch
run drift-arm drift $(robots arm7) --precision f64,f32,f32+f64 --step 0.004,0.001 --seconds $seconds \
    --samples $samples
run drift-thin drift --mechanism thin --methods aba,tfa,cfa,dca --precision f64,f32 --step 0.002 \
    --seconds $(echo "$seconds / 2" | bc -l) --samples $samples
run mechanisms $chart --bodies $sizes $chains
run robots $chart $(robots arm7 quadruped humanoid snake64)
run precision $chart --mechanisms random --bodies $one --methods crba,aba,tfa,tfa-cr,cfa,dca,scan \
    --refine 0,1,2 --precision f64,f32,f32+f64,f64+f128
for rhs in qdd tau gravity; do
    run atlas-$rhs atlas --rhs $rhs --points $points $maps
done

# the pictures of the page and of the README; the rest stays in $work
awk -f "$here/hero.awk" "$work/hero/chart.csv" >"$work/hero/points"
machine=$(sed -n 's/^# processor: //p' "$work/hero/chart.csv" | head -n 1)
note="$machine, $(date +%Y-%m-%d): sh docs/charts/make.sh"
gnuplot -e "data='$work/hero/points'; output='$docs/pictures/hero.svg'; note='$note'" "$here/hero.gp"
for picture in lambda cores single; do
    gnuplot -e "chart='$work/$picture/chart.csv'; output='$docs/pictures/$picture.svg'; note='$note'" \
        "$here/$picture.gp"
done
awk -v labels="$work/drift-labels" -f "$here/drift.awk" "$work/drift-arm/drift.csv" \
    "$work/drift-thin/drift.csv" >"$work/drift-lines"
gnuplot -e "data='$work/drift-lines'; labels='$work/drift-labels'; output='$docs/pictures/drift.svg'" \
    -e "note='$note'" "$here/drift.gp"
sh "$here/singular.sh" "$tool" "$docs/pictures/singular.svg" "$work/singular"
sh "$here/ellipsoid.sh" "$build/bin" "$docs/pictures/ellipsoid.svg" "$work/ellipsoid"
gnuplot -e "chart='$work/mechanisms/chart.csv'; output='$docs/pictures/bodies.svg'" \
    "$here/bodies.gp"
gnuplot -e "atlas='$work/atlas-qdd/atlas.csv'; bodies=$map_bodies; output='$docs/pictures/atlas.png'" \
    "$here/atlas.gp"

for program in test_reference test_laws; do
    [ $# -eq 3 ] || [ ! -x "$build/bin/$program" ] || TEST_LONG=1 "$build/bin/$program" >"$work/$program.txt" 2>&1 || true
done
sh "$here/tables.sh" "$work" "$one"
for page in accuracy which-method; do
    awk -v folder="$work/blocks" -f "$here/fill.awk" "$docs/$page.md" >"$work/page"
    cp "$work/page" "$docs/$page.md"
done
