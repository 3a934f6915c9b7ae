# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce model --advise`: joints that may be locked, and the scene as the daemon reads it.
. "$(dirname "$0")/check.sh"

advise() {
    want=$1
    shift
    status "$want" "$tool" model "$data/arm.urdf" "$@"
}

# a push along the rail, which the others feel a little: what is locked depends on the tolerance
cat >"$work/push.jsonl" <<EOF
{"id":1,"op":"forward_dynamics","q":[0.1,-0.4,0.2],"tau":[0,0,4]}
{"id":2,"op":"forward_dynamics","q":{"rail":0.2,"elbow":-0.4,"shoulder":0.1},"tau":{"rail":5}}
EOF
advise 0 --advise "$work/push.jsonl" --tolerance 0.9 --gravity 0,0,0
cp "$work/out" "$work/loose.yaml"
says "$work/loose.yaml" '# 2 of 3 joints may be locked in 2 states.'
says "$work/loose.yaml" '# Bodies: 1 instead of 3; freedoms: 1 instead of 3.'
says "$work/loose.yaml" '- {joint: "shoulder", q: 0.10000000000000001}'
says "$work/loose.yaml" '- {joint: "elbow", q: -0.40000000000000002}'
says "$work/loose.yaml" 'gravity: [0.0, 0.0, 0.0]'
advise 1 --advise "$work/push.jsonl" --tolerance 1e-9 --gravity 0,0,0
says "$work/out" '# 0 of 3 joints may be locked in 2 states.'
says "$work/err" '--tolerance 1e-09: no joint may be locked'
sed 1q "$work/push.jsonl" | "$tool" model "$data/arm.urdf" --advise - --tolerance 0.9 >"$work/out" ||
    fail "states from standard input"
says "$work/out" 'in 1 state.'

# everything that the command line says of the robot stands in the configuration
echo '{"op":"forward_dynamics","q":[0.1,0.2],"base_pose":[0,0,0,0,0,0,1],"v":[0.1,0]}' >"$work/floating.jsonl"
advise 0 --advise "$work/floating.jsonl" --tolerance 5 --base floating --damping --inertia repair \
    --friction --friction-velocity 0.5 --rotor rail=0.25 --armature rail=0.5 \
    --snap 1e-6 --lock rail=0.3 --payload tool:1,0,0,0.1
cp "$work/out" "$work/all.yaml"
for line in 'base: floating' 'damping: true' 'friction: true' 'friction_velocity: 0.5' \
    '- {joint: "rail", value: 0.25}' '- {joint: "rail", value: 0.5}' 'inertia: repair' 'snap: 9.9999999999999995e-07' \
    '- {joint: "rail", q: 0.29999999999999999}' '- {link: "tool", mass: 1.0, com: [0.0, 0.0, 0.10000000000000001]'; do
    says "$work/all.yaml" "$line"
done
echo '{"op":"forward_dynamics","q":{"hinge":1},"tau":{"hinge":1}}' >"$work/cart.jsonl"
status 0 "$tool" model "$data/cart.urdf" --advise "$work/cart.jsonl" --tolerance 2 --gravity 0,0,0
cp "$work/out" "$work/cart.yaml"
says "$work/cart.yaml" 'pose: [0.0, 0.0, 0.0]'
if [ -x "$bin/totalforced" ]; then
    for file in loose all cart; do
        status 0 "$bin/totalforced" --check "$work/$file.yaml"
    done
fi

# what is no state is refused by name
echo '{"id":7,"op":"mass_matrix","q":[0,0,0]}' >"$work/other.jsonl"
advise 2 --advise "$work/other.jsonl" --tolerance 0.1
says "$work/err" 'a state is forward_dynamics with q, v, tau'
echo '{"id":8,"op":"forward_dynamics","q":[0,0]}' >"$work/short.jsonl"
advise 2 --advise "$work/short.jsonl" --tolerance 0.1
says "$work/err" 'q: 2 values, the robot has 3 joints'
for norm in 1 3; do
    echo '{"op":"forward_dynamics","q":[0,0,0],"base_pose":[0,0,0,0,0,0,'$norm']}'
done >"$work/norm.jsonl"
advise 2 --advise "$work/norm.jsonl" --tolerance 0.1 --base floating
says "$work/err" 'state 2: base_pose[3]: quaternion of norm 3, must be 1'
advise 2 --advise /dev/null --tolerance 0.1
says "$work/err" 'no state in it'
advise 2 --advise "$work/none.jsonl" --tolerance 0.1
says "$work/err" 'No such file'
advise 3 --advise "$work/push.jsonl"
says "$work/err" '--advise and --tolerance go together'
advise 3 --tolerance 0.1
advise 3 --advise "$work/push.jsonl" --tolerance 0.1 --mimic lock
says "$work/err" 'choose free or project'
advise 3 --advise "$work/push.jsonl" --tolerance 0
advise 3 --advise "$work/push.jsonl" --tolerance 0.1 --json
finish
