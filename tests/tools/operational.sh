# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Operational space through `totalforce solve`, against computations of another kind: J by unit
# wrenches, forces apart by inverse dynamics, task torques by forward dynamics, a two-link arm by
# hand.
. "$(dirname "$0")/check.sh"

# numbers KEY: of the reply on standard input, of a vector, a matrix or one number, one a line
numbers() {
    grep -oE "\"$1\":[][0-9.,e+-]*" | sed 's/^"[^"]*"://' | tr -d '[]' | tr ',' '\n' | sed '/^$/d'
}

# solve1 OPTIONS: one request on standard input, which must be answered
solve1() {
    # shellcheck disable=SC2086
    "$tool" solve $robot "$@" 2>"$work/err" >"$work/reply"
    grep -q '"status":"ok"' "$work/reply" || fail "refused: $(cat "$work/reply" "$work/err")"
    cat "$work/reply"
}

# multiply A ROWS B COLUMNS: product of matrices in files of numbers
multiply() {
    awk -v rows="$2" -v columns="$4" '
        FNR == NR { a[na++] = $1; next }
        { b[nb++] = $1 }
        END {
            inner = na / rows
            for (i = 0; i < rows; i++)
                for (j = 0; j < columns; j++) {
                    x = 0
                    for (k = 0; k < inner; k++)
                        x += a[i * inner + k] * b[k * columns + j]
                    printf "%.17g\n", x
                }
        }' "$1" "$3"
}

# add A B: sum of the numbers of two files
add() {
    paste "$1" "$2" | awk '{ printf "%.17g\n", $1 + $2 }'
}

units() {
    awk 'BEGIN { for (i = 0; i < 6; i++) for (j = 0; j < 6; j++) printf "%d%s", i == j, j < 5 ? "," : "\n" }'
}

# ---- laws, on a fixed and on a floating robot ----

# laws NAME STATE TIP FREEDOMS OPTIONS: $robot and options of the command line
laws() {
    name=$1
    state=$2
    tip=$3
    n=$4
    shift 4
    for frame in world local local_world_aligned; do
        echo "{\"op\":\"kinematics\",$state,\"tips\":[\"$tip\"],\"frame\":\"$frame\",\"want\":[\"jacobian\",\"twist\",\"bias_acceleration\",\"pose\",\"poses\"]}" |
            solve1 "$@" >"$work/kinematics"
        numbers jacobian <"$work/kinematics" >"$work/J"
        # a wrench needs -J^T wrench of inverse dynamics without gravity and motion
        units | while IFS= read -r wrench; do
            echo "{\"op\":\"inverse_dynamics\",$rest,\"gravity\":[0,0,0],\"frame\":\"$frame\",\"wrench\":{\"$tip\":[$wrench]}}" |
                solve1 "$@" >"$work/id"
            { numbers base_wrench <"$work/id"; numbers tau <"$work/id"; } | awk '{ printf "%.17g\n", -$1 }'
        done >"$work/want"
        near "$work/J" "$work/want" 1e-13 "$name, $frame: J by unit wrenches"
        numbers twist <"$work/kinematics" >"$work/twist"
        multiply "$work/J" 6 "$work/v" 1 >"$work/want"
        near "$work/twist" "$work/want" 1e-13 "$name, $frame: twist is not J v"

        # the tip accelerates as it should, whatever the posture torques
        echo "{\"op\":\"task_torques\",$state,\"frame\":\"$frame\",\"acceleration\":{\"$tip\":[1,-2,3]},\"posture_torques\":$posture}" |
            solve1 "$@" >"$work/task"
        tau=$(grep -o '"tau":[^]]*]' "$work/task")
        wrench=$(grep -o '"base_wrench":[^]]*]' "$work/task")
        echo "{\"op\":\"forward_dynamics\",$state,\"rows\":\"point\",\"tips\":[\"$tip\"],\"frame\":\"$frame\",\"want\":[\"jacobian\",\"bias_acceleration\"],$tau${wrench:+,}$wrench}" |
            solve1 "$@" >"$work/fd"
        { numbers base_acceleration <"$work/fd"; numbers qdd <"$work/fd"; } >"$work/qdd"
        numbers jacobian <"$work/fd" >"$work/J3"
        head -$((3 * n)) "$work/J" >"$work/want"
        same "$work/J3" "$work/want" "$name, $frame: rows of a point"
        numbers bias_acceleration <"$work/fd" >"$work/Jdot"
        numbers bias_acceleration <"$work/kinematics" | head -3 >"$work/want"
        near "$work/Jdot" "$work/want" 1e-13 "$name, $frame: bias acceleration of a point"
        multiply "$work/J3" 3 "$work/qdd" 1 >"$work/Jqdd"
        add "$work/Jqdd" "$work/Jdot" >"$work/a"
        printf '1\n-2\n3\n' >"$work/b"
        near "$work/a" "$work/b" 1e-10 "$name, $frame: the tip does not accelerate as asked"
    done

    # one pose is the other
    numbers pose <"$work/kinematics" >"$work/a"
    sed 's/.*"poses"://' "$work/kinematics" | numbers "$tip" >"$work/b"
    near "$work/a" "$work/b" 1e-14 "$name: pose and poses"

    # gravity: torques at rest; velocity: without gravity; all: inverse dynamics
    echo "{\"op\":\"bias\",$state,\"wrench\":{\"$tip\":[1,2,3,4,5,6]}}" | solve1 "$@" >"$work/bias"
    for term in gravity velocity external; do
        { numbers base_$term <"$work/bias"; numbers $term <"$work/bias"; } >"$work/$term"
    done
    for inputs in "$rest|gravity" "$state,\"gravity\":[0,0,0]|velocity" \
        "$rest,\"gravity\":[0,0,0],\"wrench\":{\"$tip\":[1,2,3,4,5,6]}|external"; do
        echo "{\"op\":\"inverse_dynamics\",${inputs%|*}}" | solve1 "$@" >"$work/id"
        { numbers base_wrench <"$work/id"; numbers tau <"$work/id"; } >"$work/want"
        near "$work/${inputs##*|}" "$work/want" 1e-12 "$name: ${inputs##*|} by inverse dynamics"
    done

    # energy is v^T M v / 2, linear momentum mass times velocity, com_velocity com_jacobian v
    echo "{\"op\":\"mass_matrix\",$state,\"want\":[\"com\",\"momentum\",\"energy\"]}" |
        solve1 "$@" >"$work/whole"
    numbers M <"$work/whole" >"$work/M"
    multiply "$work/M" "$n" "$work/v" 1 >"$work/Mv"
    multiply "$work/v" 1 "$work/Mv" 1 | awk '{ print $1 / 2 }' >"$work/a"
    numbers kinetic <"$work/whole" >"$work/b"
    near "$work/b" "$work/a" 1e-5 "$name: kinetic energy"
    numbers com_velocity <"$work/whole" >"$work/velocity"
    numbers com_jacobian <"$work/whole" >"$work/J"
    multiply "$work/J" 3 "$work/v" 1 >"$work/want"
    near "$work/velocity" "$work/want" 1e-13 "$name: velocity of the centre of mass"
    mass=$(numbers mass <"$work/whole")
    awk -v m="$mass" '{ printf "%.17g\n", m * $1 }' "$work/velocity" >"$work/want"
    numbers momentum <"$work/whole" | head -3 >"$work/a"
    near "$work/a" "$work/want" 1e-12 "$name: linear momentum"
    # potential: what the centre of mass weighs
    numbers potential <"$work/whole" >"$work/a"
    numbers com <"$work/whole" | awk -v m="$mass" 'NR == 3 { printf "%.17g\n", 9.80665 * m * $1 }' >"$work/want"
    near "$work/a" "$work/want" 1e-12 "$name: potential energy"
}

robot=$data/arm.urdf
rest='"q":[0.1,-0.4,0.2]'
posture='[5,-3,1]'
printf '0.5\n-1\n0.3\n' >"$work/v"
laws arm "$rest,\"v\":[0.5,-1,0.3]" tool 3
rest='"q":[0.1,-0.4,0.2],"base_pose":[1,2,3,0.6,0,0,0.8]'
printf '0.1\n0.2\n0.3\n-0.1\n-0.2\n-0.3\n0.5\n-1\n0.3\n' >"$work/v"
laws floater "$rest,\"v\":[0.5,-1,0.3],\"base_twist\":[0.1,0.2,0.3,-0.1,-0.2,-0.3]" tool 9 --base floating
robot=$data/cart.urdf
rest='"q":[1,2,0.3,0.4,0,0,1,0,0.6,0,0.8]'
posture='{"hinge":1,"flight":[1,2,3,4,5,6]}'
printf '0.1\n0.2\n0.3\n-0.4\n1\n2\n3\n-4\n5\n6\n' >"$work/v"
laws cart "$rest,\"v\":[0.1,0.2,0.3,-0.4,1,2,3,-4,5,6]" drone 10
robot=$data/hand.urdf
rest='"q":[0.1,0.2,0.01]'
posture='[1,2,3]'
printf '1\n2\n0.1\n' >"$work/v"
laws hand "$rest,\"v\":[1,2,0.1]" left 3 --mimic project --lock-massless-leaves

# ---- damping and armature ----

robot=$data/hand.urdf
state='"q":[0.1,0.2,0.01],"v":[1,2,0.1]'
echo "{\"op\":\"bias\",$state,\"qdd\":[3,2,1]}" | solve1 --damping --mimic project --lock-massless-leaves >"$work/bias"
echo "{\"op\":\"inverse_dynamics\",$state}" | solve1 --damping --mimic project --lock-massless-leaves | numbers tau >"$work/with"
echo "{\"op\":\"inverse_dynamics\",$state}" | solve1 --mimic project --lock-massless-leaves | numbers tau >"$work/without"
paste "$work/with" "$work/without" | awk '{ printf "%.17g\n", $1 - $2 }' >"$work/want"
numbers damping <"$work/bias" >"$work/a"
near "$work/a" "$work/want" 1e-9 "damping torques"
numbers armature <"$work/bias" >"$work/a"
[ "$(wc -l <"$work/a")" -eq 3 ] || fail "no armature torques"
numbers gravity <"$work/bias" >"$work/a"
numbers velocity <"$work/bias" >"$work/b"
add "$work/a" "$work/b" >"$work/sum"
near "$work/sum" "$work/without" 1e-12 "gravity and velocity torques are not the inverse dynamics"

# ---- two links by hand: 1 m each, point masses 2 kg and 1 kg at their ends, in the plane x z ----

link() {
    echo "<link name=\"$1\"><inertial><origin xyz=\"1 0 0\"/><mass value=\"$2\"/>
      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial></link>"
}
cat >"$work/two.urdf" <<XML
<robot name="two"><link name="base"/>$(link upper 2)$(link lower 1)<link name="tip"/>
  <joint name="a" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/></joint>
  <joint name="b" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="1 0 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="c" type="fixed"><parent link="lower"/><child link="tip"/><origin xyz="1 0 0"/></joint>
</robot>
XML
robot=$work/two.urdf
# a = 0, b = 90 degrees: the masses are at (1, 0) and (1, 1); v = (2, 3)
echo '{"op":"bias","q":[0,1.5707963267948966],"v":[2,3],"gravity":[0,0,-10],"tips":["tip"],"rows":"point","want":["com","momentum","energy","twist","jacobian","bias_acceleration","pose"]}' |
    solve1 >"$work/two"
# hand KEY NUMBER...
hand() {
    key=$1
    shift
    numbers "$key" <"$work/two" | awk '{ printf "%.9f\n", $1 + 1e-12 }' >"$work/a"
    printf '%.9f\n' "$@" >"$work/b"
    same "$work/a" "$work/b" "two links: $key is $(tr '\n' ' ' <"$work/a")"
}
hand com 1 0 0.333333333333
hand mass 3
hand com_velocity -1.666666666667 0 2
hand com_jacobian -0.333333333333 -0.333333333333 0 0 1 0
hand momentum -5 0 6 0 -3.333333333333 0
hand kinetic 18.5
hand potential 10
hand twist -5 0 2 0 -5 0
hand jacobian -1 -1 0 0 1 0
# the elbow turns with 2 rad/s, the tip about it with 5
hand bias_acceleration -4 0 -25
hand gravity 30 0
# 1 kg pulls with 25 N down and 4 N to the left, 2 kg with 8 N to the left
hand velocity -21 4
hand pose 1 0 1 0 -0.707106781187 0 0.707106781187

# ---- lambda ----

robot=$data/arm.urdf
echo '{"op":"operational_inertia","q":[0.1,-0.4,0.2],"v":[0.5,-1,0.3],"tips":["tool"],"rows":"point","want":["lambda","mu","p"]}' |
    solve1 >"$work/three"
numbers lambda <"$work/three" >"$work/lambda"
numbers lambda_inv <"$work/three" >"$work/inverse"
multiply "$work/lambda" 3 "$work/inverse" 3 >"$work/a"
printf '1\n0\n0\n0\n1\n0\n0\n0\n1\n' >"$work/b"
near "$work/a" "$work/b" 1e-12 "lambda times lambda_inv"
# three joints, three rows: J^T (mu + p) holds the robot
echo '{"op":"bias","q":[0.1,-0.4,0.2],"v":[0.5,-1,0.3],"tips":["tool"],"rows":"point","want":["jacobian","bias_acceleration"]}' |
    solve1 >"$work/bias"
numbers jacobian <"$work/bias" >"$work/J"
numbers p <"$work/three" >"$work/p"
multiply "$work/p" 1 "$work/J" 3 >"$work/a"
numbers gravity <"$work/bias" >"$work/b"
near "$work/a" "$work/b" 1e-12 "J^T p is not the gravity torque"
# mu = Lambda (J M^-1 h - J-dot v) = J^-T h - Lambda J-dot v
numbers bias_acceleration <"$work/bias" >"$work/Jdot"
multiply "$work/lambda" 3 "$work/Jdot" 1 >"$work/LJ"
numbers mu <"$work/three" >"$work/mu"
add "$work/mu" "$work/LJ" >"$work/sum"
multiply "$work/sum" 1 "$work/J" 3 >"$work/a"
numbers velocity <"$work/bias" >"$work/b"
near "$work/a" "$work/b" 1e-12 "mu is not the velocity force"

# rank: three joints do not move six ways; damping and truncation answer, refusal does not
lost() {
    echo '{"op":"task_torques","q":[0.1,-0.4,0.2],"acceleration":{"tool":[0,0,1,0,0,0]},"rank_loss":"'"$1"'"}' |
        "$tool" solve "$robot" >"$work/$1"
}
lost truncate
lost damp
lost refuse
says "$work/truncate" '"rank":3,"threshold":'
says "$work/damp" '"rank":3,"threshold":'
says "$work/refuse" '"code":"E_RANK"'
grep -q '"condition":null' "$work/truncate" "$work/damp" && fail "a condition with rank loss"
grep -q '"lost":\[{"singular_value":' "$work/damp" || fail "the directions that were lost"
grep -qiE '[:,[] *-?(nan|inf)' "$work/truncate" "$work/damp" && fail "a number that JSON has not"
echo '{"op":"task_torques","q":[0.1,-0.4,0.2],"acceleration":{"tool":[0,0,1]},"rank_threshold":0.9}' |
    solve1 >"$work/out"
[ "$(numbers rank <"$work/out")" -lt 3 ] || fail "a threshold of 0.9 keeps every eigenvalue"

# ---- 32 tips ----

tips=$(awk 'BEGIN { for (k = 0; k < 32; k++) printf "%s\"%s\"", k ? "," : "", k % 2 ? "tool" : "plate" }')
echo '{"op":"operational_inertia","q":[0.1,-0.4,0.2],"rows":"point","tips":['"$tips"']}' | solve1 >"$work/many"
[ "$(numbers lambda_inv <"$work/many" | wc -l)" -eq 9216 ] || fail "32 points have not 96 x 96 numbers"
says "$work/many" '"rank":3,'
# the second tip: its own 3 x 3
numbers lambda_inv <"$work/many" | awk 'int((NR - 1) / 96) >= 3 && int((NR - 1) / 96) < 6 && (NR - 1) % 96 >= 3 && (NR - 1) % 96 < 6' >"$work/a"
near "$work/a" "$work/inverse" 1e-13 "a tip among 32 differs from it alone"

# ---- derivatives, against differences of forward dynamics ----

request='"q":[0.1,-0.4,0.2],"v":[0.5,-1,0.3],"tau":[10,-5,2]'
echo "{\"op\":\"derivatives\",$request}" | "$tool" solve "$robot" >"$work/d"
if grep -q '"status":"ok"' "$work/d"; then
    echo "{\"op\":\"mass_matrix\",$request}" | sed 's/,"tau":[^]]*]//' | solve1 | numbers M >"$work/M"
    numbers dqdd_dtau <"$work/d" >"$work/a"
    multiply "$work/a" 3 "$work/M" 3 >"$work/product"
    printf '1\n0\n0\n0\n1\n0\n0\n0\n1\n' >"$work/want"
    near "$work/product" "$work/want" 1e-12 "dqdd_dtau is not the inverse of M"
    # column 2 by central differences in quadruple precision
    difference() {
        for x in "$2" "$3"; do
            echo "{\"op\":\"forward_dynamics\",$request}" | sed "s/\"$1\":\\[\\([^,]*\\),[^,]*,/\"$1\":[\\1,$x,/" |
                solve1 --precision f128 | numbers qdd >"$work/$x"
        done
        paste "$work/$2" "$work/$3" | awk -v h="$4" '{ printf "%.17g\n", ($1 - $2) / h }' >"$work/want"
        numbers "dqdd_d$1" <"$work/d" | awk 'NR % 3 == 2' >"$work/a"
        near "$work/a" "$work/want" 1e-7 "dqdd_d$1"
    }
    difference q -0.3999 -0.4001 0.0002
    difference v -0.9999 -1.0001 0.0002
else
    says "$work/d" '"code":"E_UNSUPPORTED"'
fi
finish
