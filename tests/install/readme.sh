#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The README's three programs, as printed there, are compiled, and run against a daemon.
#
#   readme.sh SOURCE_FOLDER BUILD_FOLDER
set -eu
source=$1
build=$2
scratch=$(mktemp -d)
daemon=
finish() {
    status=$?
    [ -n "$daemon" ] && kill -TERM "$daemon" 2>/dev/null && wait "$daemon" || true
    rm -rf "$scratch"
    exit $status
}
trap finish EXIT
trap 'exit 130' INT TERM

# the C blocks of the README, in order: door1.c door2.c door3.c
awk -v folder="$scratch" '
    /^```c$/ {n++; inside = 1; next}
    /^```/   {inside = 0}
    inside   {print > (folder "/door" n ".c")}' "$source/README.md"
[ -s "$scratch/door3.c" ] || { echo "readme: three C programs expected"; exit 1; }

domain=$((150 + $$ % 50))
sed -i "s/dds_create_participant(0,/dds_create_participant($domain,/" "$scratch/door3.c"
flags="-std=gnu17 -Wall -Wextra -Werror -I$source/lib/include -I$build/lib/include"
link="-L$build/lib -Wl,-rpath,$build/lib -ltotalforce"
# A sanitizer of the build must be in the program too.
sanitize=$(sed -n 's/^TFA_SANITIZE:STRING=//p' "$build/CMakeCache.txt")
[ -z "$sanitize" ] || flags="$flags -fsanitize=$sanitize"
compiler=$(sed -n 's/^CMAKE_C_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
# shellcheck disable=SC2086
for door in 1 2; do
    "$compiler" $flags "$scratch/door$door.c" -o "$scratch/door$door" $link
done
idlc -o "$scratch" "$source/idl/totalforce.idl"
# shellcheck disable=SC2086
"$compiler" $flags -I"$scratch" -w "$scratch/door3.c" "$scratch/totalforce.c" -o "$scratch/door3" \
    -lddsc

cat >"$scratch/readme.yaml" <<YAML
runtime_dir: $scratch
dds:
  enabled: yes
  domain: $domain
robots:
  - name: arm
    urdf: $source/config/robots/arm7.urdf
YAML
export TOTALFORCE_RUNTIME_DIR="$scratch"
export CYCLONEDDS_URI="file://$source/config/cyclonedds-loopback.xml"
"$build/bin/totalforced" "$scratch/readme.yaml" 2>"$scratch/log" &
daemon=$!
turn=0
until [ -S "$scratch/arm.sock" ]; do
    turn=$((turn + 1))
    [ $turn -le 300 ] && kill -0 "$daemon" || { cat "$scratch/log"; exit 1; }
    sleep 0.1
done

cd "$source"
"$scratch/door1" >"$scratch/one"
"$scratch/door2" >"$scratch/two"
"$scratch/door3" >"$scratch/three"
[ "$(wc -l <"$scratch/one")" -eq 7 ]
# the same numbers through both doors
sed 's/^[^ ]* //' "$scratch/one" | diff - "$scratch/two"
second=$(sed -n '2p' "$scratch/two")
grep -qF "$second" "$scratch/three" || { echo "readme: no answer over DDS"; exit 1; }
echo "readme: three programs compiled, run, and of one opinion"
