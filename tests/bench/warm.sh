#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Round trips of the 7-joint arm over shared memory in a closed loop and at 1 kHz, by a daemon
# without warm-ups and by one with them, in turns. One line for each turn, medians last: p50 of both,
# us, their ratio, and the time of the request in the worker at 1 kHz.
#
#   warm.sh BUILD_FOLDER [REPETITIONS] [WARM_US ...]
#
# A machine that does other work needs WARM_RT=1 (root): the worker has processor 1 and the client
# processor 0, before all other programs, and the client's is kept awake and free of them between
# its calls by a loop of lower priority.
set -eu
. "$(dirname "$0")/daemon.sh"
[ $# -le 2 ] || shift 2
[ $# -gt 0 ] && [ "$1" != "$build" ] || set -- 0 50
realtime= client=
if [ "${WARM_RT:-0}" = 1 ]; then
    realtime='realtime: {priority: 50, affinity: [1]}'
    client='chrt -f 40'
    chrt -f 30 taskset -c 0 sh -c 'while :; do :; done' &
    processes=$!
fi

for warm in "$@"; do
    start "$warm" arm <<YAML
warm_us: $warm
$realtime
YAML
done

# The ping-pong, which a busy machine may refuse, does not matter here. Beside loops of a higher
# priority the daemon may be too late to accept a client: it is asked again.
latency() {
    attempt=0
    until $client "$bin/totalforce" latency arm --runtime-dir "$run/$warm" --wait spin \
        ${client:+--cpu 0} "$@" >"$run/out" 2>"$run/error"; do
        attempt=$((attempt + 1))
        [ $attempt -lt 5 ] || { cat "$run/error" >&2; return 1; }
    done
}

echo "# warm_us: closed 1kHz ratio | compute at 1 kHz"
for k in $(seq "$repetitions"); do
    for warm in "$@"; do
        latency --count 50000
        closed=$(part round_trip <"$run/out")
        latency --rate 1000 --warmup 100 --count 1500
        awk -v w="$warm" -v c="$closed" -v o="$(part round_trip <"$run/out")" -v s="$(part compute <"$run/out")" \
            'BEGIN {printf "%s: %.3f %.3f %.2f | %.3f\n", w, c, o, o / c, s}'
    done
done | tee "$run/table"
for warm in "$@"; do
    printf '# median, warm_us %s:' "$warm"
    for column in 2 3 4 6; do
        printf ' %s' "$(awk -v w="$warm:" -v n=$column '$1 == w {print $n}' "$run/table" | median)"
    done
    echo
done
