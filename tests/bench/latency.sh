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
. "$(dirname "$0")/daemon.sh"
arm=$source/config/robots/arm7.urdf
bytes=320 # mean of a request (q, v, tau, names, options) and its reply on the wire

start one arm <<YAML
dds: {enabled: yes, domain: $domain}
YAML
export TOTALFORCE_RUNTIME_DIR="$run/one"

# Round trip by ddsperf, us: it prints half of one. Median of the 50% column over its seconds.
ddsperf_p50() {
    ddsperf -i $((domain + 1)) -D 5 pong >/dev/null 2>&1 &
    ddsperf -i $((domain + 1)) -D 4 ping size $bytes listener 2>&1 |
        sed -n 's/.* 50% \([0-9.]*\)us.*/\1/p' | median | awk '{print 2 * $1}'
    wait $! || true
}

echo "# us: ping_pong solve shm ratio | ddsperf dds ratio (solve included in dds)"
for k in $(seq "$repetitions"); do
    "$bin/totalforce" latency arm --via shm --wait spin --count 200000 --urdf "$arm" >"$run/shm"
    floor=$(part ping-pong <"$run/shm")
    solve=$(part solve <"$run/shm")
    shm=$(part round_trip <"$run/shm")
    perf=$(ddsperf_p50)
    dds=$("$bin/totalforce" latency arm --via dds --domain $domain --count 40000 | part round_trip)
    awk -v f="$floor" -v s="$solve" -v r="$shm" -v p="$perf" -v d="$dds" 'BEGIN {
        printf "%.3f %.3f %.3f %.2f | %.1f %.1f %.2f\n", f, s, r, r / (f + s), p, d, d / p}'
done | tee "$run/table"
awk '{print $4}' "$run/table" | median | sed 's/^/# median ratio, shared memory: /'
awk '{print $8}' "$run/table" | median | sed 's/^/# median ratio, DDS: /'
