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
. "$(dirname "$0")/daemon.sh"

for name in same other; do
    start $name arm second <<YAML
dds: {enabled: yes, domain: $([ $name = same ] && echo "$domain" || echo $((domain + 1)))}
YAML
done

# p50 of the arm, us
arm() {
    "$bin/totalforce" latency arm --via dds --domain "$domain" --count 20000 | part round_trip
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

echo "# us: alone, beside a robot of another daemon, of the same daemon; ratio of the last two"
for k in $(seq "$repetitions"); do
    alone=$(arm)
    other=$(beside $((domain + 1)))
    same=$(beside "$domain")
    awk -v a="$alone" -v o="$other" -v s="$same" \
        'BEGIN {printf "%.1f %.1f %.1f %.2f\n", a, o, s, s / o}'
done | tee "$run/table"
awk '{print $4}' "$run/table" | median | sed 's/^/# median ratio: /'
