# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The controllers of docs/examples, against a simulated arm: the tool reaches its goal; the arm
# holds still, and comes to rest after a push. The library and a daemon over shared memory lead to
# the same digits. Run it by tests/support/with_domain.
. "$(dirname "$0")/check.sh"

[ -x "$bin/totalforced" ] || {
    echo "skipped: $bin/totalforced is not built"
    exit 77
}
robots=$data/../../../config/robots
run=$work/run
daemon=
trap '[ -z "$daemon" ] || kill -9 $daemon 2>/dev/null; rm -rf "$work"' EXIT
cat >"$work/config.yaml" <<EOF
runtime_dir: $run
max_state_us: 0
robots:
  - name: arm
    urdf: $robots/arm7.urdf
EOF
"$bin/totalforced" "$work/config.yaml" >"$work/daemon.log" 2>&1 &
daemon=$!
tries=0
until [ -S "$run/arm.sock" ]; do
    tries=$((tries + 1))
    if [ $tries -gt 3000 ] || ! kill -0 $daemon 2>/dev/null; then
        fail "the daemon does not start"
        cat "$work/daemon.log"
        finish
    fi
    sleep 0.1
done

# by_daemon EXAMPLE: once more where the second that it grants a call is over
by_daemon() {
    tries=0
    until TOTALFORCE_RUNTIME_DIR=$run "$bin/example_$1" "$robots/arm7.urdf" tool0 arm \
        >"$work/daemon" 2>"$work/err"; do
        tries=$((tries + 1))
        [ $tries -lt 60 ] && grep -qi "time" "$work/err" || return 1
    done
}

for example in operational_space gravity_compensation; do
    "$bin/example_$example" "$robots/arm7.urdf" tool0 >"$work/library" ||
        fail "$example: the library"
    by_daemon $example || fail "$example: the daemon: $(cat "$work/err")"
    cmp "$work/library" "$work/daemon" || fail "$example: other digits over shared memory"
    cp "$work/library" "$work/$example"
done
# every half second ten times nearer; in the end at the goal, turned as it was
awk '{ near = $3 + 0; turned = $5 + 0 }
    NR > 1 && near > 0.1 * last { late = 1 } { last = near }
    END { exit !(NR == 6 && !late && near < 1e-9 && turned < 1e-7) }' "$work/operational_space" ||
    fail "the tool is not at its goal: $(cat "$work/operational_space")"
# still for a second; then, from the push on, each second less far than the one before
awk '{ moved = $4 + 0; energy = $8 + 0 }
    NR == 1 { held = moved < 1e-9 } NR == 2 { pushed = moved > 0.1; first = energy }
    NR > 2 && moved > 0.8 * last { late = 1 } { last = moved }
    END { exit !(NR == 12 && held && pushed && !late && moved < 0.01 && energy < 0.01 * first) }' \
    "$work/gravity_compensation" ||
    fail "the arm does not hold still, or come to rest: $(cat "$work/gravity_compensation")"

# a robot that the daemon does not serve: an error that says so
if TOTALFORCE_RUNTIME_DIR=$run "$bin/example_operational_space" "$robots/arm7.urdf" tool0 leg \
    2>"$work/err"; then
    fail "a robot that is not there"
fi
grep -q "unknown robot" "$work/err" || fail "no reason: $(cat "$work/err")"
kill -TERM $daemon
wait $daemon || fail "the daemon ended with $?"
daemon=
finish
