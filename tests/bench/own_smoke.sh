#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# bench_own runs, its rows are whole, kernels answer as the generic one does, and tables can be made of
# its rows. No time is judged.
#   own_smoke.sh BENCH_OWN
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
link() {
    echo "<link name='$1'><inertial><origin xyz='0.1 0 0.2'/><mass value='2'/>
        <inertia ixx='0.2' ixy='0' ixz='0.01' iyy='0.3' iyz='0' izz='0.1'/></inertial></link>"
}
joint() {
    echo "<joint name='$1_$2' type='continuous'><parent link='$1'/><child link='$2'/>
        <origin xyz='0 0.1 0.3' rpy='1 0 0'/><axis xyz='0 0 1'/></joint>"
}
{
    echo "<robot name='arm7'><link name='base'/>"
    link one
    link two
    joint base one
    joint one two
    echo "</robot>"
} >"$work/arm7.urdf"

"$1" --csv --snap 1e-6 --kernels "$work" --rounds 2 --turn-us 5 "$work/arm7.urdf" >"$work/own.csv"
awk -F, '
    NR == 1 { next }
    NF != 8 { print "fields: " $0; bad = 1 }
    !($6 >= 0) || ($8 != "" && !($8 < 1e-6)) { print "numbers: " $0; bad = 1 }
    $4 == "own" { own++ }
    $4 == "generic" { generic++ }
    END { if (own != 5 + 15 || generic != 15) { print "rows: " own ", " generic; bad = 1 }
          exit bad }' "$work/own.csv"
for table in kernels warm cold batch page; do
    awk -f "$here/own_tables.awk" -v table=$table "$work/own.csv" >"$work/$table"
done
grep -q '^| arm7 | 2 | ' "$work/warm"
grep -q '^| arm7 | 2 | [0-9]' "$work/page"
"$1" --kernels "$work" --snap 1e-6 --rounds 2 --turn-us 5 "$work/arm7.urdf" | grep -q 'compiled in 0.00 s'
[ "$("$1" 2>&1 | wc -l)" -eq 2 ]
