#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Round trips of the 7-joint arm beside what they cannot beat, interleaved in one run: shared
# memory beside a plain ping-pong, DDS beside Cyclone's own ddsperf at the same size. One line for
# each repetition, medians last.
#
#   latency.sh BUILD_FOLDER [REPETITIONS]
set -eu
build=$1
repetitions=${2:-7}
source=$(cd "$(dirname "$0")/../.." && pwd)
bin=$build/bin
run=$(mktemp -d)
domain=$((180 + $$ % 20))
daemon=
pong=
finish() {
    status=$?
    for process in $daemon $pong; do
        kill -TERM "$process" 2>/dev/null && wait "$process" || true
    done
    rm -rf "$run"
    exit $status
}
trap finish EXIT
trap 'exit 130' INT TERM
export TOTALFORCE_RUNTIME_DIR="$run"
export CYCLONEDDS_URI="file://$source/config/dds/local.xml"
arm=$source/config/robots/arm7.urdf
bytes=320 # mean of a request (q, v, tau, names, options) and its reply on the wire

cat >"$run/bench.yaml" <<YAML
runtime_dir: $run
dds:
  enabled: yes
  domain: $domain
robots:
  - name: arm
    urdf: $arm
YAML
"$bin/totalforced" "$run/bench.yaml" 2>"$run/log" &
daemon=$!
turn=0
until [ -S "$run/arm.sock" ]; do
    turn=$((turn + 1))
    [ $turn -le 100 ] && kill -0 $daemon || { cat "$run/log"; exit 2; }
    sleep 0.1
done

median() {
    sort -g | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
}

# Round trip by ddsperf, us: it prints half of one. Median of the 50% column over its seconds.
ddsperf_p50() {
    ddsperf -i $((domain + 1)) -D 5 pong >/dev/null 2>&1 &
    pong=$!
    ddsperf -i $((domain + 1)) -D 4 ping size $bytes listener 2>&1 |
        sed -n 's/.* 50% \([0-9.]*\)us.*/\1/p' | median | awk '{print 2 * $1}'
    wait $pong || true
    pong=
}

echo "# us: ping_pong solve shm ratio | ddsperf dds ratio (solve included in dds)"
for k in $(seq "$repetitions"); do
    "$bin/totalforce" latency arm --via shm --wait spin --count 200000 --urdf "$arm" >"$run/shm"
    floor=$(awk '$1 == "ping-pong" {print $3}' "$run/shm")
    solve=$(awk '$1 == "solve" {print $3}' "$run/shm")
    shm=$(awk '$1 == "round_trip" {print $3}' "$run/shm")
    perf=$(ddsperf_p50)
    dds=$("$bin/totalforce" latency arm --via dds --domain $domain --count 40000 |
        awk '$1 == "round_trip" {print $3}')
    awk -v f="$floor" -v s="$solve" -v r="$shm" -v p="$perf" -v d="$dds" 'BEGIN {
        printf "%.3f %.3f %.3f %.2f | %.1f %.1f %.2f\n", f, s, r, r / (f + s), p, d, d / p}'
done | tee "$run/table"
awk '{print $4}' "$run/table" | median | sed 's/^/# median ratio, shared memory: /'
awk '{print $8}' "$run/table" | median | sed 's/^/# median ratio, DDS: /'
