# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The programs of docs/examples with every robot of data/example_robots: the tool reaches its goal;
# the arm holds still, and comes to rest after a push, which is detected; friction is identified;
# a daemon answers over shared memory, where controllers lead to the digits of the library. Run it
# by tests/support/with_domain.
. "$(dirname "$0")/check.sh"

[ -x "$bin/totalforced" ] || {
    echo "skipped: $bin/totalforced is not built"
    exit 77
}
source=$data/../../..
arm=$source/config/robots/arm7.urdf
run=$work/run
daemon=
trap '[ -z "$daemon" ] || kill -9 $daemon 2>/dev/null; rm -rf "$work"' EXIT
while read -r file tip; do
    if [ -f "$source/$file" ]; then
        echo "$(basename "$file" .urdf) $source/$file $tip"
    else
        echo "skipped: $file is not there" >&2
    fi
done <"$data/example_robots" >"$work/robots"
{
    printf 'runtime_dir: %s\nmax_state_us: 0\nrobots:\n' "$run"
    sed 's/\([^ ]*\) \([^ ]*\) .*/  - {name: \1, urdf: \2}/' "$work/robots"
} >"$work/config.yaml"
"$bin/totalforced" "$work/config.yaml" >"$work/daemon.log" 2>&1 &
daemon=$!
tries=0
until [ -S "$run/arm7.sock" ]; do
    tries=$((tries + 1))
    if [ $tries -gt 3000 ] || ! kill -0 $daemon 2>/dev/null; then
        fail "the daemon does not start"
        cat "$work/daemon.log"
        finish
    fi
    sleep 0.1
done

# by_daemon EXAMPLE ARGUMENTS...: once more where the second that it grants a call is over
by_daemon() {
    tries=0
    program=$bin/example_$1
    shift
    until TOTALFORCE_RUNTIME_DIR=$run "$program" "$@" >"$work/daemon" 2>"$work/err"; do
        tries=$((tries + 1))
        [ $tries -lt 60 ] && grep -qi "time" "$work/err" || return 1
    done
}

# prints EXAMPLE FILE TIP PATTERN: computed by the library
prints() {
    "$bin/example_$1" "$2" "$3" >"$work/$1" 2>"$work/err" || fail "$1 $2: $(cat "$work/err")"
    grep -q "$4" "$work/$1" || fail "$1 $2: $(cat "$work/$1")"
}

while read -r name file tip; do
    prints link_it "$file" "$tip" ' [+-][0-9.]*$'
    prints identification "$file" "$tip" 'largest error [0-9.]*e-1[0-9]'
    prints collision_detection "$file" "$tip" 'detected [1-9] ms .*: error [0-9.]*e-0[3-9]$'
    by_daemon shared_memory "$name" || fail "shared_memory $name: $(cat "$work/err")"
    says "$work/daemon" "medians of 1000 calls: round trip "
    # every half second ten times nearer; in the end at the goal, turned as it is
    prints operational_space "$file" "$tip" goal
    awk '{ near = $3 + 0; turned = $5 + 0 }
        NR > 1 && near > 0.1 * last { late = 1 } { last = near }
        END { exit !(NR == 6 && !late && near < 1e-9 && turned < 1e-7) }' \
        "$work/operational_space" ||
        fail "$name: the tool is not at its goal: $(cat "$work/operational_space")"
    # still for a second; then, from the push on, each second less far than the one before
    prints gravity_compensation "$file" "$tip" moved
    awk '{ moved = $4 + 0; energy = $8 + 0 }
        NR == 1 { held = moved < 1e-9 } NR == 2 { pushed = moved > 0.1; first = energy }
        NR > 2 && moved > 0.8 * last + 1e-9 { late = 1 } { last = moved }
        END {
            exit !(NR == 12 && held && pushed && !late && moved < 0.01 && energy < 0.01 * first)
        }' \
        "$work/gravity_compensation" ||
        fail "$name does not hold still, or come to rest: $(cat "$work/gravity_compensation")"
done <"$work/robots"
for example in operational_space gravity_compensation; do
    prints $example "$arm" tool0 ' '
    by_daemon $example "$arm" tool0 arm7 || fail "$example: the daemon: $(cat "$work/err")"
    cmp "$work/$example" "$work/daemon" || fail "$example: other digits over shared memory"
done
for example in operational_space gravity_compensation identification collision_detection; do
    status 1 "$bin/example_$example" "$source/tools/lab/joints.urdf" sensor
    says "$work/err" "18 freedoms: at most 64, in joints of one"
done

# a robot that the daemon does not serve: an error that says so
if TOTALFORCE_RUNTIME_DIR=$run "$bin/example_operational_space" "$arm" tool0 leg \
    2>"$work/err"; then
    fail "a robot that is not there"
fi
grep -q "unknown robot" "$work/err" || fail "no reason: $(cat "$work/err")"
kill -TERM $daemon
wait $daemon || fail "the daemon ended with $?"
daemon=
finish
