#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Does a robot that is asked over DDS wait for another robot of the same daemon? Round trips of an
# arm in a closed loop: alone; while a second arm is streamed at 1 kHz in another daemon and domain,
# which takes the same share of the processors; and while it is streamed in the same daemon. One
# line for each repetition, medians last.
#
#   two_robots.sh BUILD_FOLDER [REPETITIONS]
set -eu
build=$1
repetitions=${2:-7}
source=$(cd "$(dirname "$0")/../.." && pwd)
bin=$build/bin
run=$(mktemp -d)
domain=$((180 + $$ % 20))
processes=
finish() {
    status=$?
    for process in $processes; do
        kill -TERM "$process" 2>/dev/null && wait "$process" || true
    done
    rm -rf "$run"
    exit $status
}
trap finish EXIT
trap 'exit 130' INT TERM
export CYCLONEDDS_URI="file://$source/config/dds/local.xml"

# start NAME DOMAIN
start() {
    cat >"$run/$1.yaml" <<YAML
runtime_dir: $run/$1
dds:
  enabled: yes
  domain: $2
robots:
  - name: arm
    urdf: $source/config/robots/arm7.urdf
  - name: second
    urdf: $source/config/robots/arm7.urdf
YAML
    "$bin/totalforced" "$run/$1.yaml" 2>"$run/$1.log" &
    processes="$processes $!"
}
start same "$domain"
start other $((domain + 1))
sleep 2

# p50 of the arm, us
arm() {
    "$bin/totalforce" latency arm --via dds --domain "$domain" --count 20000 |
        awk '$1 == "round_trip" {print $3}'
}

# The same beside the second arm in domain $1.
beside() {
    sed "s/Id=\"any\"/Id=\"$1\"/" "$source/config/dds/local.xml" >"$run/dds.xml"
    CYCLONEDDS_URI="file://$run/dds.xml" "$bin/example_dds_stream" second 7 60000 >/dev/null &
    load=$!
    sleep 0.5
    arm
    kill -TERM $load
    wait $load 2>/dev/null || true
}

median() {
    sort -g | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
}

echo "# us: alone, beside a robot of another daemon, of the same daemon; ratio of the last two"
for k in $(seq "$repetitions"); do
    alone=$(arm)
    other=$(beside $((domain + 1)))
    same=$(beside "$domain")
    awk -v a="$alone" -v o="$other" -v s="$same" \
        'BEGIN {printf "%.1f %.1f %.1f %.2f\n", a, o, s, s / o}'
done | tee "$run/table"
awk '{print $4}' "$run/table" | median | sed 's/^/# median ratio: /'
