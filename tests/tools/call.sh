# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce call` gives what `totalforce solve` gives, to the byte, over shared memory and over
# DDS; it survives the daemon; and `totalforce latency` measures it. Run it by tests/support/with_domain.
. "$(dirname "$0")/check.sh"

[ -x "$bin/totalforced" ] || {
    echo "skipped: $bin/totalforced is not built"
    exit 77
}
run=$work/run
domain=$TEST_DOMAIN
patient="--timeout-ms 60000"
daemon=
trap '[ -z "$daemon" ] || kill -9 $daemon 2>/dev/null; rm -rf "$work"' EXIT

cat >"$work/config.yaml" <<EOF
runtime_dir: $run
dds:
  enabled: true
  domain: $domain
ros2:
  enabled: true
  domain: $domain
max_state_us: 0
robots:
  - name: arm
    urdf: $data/arm.urdf
    max_tips: 32
    ros2: {enabled: true, namespace: /arm, joint_efforts: joint_efforts,
           state_age_ms: 3600000, command_age_ms: 3600000}
  - name: floater
    urdf: $data/arm.urdf
    base: floating
    max_tips: 32
  - name: cart
    urdf: $data/cart.urdf
  - name: hand
    urdf: $data/hand.urdf
    mimic: project
    lock_massless_leaves: true
    damping: true
    scenes:
      - name: part
        root: palm
        payload: [{link: left, mass: 1, com: [0, 0, 0.1]}]
EOF

# Its socket may be left from a daemon that was killed: it is there when it answers. Descriptors 3
# and 4 are the test's own ends of pipes.
start_daemon() {
    "$bin/totalforced" "$work/config.yaml" >"$work/daemon.log" 2>&1 3>&- 4<&- &
    daemon=$!
    tries=0
    until echo '{"op":"mass_matrix","q":[0,0,0]}' |
        "$tool" call arm --runtime-dir "$run" | grep -q '"status":"ok"'; do
        tries=$((tries + 1))
        if [ $tries -gt 3000 ] || ! kill -0 $daemon 2>/dev/null; then
            fail "the daemon does not start"
            cat "$work/daemon.log"
            finish
        fi
        sleep 0.1
    done
}

stop_daemon() {
    kill "$1" $daemon
    wait $daemon 2>/dev/null
    daemon=
}

call() {
    "$tool" call --runtime-dir "$run" --domain "$domain" $patient "$@" 2>"$work/err"
}

start_daemon

# every request and every refusal, both ways, against solve
cat "$data/requests.jsonl" "$data/refused.jsonl" "$data/operational.jsonl" "$data/requests.jsonl" >"$work/lines"
cat "$data/floating.jsonl" >"$work/floating"
sed -e 's/"q":\[[^]]*\]/&,"base_pose":[1,2,3,0.6,0,0,0.8],"base_twist":[0.1,0.2,0.3,-0.1,-0.2,-0.3]/' \
    -e 's/"qdd":/"base_acceleration":[1,2,3,4,5,6],&/' \
    -e 's/"posture_torques":/"base_wrench":[6,5,4,3,2,1],&/' "$data/operational.jsonl" >>"$work/floating"
"$tool" solve "$data/arm.urdf" <"$work/lines" >"$work/solved"
"$tool" solve --base floating "$data/arm.urdf" <"$work/floating" >"$work/floated"
"$tool" solve "$data/cart.urdf" <"$data/cart.jsonl" >"$work/carted"
"$tool" solve "$data/hand.urdf" --mimic project --lock-massless-leaves --damping \
    <"$data/hand.jsonl" >"$work/handed" 2>/dev/null
"$tool" solve "$data/hand.urdf" --mimic project --lock-massless-leaves --damping --root palm \
    --payload left:1,0,0,0.1 <"$data/hand_part.jsonl" >"$work/parted" 2>/dev/null
grep -q '"status":"error"' "$work/floated" "$work/carted" "$work/handed" "$work/parted" && fail "solve refuses a good request"
for via in shm dds; do
    call arm --via $via <"$work/lines" >"$work/out" || fail "call --via $via: $(cat "$work/err")"
    same "$work/out" "$work/solved" "call --via $via differs from solve"
    call floater --via $via <"$work/floating" >"$work/out"
    same "$work/out" "$work/floated" "call --via $via differs for a floating base"
    call cart --via $via <"$data/cart.jsonl" >"$work/out"
    same "$work/out" "$work/carted" "call --via $via differs for joints of many freedoms"
    call hand --via $via <"$data/hand.jsonl" >"$work/out"
    same "$work/out" "$work/handed" "call --via $via differs for joints that follow and fused ones"
    call hand.part --via $via <"$data/hand_part.jsonl" >"$work/out"
    same "$work/out" "$work/parted" "call --via $via differs for a scene"
done

# a robot that nobody serves
echo '{"id":1,"op":"mass_matrix","q":[0]}' | call nobody >"$work/out"
[ $? -eq 2 ] || fail "an unknown robot is not a failure"
says "$work/out" '"code":"E_ROBOT"'

# the daemon is killed between two lines and comes back: one error, then answers again
mkfifo "$work/in" "$work/pipe"
"$tool" call arm --runtime-dir "$run" $patient <"$work/in" >"$work/pipe" &
child=$!
exec 3>"$work/in" 4<"$work/pipe"
ask() {
    echo '{"id":'"$1"',"op":"mass_matrix","q":[0,0,0]}' >&3
    IFS= read -r reply <&4
    case $reply in
        "$2"*) ;;
        *) fail "want $2, found $reply" ;;
    esac
}
ask 1 '{"id":1,"status":"ok"'
stop_daemon -KILL
ask 2 '{"id":2,"status":"error","error":"mass_matrix of robot '\''arm'\'': no daemon'
ask 3 '{"id":3,"status":"error","error":"robot '\''arm'\'': no daemon listens at'
start_daemon
ask 4 '{"id":4,"status":"ok"'
exec 3>&-
wait $child || fail "call ends with $? after the daemon was away"
exec 4<&-

# latency: runs, reports, judges
baseline=
latency() {
    status "$@" --runtime-dir "$run" --domain "$domain" $patient $baseline --count 500 --warmup 50
}
latency 0 "$tool" latency arm --via both --urdf "$data/arm.urdf" --csv "$work/csv" \
    --histogram "$work/hgrm" --json
says "$work/out" '"loop": "closed"'
says "$work/out" '"via": "dds"'
says "$work/out" '"misses": 0'
[ "$(wc -l <"$work/csv")" -eq 1001 ] || fail "the CSV has not a line for each round trip"
says "$work/hgrm" '#[Max'
says "$work/hgrm.dds" '#[Max'
awk -F, 'NR > 1 && $1 == "shm" && $6 != $7 + $8 + $9 + $10 + $11 { bad++ } END { exit bad > 0 }' \
    "$work/csv" || fail "the parts of a round trip do not add up"
baseline="--baseline-ms 0"
latency 0 "$tool" latency arm --rate 2000 --json
says "$work/out" '"loop": "closed"'
latency 0 "$tool" latency arm --loop open --rate 500 --clients 3 --via shm,process,socket \
    --urdf "$data/arm.urdf" --jitter-us 20 --burst 2 --load compute=1,memory=1 --json
[ "$(grep -c '"loop": "open"' "$work/out")" -eq 3 ] || fail "not all three ways have an open loop"
[ "$(grep -c '"lost": 0' "$work/out")" -eq 12 ] || fail "something is lost in an open loop"
[ "$(grep -c '"count": 1500' "$work/out")" -ge 3 ] || fail "3 clients do not make 1500 round trips"
# over DDS not more than its ring of 16 takes while its worker has no processor
status 0 "$tool" latency arm --loop open --rate 500 --clients 3 --via dds --urdf "$data/arm.urdf" \
    --jitter-us 20 --burst 2 --json --runtime-dir "$run" --domain "$domain" $patient \
    $baseline --count 5 --warmup 0
[ "$(grep -c '"lost": 0' "$work/out")" -eq 4 ] || fail "something is lost in an open loop over DDS"
says "$work/out" '"count": 15'
for via in shm process; do
    latency 0 "$tool" latency arm --via $via --loop open --rate 4000 --slots 2 --burst 100 --json \
        --urdf "$data/arm.urdf"
    says "$work/out" '"lost": 0'
    says "$work/out" '"duplicates": 0'
    grep -q '"full": [1-9]' "$work/out" || fail "bursts over $via find room in a small ring"
done
latency 0 "$tool" latency arm --sweep rate=500,2000 --table "$work/table"
says "$work/out" "sweep of rate, closed loop"
[ "$(cut -d, -f 1-4 "$work/table" | tr '\n' ' ')" = "via,loop,swept,robot shm,closed,500,arm \
shm,closed,2000,arm " ] || fail "the table of a sweep: $(cat "$work/table")"
latency 0 "$tool" latency arm --sweep robots=arm,cart --loop open
latency 2 "$tool" latency arm --sweep rate=0
latency 0 "$tool" latency arm --cyclictest --save "$work/saved"
says "$work/out" "T: 0 ("
says "$work/saved" '"format":"totalforce latency 2"'
if [ -x "$bin/totalforce-plot" ]; then
    latency 0 "$tool" latency arm --compare "$work/saved" --html "$work/page.html" --json
    says "$work/err" "ratios of the tenths of the runs"
    says "$work/page.html" "<h1>arm over shm: half of 500 round trips within "
    latency 0 "$tool" latency arm --sweep batch=1,4 --cyclictest --save "$work/saved"
    says "$work/out" "# shm, batch=4, closed loop"
    status 0 "$tool" latency --compare "$work/saved" --compare "$work/saved"
    says "$work/out" "shm, robot arm, batch 4, wait hybrid, closed loop"
    says "$work/out" "within noise"
else
    latency 2 "$tool" latency arm --html "$work/page.html"
    says "$work/err" "install the package totalforce-tools-python"
fi
status 3 "$tool" latency

# a client that spins allocates nothing, misses no page and makes no system call that waits
latency 0 "$tool" latency arm --wait spin --json
/usr/bin/python3 - "$work/out" <<EOF || fail "a spinning client allocates, faults or waits"
import json, sys
client = json.load(open(sys.argv[1]))["runs"][0]["threads"][0]
assert client["process"] == "client"
keys = ["voluntary_switches"]
if client["allocations"] != -1: # no sanitizer
    keys += ["allocations", "minor_faults", "major_faults"]
sys.exit(any(client[key] for key in keys))
EOF
# closed: of states that come faster than they are answered ROS 2 keeps the last
latency 0 "$tool" latency arm --via ros2 --json
says "$work/out" '"lost": 0'
latency 2 "$tool" latency floater --via ros2
latency 3 "$tool" latency arm --rate 0
latency 0 "$tool" latency floater --batch 4 --wait block
says "$work/out" "and a floating base, batch 4"
says "$work/out" "p50 per state"
latency 1 "$tool" latency arm --fail-p99-us 0.001
says "$work/err" "expectation not met"
latency 0 "$tool" latency arm --fail-p99-us 1e9
# a ratio needs a ping-pong, and that two processors
"$tool" latency arm --fail-ratio 1e9 --runtime-dir "$run" $patient --count 500 \
    >"$work/out" 2>"$work/err" || says "$work/err" "no ping-pong baseline"
latency 2 "$tool" latency nobody
latency 2 "$tool" latency arm --method rnea
says "$work/err" "unknown method"
status 2 "$tool" latency arm --csv /nonexistent/x --count 10 --runtime-dir "$run"

stop_daemon -TERM
latency 2 "$tool" latency arm
says "$work/err" "no daemon listens at $run/arm.sock: start one"
finish
