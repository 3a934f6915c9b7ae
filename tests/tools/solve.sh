# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce solve` end to end on a small arm: every kind of request, every kind of bad line.
. "$(dirname "$0")/check.sh"

solve() {
    "$tool" solve "$data/arm.urdf" "$@" 2>"$work/err"
}

# every request of the list is answered, in order
solve <"$data/requests.jsonl" >"$work/replies" || fail "solve fails on good requests"
[ "$(wc -l <"$work/replies")" -eq "$(wc -l <"$data/requests.jsonl")" ] || fail "a reply is missing"
grep -v '"status":"ok"' "$work/replies" && fail "a good request is refused"
sed 's/.*"id":\([^,]*\),.*/\1/' "$data/requests.jsonl" | head -17 >"$work/asked"
sed 's/.*"id":\([^,]*\),.*/\1/' "$work/replies" | head -17 >"$work/answered"
same "$work/asked" "$work/answered" "replies are out of order"
says "$work/replies" '{"id":1,"status":"ok","method":"aba","qdd":['
says "$work/replies" '{"id":3,"status":"ok","method":"crba","qdd":['
says "$work/replies" '{"id":4,"status":"ok","method":"tfa","qdd":['
says "$work/replies" '{"id":17,"status":"ok","method":"crba","M":[['
says "$work/replies" '{"status":"ok","method":"crba","M":[['
sed -n 1p "$work/replies" | grep -q '"error_estimate":' && fail "an estimate that nobody asked for"
sed -n 1p "$data/requests.jsonl" | solve --estimate always | grep -q '"error_estimate":' || fail "no error estimate"
sed -n 9p "$work/replies" | grep -q '"error_estimate":' && fail "an estimate although never"
sed -n 12p "$work/replies" | grep -q '"rank":3,"eig_min":' || fail "rank of three joints is not 3"
sed -n 14p "$work/replies" | grep -q '"rank":0,' || fail "rank of a fixed link is not 0"

solve --strict <"$data/operational.jsonl" >"$work/out" || fail "an operational request is refused: $(grep error "$work/out")"
[ "$(wc -l <"$work/out")" -eq "$(wc -l <"$data/operational.jsonl")" ] || fail "an operational reply is missing"

# the sentinel is on although nobody asked: near gimbal lock an answer is flagged, at gimbal lock refused
gimbal() {
    printf '{"op":"forward_dynamics","q":[0.7,%s,0.2],"v":[0.3,0.2,-0.4],"tau":[1,-2,0.5]}\n' "$1" |
        "$tool" solve --estimate "$2" "$data/gimbal.urdf"
}
gimbal 1.5707 default >"$work/a" || fail "near gimbal lock: refused"
grep -q '"error_estimate":.*"sentinel":true' "$work/a" || fail "an answer in doubt is not flagged"
gimbal 1.5707 never >"$work/a" || fail "near gimbal lock: refused without an estimate"
grep -q 'error_estimate\|sentinel' "$work/a" && fail "a sentinel although never"
gimbal 1.5707963267948966 default >"$work/a"
says "$work/a" "forward_dynamics: body 'rotor': no reliable answer"

# the methods agree
for line in 3 4; do
    sed -n 1p "$work/replies" | array qdd >"$work/a"
    sed -n ${line}p "$work/replies" | array qdd >"$work/b"
    near "$work/b" "$work/a" 1e-12 "line $line does not agree with aba"
done

# inverse dynamics of the answer gives the torques back
qdd=$(sed -n 1p "$work/replies" | sed 's/.*"qdd":\(\[[^]]*\]\).*/\1/')
echo '{"op":"inverse_dynamics","q":[0.1,-0.4,0.2],"v":[0.5,-1,0.3],"qdd":'"$qdd"'}' |
    solve | array tau >"$work/a"
printf '10\n-5\n2\n' >"$work/b"
near "$work/a" "$work/b" 1e-12 "rnea(aba(tau)) is not tau"

# values by name are the values by order; gravity as an option is gravity in the request
echo '{"op":"forward_dynamics","q":[0.1,0,0.2],"tau":[0,3,0]}' | solve >"$work/a"
echo '{"op":"forward_dynamics","tau":{"elbow":3},"q":{"rail":0.2,"shoulder":0.1}}' | solve >"$work/b"
same "$work/a" "$work/b" "by name differs from by order"
echo '{"op":"forward_dynamics","q":[1,0,0],"gravity":[1,2,3]}' | solve | sed 's/,"model.*//' >"$work/a"
echo '{"op":"forward_dynamics","q":[1,0,0]}' | solve --gravity 1,2,3 | sed 's/,"model.*//' >"$work/b"
same "$work/a" "$work/b" "--gravity differs from gravity in the request"

# every reply names the model, by the start of the hash that `model` prints
tag=$("$tool" model "$data/arm.urdf" 2>/dev/null | sed -n 's/^  hash \(................\).*/\1/p')
[ "$(grep -c "\"model\":\"$tag\"}\$" "$work/replies")" -eq "$(wc -l <"$work/replies")" ] ||
    fail "a reply does not name model '$tag'"

# a joint locked by the request is a joint locked by the scene, but for its place in the arrays
echo '{"op":"forward_dynamics","q":[0.1,-0.4,0.2],"v":[1,0,2],"tau":[9,5,2],"locked":["elbow"],"tips":["tool"],"poses":true}' |
    solve >"$work/out"
array qdd <"$work/out" | sed -n '1p;3p' >"$work/a"
[ "$(array qdd <"$work/out" | sed -n 2p)" = 0.0 ] || fail "a locked joint moves"
echo '{"op":"forward_dynamics","q":[0.1,0.2],"v":[1,2],"tau":[9,2],"tips":["tool"],"poses":true}' |
    solve --lock elbow=-0.4 >"$work/out2"
array qdd <"$work/out2" >"$work/b"
near "$work/a" "$work/b" 1e-12 "locked in the request differs from --lock"
for file in out out2; do
    sed 's/.*"poses":\[\[\([^]]*\)\]\].*/\1/' "$work/$file" | tr ',' '\n' >"$work/$file.pose"
done
near "$work/out.pose" "$work/out2.pose" 1e-12 "poses differ with a joint locked"

# a payload of the request is a payload of the scene
echo '{"op":"forward_dynamics","q":[0.1,-0.4,0.2],"payload":{"link":"tool","mass":2,"com":[0.1,0,0.2],"inertia":[0.1,0.01,0,0.2,0,0.3]}}' |
    solve | array qdd >"$work/a"
echo '{"op":"forward_dynamics","q":[0.1,-0.4,0.2]}' |
    solve --payload tool:2,0.1,0,0.2,0.1,0.01,0,0.2,0,0.3 | array qdd >"$work/b"
near "$work/a" "$work/b" 1e-12 "payload in the request differs from --payload"
echo '{"op":"forward_dynamics","q":[0.1,-0.4,0.2]}' | solve | array qdd >"$work/b"
cmp -s "$work/a" "$work/b" && fail "a payload changes nothing"

# quadruple precision confirms the double answer
echo '{"op":"forward_dynamics","q":[0.1,-0.4,0.2],"v":[1,1,1]}' >"$work/request"
solve <"$work/request" | array qdd >"$work/a"
solve --precision f128 <"$work/request" | array qdd >"$work/b"
near "$work/a" "$work/b" 1e-13 "f64 and f128 disagree"

# a floating base: it falls, and its joints feel nothing
echo '{"op":"forward_dynamics","q":[0,0,0],"base_pose":[0,0,0,0,0,0,1]}' |
    solve --base floating >"$work/out"
array qdd <"$work/out" >"$work/a"
printf '0\n0\n0\n' >"$work/b"
near "$work/a" "$work/b" 1e-12 "joints move in free fall"
array base_acceleration <"$work/out" >"$work/a"
printf '0\n0\n-9.80665\n0\n0\n0\n' >"$work/b"
near "$work/a" "$work/b" 1e-12 "the base does not fall"
echo '{"id":1,"op":"mass_matrix","q":[0,0,0],"base_pose":[0,0,0,0,0,1,1]}' |
    solve --base floating >"$work/out"
says "$work/out" 'base_pose[3]: quaternion of norm 1.41421, must be 1 within 1e-3'

# constraints: all are answered; the force that holds one does as a wrench what it does
closed() {
    "$tool" solve "$data/arm.urdf" --constraints "$data/arm_closed.yaml" "$@"
}
closed --strict <"$data/constraints.jsonl" >"$work/out" || fail "a request with constraints is refused"
[ "$(wc -l <"$work/out")" -eq "$(wc -l <"$data/constraints.jsonl")" ] || fail "a reply is missing"
sed -n 2p "$work/out" | grep -q '"pulls":true' || fail "a foot that pulls is not told"
sed -n 5p "$work/out" | grep -q '"pulls"' && fail "a slot pulls"
state='"q":[0.1,-0.4,0.2],"v":[0.5,-1,0.3],"tau":[10,-5,2]'
echo "{\"op\":\"constrained_dynamics\",$state,\"constraints\":[\"ground\"]}" | closed >"$work/out"
force=$(sed 's/.*"constraint_wrenches":{"ground":\(\[[^]]*\]\).*/\1/' "$work/out")
array qdd <"$work/out" >"$work/a"
echo "{\"op\":\"forward_dynamics\",$state,\"wrench\":{\"tool\":$force}}" | closed | array qdd >"$work/b"
near "$work/a" "$work/b" 1e-11 "a constraint's force as a wrench"
closed >"$work/out" <<'END'
{"op":"constrained_dynamics","q":[0.1,-0.4,0.2],"constraints":["grund"]}
{"op":"constrained_dynamics","q":[0.1,-0.4,0.2],"constraints":[]}
{"op":"impact","q":[0.1,-0.4,0.2],"stabilisation":[-1,0]}
{"op":"constrained_inverse_dynamics","q":[0.1,-0.4,0.2],"torque_weights":{"elbow":0}}
{"op":"constrained_dynamics","q":[0.1,-0.4,0.2],"rank_loss":"refuse","rank_threshold":0.1}
END
says "$work/out" "constraints[0]: no constraint 'grund'; nearest: 'ground', 'slot'; the robot has 2 constraints (ground, slot)"
says "$work/out" "constraints: none active; the robot has 2 constraints (ground, slot)"
says "$work/out" "stabilisation[0]: -1: must not be negative"
says "$work/out" "torque_weights[1] (elbow): 0: must be above 0"
says "$work/out" "constraints: rows of ground, slot depend on each other, rank "

# every bad line gets its own sentence, and the good line after it an answer
while IFS= read -r line; do
    printf '%s\n' "$line"
    echo '{"id":99,"op":"mass_matrix","q":[0,0,0]}'
done <"$data/refused.jsonl" | solve >"$work/out"
[ $? -eq 0 ] || fail "bad lines end the program"
[ "$(grep -c '"id":99,"status":"ok"' "$work/out")" -eq "$(wc -l <"$data/refused.jsonl")" ] ||
    fail "a good line after a bad one was not answered"
solve <"$data/refused.jsonl" >"$work/out"
same "$work/out" "$data/refused.out" "the texts of refusals changed"
solve --strict <"$data/refused.jsonl" >/dev/null
[ $? -eq 1 ] || fail "--strict does not tell"
solve --strict <"$data/requests.jsonl" >/dev/null || fail "--strict refuses good replies"

# half a line at the end, bytes that are no text, a line without end
printf '{"id":1,"op":"mass_matrix","q":[0,0,0]}\n{"id":2,"op":"mass_ma' | solve >"$work/out"
[ "$(wc -l <"$work/out")" -eq 2 ] || fail "half a line is not answered"
says "$work/out" 'line 2, column 21: premature end of input'
printf '{"id":1,"op":"mass_matrix","q":[0,0,0]}' | solve >"$work/out"
says "$work/out" '"status":"ok"'
{
    head -c 100000 /dev/urandom | tr -d '\n'
    echo
    printf '\000\000\n{"id":3,"op":"mass_matrix","q":[0,0,0]}\n'
} | solve >"$work/out"
[ "$(wc -l <"$work/out")" -eq 3 ] || fail "binary garbage is not answered line by line"
says "$work/out" '{"id":3,"status":"ok"'
{
    head -c 50000000 /dev/zero | tr '\000' ' '
    printf '\n{"id":4,"op":"mass_matrix","q":[0,0,0]}\n'
} | solve >"$work/out"
says "$work/out" 'line 1: longer than 16777216 bytes'
says "$work/out" '{"id":4,"status":"ok"'

# replies are not held back: the first is there while the input is still open
mkfifo "$work/in" "$work/pipe"
"$tool" solve "$data/arm.urdf" <"$work/in" >"$work/pipe" &
child=$!
exec 3>"$work/in" 4<"$work/pipe"
echo '{"id":1,"op":"mass_matrix","q":[0,0,0]}' >&3
IFS= read -r reply <&4
case $reply in
    '{"id":1,"status":"ok"'*) ;;
    *) fail "no reply while the input is open: $reply" ;;
esac

# and when nobody reads them any more, the program ends
exec 4<&-
echo '{"id":2,"op":"mass_matrix","q":[0,0,0]}' >&3
wait $child
[ $? -eq 2 ] || fail "a reader that went away is not a failure"
exec 3>&-
finish
