# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce latency` where a run does not end as planned: the robot gets another shape, the daemon
# is killed, the user interrupts, a file cannot be written. Run it by tests/support/with_domain.
. "$(dirname "$0")/check.sh"

[ -x "$bin/totalforced" ] || {
    echo "skipped: $bin/totalforced is not built"
    exit 77
}
run=$work/run
daemon=
child=
trap 'kill -9 $daemon $child 2>/dev/null; rm -rf "$work"' EXIT

printf 'robots:\n  - {name: robot, urdf: robot.urdf}\n' >"$work/config.yaml"

# until_true COMMAND...: for five minutes at most.
until_true() {
    tries=0
    until "$@"; do
        tries=$((tries + 1))
        [ $tries -lt 3000 ] || return 1
        sleep 0.1
    done
}

answers() {
    "$tool" status --runtime-dir "$run" >"$work/status" 2>&1
}

measures() {
    "$tool" status --json --runtime-dir "$run" | grep -q '"process": .*"requests": [1-9][0-9][0-9]'
}

start_daemon() {
    cp "$data/cart.urdf" "$work/robot.urdf"
    TOTALFORCE_RUNTIME_DIR=$run "$bin/totalforced" "$work/config.yaml" >"$work/daemon.log" 2>&1 &
    daemon=$!
    until_true answers || {
        fail "the daemon does not start"
        cat "$work/daemon.log"
        finish
    }
}

# begin ARGUMENTS...: measures for a long time, beside the test.
begin() {
    "$tool" latency robot --runtime-dir "$run" --seconds 600 --baseline-ms 0 --warmup 10 \
        --timeout-ms 60000 "$@" \
        >"$work/out" 2>"$work/err" &
    child=$!
    until_true measures || fail "no client sends: $*"
}

# ends STATUS: of the run that was begun.
ends() {
    wait $child
    found=$?
    child=
    [ "$found" -eq "$1" ] || {
        fail "exit status $found, not $1"
        cat "$work/err"
    }
}

# another shape after a reload: its requests and buffers no longer fit
for loop in open closed; do
    start_daemon
    begin --loop $loop --rate 1000
    cp "$data/arm.urdf" "$work/robot.urdf"
    status 0 "$tool" reload --runtime-dir "$run"
    ends 2
    says "$work/err" "wrong size"
    kill $daemon
    wait $daemon
done

# a real-time priority and locked memory, or the remedy where they are not permitted
start_daemon
for option in "--priority 20" --mlock; do
    "$tool" latency robot --runtime-dir "$run" --count 100 --baseline-ms 0 $option \
        >"$work/out" 2>"$work/err" || says "$work/err" "or give CAP_"
    [ "$option" = --mlock ] || grep -q "SCHED_FIFO 20" "$work/out" ||
        says "$work/err" "--priority 20: Operation not permitted: raise the limit (rtprio"
done
status 3 "$tool" latency robot --priority 100
says "$work/err" "--priority: '100' is not a whole number from 1 to 99"

# a signal ends a measurement, not the report
for loop in open closed; do
    begin --loop $loop --rate 1000 --clients 2 --save "$work/saved" --csv "$work/csv" --json
    kill $child
    ends 1
    says "$work/out" '"ended_early": "interrupted"'
    says "$work/out" '"lost": 0'
    says "$work/saved" '"ended_early":"interrupted"'
    [ "$(wc -l <"$work/csv")" -gt 50 ] || fail "the CSV has not what was measured"
done
begin --sweep rate=1000,2000 --table "$work/table"
kill $child
ends 1
[ "$(wc -l <"$work/table")" -eq 2 ] || fail "a sweep goes on after a signal"

# a daemon that stands still
kill -STOP $daemon
status 2 "$tool" list --runtime-dir "$run"
says "$work/err" "the daemon at $run does not answer in time"
kill -CONT $daemon

# the end of the daemon ends a measurement, not the report
begin --rate 1000 --save "$work/saved"
kill -9 $daemon
ends 2
says "$work/err" "no daemon"
says "$work/out" "ended early: "
says "$work/saved" '"ended_early":"'

# files of the end are tried before the run: here there is not even a daemon
for option in save csv html table histogram; do
    status 2 "$tool" latency robot --runtime-dir "$run" --$option /nonexistent/file
    says "$work/err" "latency: /nonexistent/file: No such file or directory"
    status 2 "$tool" latency robot --runtime-dir "$run" --$option "$work"
    says "$work/err" "latency: $work: Is a directory"
done
status 2 "$tool" latency robot --runtime-dir "$run" --compare /nonexistent/file
grep -qE "plot: /nonexistent/file: No such file|install the package" "$work/err" ||
    fail "a session that is not there: $(cat "$work/err")"

finish
