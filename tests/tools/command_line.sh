# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The command line of `totalforce`: help, exit statuses, and what `model` reports.
. "$(dirname "$0")/check.sh"

status 0 "$tool" --help
says "$work/out" "solve"
says "$work/out" "latency"
status 0 "$tool" --version
says "$work/out" "totalforce "
# those in Python where they are built, which is not with sanitizers
python=$(cd "$bin" && ls totalforce-beam totalforce-chart totalforce-atlas totalforce-drift totalforce-sweep \
    2>/dev/null | sed 's/totalforce-//')
for command in model solve call latency methods chain specialise $python; do
    status 0 "$tool" $command --help
    says "$work/out" "Usage: totalforce $command"
    cp "$work/out" "$work/help"
    status 0 "$tool" $command -h
    same "$work/out" "$work/help" "$command -h is not $command --help"
    status 0 "$tool" help $command
    same "$work/out" "$work/help" "help $command is not $command --help"
done
for command in model solve call latency; do
    status 3 "$tool" $command
    status 3 "$tool" $command --no-such-option x
    status 3 "$tool" $command one two three
done
status 0 "$tool" --help
cp "$work/out" "$work/help"
status 0 "$tool" -h
same "$work/out" "$work/help" "-h is not --help"
status 0 "$tool" help
same "$work/out" "$work/help" "help is not --help"
status 3 "$tool" help solvr
says "$work/err" "no command 'solvr'; nearest: 'solve', "
status 3 "$tool" hlep
says "$work/err" "'help'"
status 0 "$bin/totalforced" -h
says "$work/out" "Usage: totalforced"
status 3 "$tool" chain helx
says "$work/err" "no mechanism 'helx'; nearest: 'helix', "
status 3 "$tool" call arm --method tfacr
says "$work/err" "--method: no 'tfacr'; nearest: 'tfa-cr', "
# the table of methods: a word of every kind of refusal, and JSON that can be read
status 0 "$tool" methods
says "$work/out" "rotor inertia on a main chain"
says "$work/out" "segment scan"
says "$work/out" "in parallel  divide and conquer" # columns stay apart
status 0 "$tool" methods --json
says "$work/out" '{"method":"aba","number":3,"forward_dynamics":true,"lambda_inv":true,"cost":"O(N)",'
"$tool" methods >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "methods does not notice a full disk"
says "$work/err" "totalforce methods: standard output: No space left on device"
status 3 "$tool" methods aba
status 3 "$tool"
status 3 "$tool" dance
says "$work/err" "no command 'dance'"

status 3 "$tool" solve "$data/arm.urdf" --base swimming
says "$work/err" "--base: no 'swimming'; there are fixed, floating"
status 3 "$tool" solve "$data/arm.urdf" --method magic
status 3 "$tool" solve "$data/arm.urdf" --refine 4
status 3 "$tool" solve "$data/arm.urdf" --gravity 0,0
status 3 "$tool" solve "$data/arm.urdf" --precision f16
status 3 "$tool" solve "$data/arm.urdf" --residual f32
status 3 "$tool" solve "$data/arm.urdf" --precision f128 --residual f64
for policy in --mimic=free --mimic=project --mimic=lock --inertia=strict --inertia=warn \
    --inertia=repair --inertia=strict-physical --damping --lock-massless-leaves --rotor-inertia; do
    status 0 "$tool" solve "$data/arm.urdf" $policy
done
status 3 "$tool" solve "$data/arm.urdf" --mimic perhaps
says "$work/err" "--mimic: no 'perhaps'; there are free, project, lock"
"$tool" chain dill --bodies 64 >"$work/dill.urdf"
status 0 "$tool" model "$work/dill.urdf"
says "$work/out" "plan: side branch of 5 bodies from '"
says "$work/out" "more than log2 of its chain's 7: "
status 0 "$tool" model "$data/arm.urdf"
grep -q "side branch" "$work/out" && fail "an arm has no side branch"
status 3 "$tool" model "$data/arm.urdf" --inertia none
says "$work/err" "there are strict, warn, repair, strict-physical"
status 3 "$tool" model "$data/arm.urdf" --lock elbow
says "$work/err" "--lock: 'elbow' is not JOINT=VALUE"
status 3 "$tool" model "$data/arm.urdf" --lock elbow=high
says "$work/err" "--lock: 'high' is not 1 to 7 finite numbers"
status 2 "$tool" model "$data/arm.urdf" --lock elbow=1,2
says "$work/err" "--lock elbow: 2 numbers; the joint has 1 coordinate"
status 2 "$tool" model "$data/arm.urdf" --lock wrist=1
says "$work/err" "joint 'wrist': the scene locks it, but the robot has no such joint; correct the name; nearest: '"
status 0 "$tool" model "$data/arm.urdf" --armature elbow=0.125
says "$work/out" "armature 0.125"
status 2 "$tool" model "$data/arm.urdf" --armature elbov=1
says "$work/err" "--armature: the file has no joint 'elbov'; nearest: 'elbow'"
status 3 "$tool" model "$data/arm.urdf" --armature elbow
says "$work/err" "--armature: 'elbow' is not JOINT=INERTIA"
status 2 "$tool" model "$data/arm.urdf" --armature elbow=-1
says "$work/err" "[bad-armature]"
status 2 "$tool" model "$data/arm.urdf" --tip tol
says "$work/err" "link 'tol': the tip of the scene does not exist; name a link of the robot; nearest: 'tool', "
status 3 "$tool" model "$data/arm.urdf" --payload tool
says "$work/err" "--payload: 'tool' is not LINK:MASS"
status 3 "$tool" model "$data/arm.urdf" --payload tool:1,2
says "$work/err" "--payload tool: 2 numbers, must be 1, 4 or 10"
status 3 "$tool" model "$data/arm.urdf" --payload tool:-1
says "$work/err" "--payload tool: mass -1 must not be negative"
status 3 "$tool" model "$data/arm.urdf" --root upper --root lower
says "$work/err" "--root: given twice"
status 2 "$tool" model "$data/arm.urdf" --tip nowhere
says "$work/err" "link 'nowhere': the tip of the scene does not exist"
# flexible links: files of modes, several of them
flexible=$data/../../../config/robots/flexible_arm
status 0 "$tool" model "$flexible.urdf" --modes "$flexible.yaml"
says "$work/out" "payloads 0, flexible links 2"
says "$work/out" "  lower_beam               mode 3  up to 0.1"
status 0 "$tool" model "$flexible.urdf" --modes "$flexible.yaml" --json
says "$work/out" '"flexible_links": ['
says "$work/out" '"link": "lower_beam",'
sed '/lower_beam":/,$d' "$flexible.yaml" >"$work/upper.yaml"
status 0 "$tool" model "$flexible.urdf" --modes "$work/upper.yaml"
says "$work/out" "flexible links 1"
status 2 "$tool" solve "$flexible.urdf" --modes "$work/upper.yaml" --modes "$flexible.yaml"
says "$work/err" "flexible_arm.urdf: error: link 'upper_beam': its modes are given twice; remove one [modes]"
sed 's/mass: /mas: /' "$work/upper.yaml" >"$work/wrong.yaml"
status 2 "$tool" solve "$flexible.urdf" --modes "$work/wrong.yaml"
says "$work/err" "wrong.yaml:12: error: column 9: links.upper_beam.modes[0]: there is no key 'mas'; write "
status 2 "$tool" model "$flexible.urdf" --modes "$work/absent.yaml" --json
says "$work/out" '"text": "file: cannot be read: No such file or directory"'
# closed loops, contacts, motors
arm7=$data/../../../config/robots/arm7.urdf
cat >"$work/foot.yaml" <<'END'
constraints:
  - {name: foot, second: {link: tool0}, hold: [point, rz], unilateral: true}
  - {name: grip, first: {link: link_3}, second: {link: link_7}, hold: hinge}
END
echo 'actuated: [joint_1, joint_3]' >"$work/motors.yaml"
status 0 "$tool" model "$arm7" --constraints "$work/foot.yaml" --constraints "$work/motors.yaml"
says "$work/out" "  actuated: joint_1 joint_3"
says "$work/out" "      0  foot                     x y z rz  (world) - tool0  unilateral"
says "$work/out" "      1  grip                     hinge  link_3 - link_7"
status 0 "$tool" model "$arm7" --constraints "$work/foot.yaml" --json
says "$work/out" '"actuated": null'
says "$work/out" '"unilateral": true'
says "$work/out" '"open": null' # a contact is no loop
leg=$data/../../../config/robots/loops/rod_leg
status 0 "$tool" model "$leg.urdf" --constraints "$leg.yaml"
says "$work/out" "      1  plantar                  0 0"
grep -q "open-loop" "$work/err" && fail "a closed loop is open"
sed 's/-0.48/-0.4/' "$leg.yaml" >"$work/open.yaml"
status 0 "$tool" model "$leg.urdf" --constraints "$work/open.yaml"
says "$work/err" "rod_leg.urdf: warning: loop 'achilles' is open by 0.08 m, 0 rad at the zero posture"
says "$work/out" " iterations from there; joint 'shin_spring' changes most, by "
sed 's/-0.48/-1.4/' "$leg.yaml" >"$work/open.yaml"
status 0 "$tool" model "$leg.urdf" --constraints "$work/open.yaml" --json
says "$work/out" '"position": 0.91999'
says "$work/out" '"status": "E_OPEN"'
sed 's/hinge/hing/' "$work/foot.yaml" >"$work/wrong.yaml"
status 2 "$tool" solve "$arm7" --constraints "$work/wrong.yaml"
says "$work/err" "wrong.yaml:3: error: column 71: constraints[1].hold: 'hing' is not one of point, hinge, weld"
status 2 "$tool" model "$arm7" --constraints "$work/absent.yaml"
says "$work/err" "cannot be read: No such file or directory"
status 2 "$tool" model "$arm7" --constraints "$work/foot.yaml" --advise - --tolerance 0.1
says "$work/err" "leave out --constraints"
status 3 "$tool" call arm --mimic project
status 2 "$tool" solve "$work/absent.urdf"
says "$work/err" "absent.urdf"
status 2 "$tool" model "$work/absent.urdf"
# names of robots that are no paths, wherever one is given
mkdir -p "$work/ws/share/my_arm"
cp "$data/arm.urdf" "$work/ws/share/my_arm"
for name in 'package://my_arm/arm.urdf' '$(find my_arm)/arm.urdf' '~/share/my_arm/arm.urdf' "file://$work/ws/share/my_arm/arm.urdf"; do
    status 0 env AMENT_PREFIX_PATH="$work/ws" HOME="$work/ws" "$tool" model "$name"
done
[ -z "$python" ] || status 0 env AMENT_PREFIX_PATH="$work/ws" "$tool" sweep package://my_arm/arm.urdf --count 2
status 2 "$tool" model package://my_leg/leg.urdf
says "$work/err" "no package 'my_leg' in AMENT_PREFIX_PATH (not set) or ROS_PACKAGE_PATH (not set)"
status 3 "$tool" latency arm --count 0
status 3 "$tool" latency arm --fail-p99-us -1
status 3 "$tool" latency arm --via pigeon

# a file that is no robot: the message names file and line, with --json too
printf '<robot name="r">\n<link name="a">\n</robot>\n' >"$work/broken.urdf"
status 2 "$tool" model "$work/broken.urdf"
says "$work/err" "broken.urdf:"
status 2 "$tool" model --json "$work/broken.urdf"
says "$work/out" '"status": "error"'

status 0 "$tool" model "$data/arm.urdf"
says "$work/out" "robot 'arm', base fixed"
says "$work/out" "links 6, joints 5 -> bodies 3"
says "$work/out" "mass 6.3 kg moving, 11.3 kg in all"
says "$work/out" "lower <- plate"
says "$work/out" "slide <- tool"

# notes: one line with their number, all of them with --notes; warnings and errors always
status 0 "$tool" model --notes "$data/arm.urdf"
notes=$(grep -c ": note: " "$work/err")
[ "$notes" -gt 1 ] || fail "arm.urdf: $notes notes with --notes"
for view in "" --tree; do
    status 0 "$tool" model $view "$data/arm.urdf"
    [ "$(cat "$work/err")" = "$data/arm.urdf: $notes notes, shown with --notes" ] ||
        fail "model $view: $(cat "$work/err")"
done
status 0 "$tool" model "$data/hand.urdf" --lock-massless-leaves
says "$work/err" "[mimic-free]"
says "$work/err" "notes, shown with --notes"
printf '<robot name="r"><link name="world"/></robot>\n' >"$work/world.urdf"
status 0 "$tool" model "$work/world.urdf"
[ "$(grep -c . "$work/err")" = 1 ] || fail "a robot without notes: $(cat "$work/err")"
says "$work/err" "nothing-moves"
status 0 "$tool" model --json "$data/arm.urdf"
tr -d ' \n' <"$work/out" >"$work/json"
says "$work/json" '"joints":["shoulder","elbow","rail"]'
says "$work/json" '"body_count":3'
says "$work/json" '"base":"fixed"'
status 0 "$tool" model --json --base floating "$data/arm.urdf"
says "$work/out" '"base": "floating"'

# a hand: two joints fused, one that follows, one that is locked, what is ignored
status 0 "$tool" model "$data/hand.urdf" --mimic project --lock-massless-leaves --damping
says "$work/out" "policies: mimic project, inertia strict, damping, massless leaves locked"
says "$work/out" "joints: 1 move, 0 fixed, 1 locked, 2 fused, 1 follow, 0 absent"
says "$work/out" "centre of mass 0.00025 0 0.17 m"
says "$work/out" "swing: part of palm"
says "$work/out" "pitch: part of palm"
says "$work/out" "finger = -1 * thumb + 0.002"
says "$work/out" "palm                            0.6  at 0 0 0.05  gyration 0.0408..0.0577  condition 2"
says "$work/out" "1 warning [massless-leaf-locked]"
status 0 "$tool" model --json "$data/hand.urdf" --mimic project --lock-massless-leaves
tr -d ' \n' <"$work/out" >"$work/json"
says "$work/json" '"fates":{"moves":1,"fixed":0,"locked":1,"fused":2,"follows":1,"absent":0}'
says "$work/json" '"leader":"thumb","multiplier":-1.0,"offset":0.002'
says "$work/json" '"mimic":"project","inertia":"strict","rotor_inertia":false'
says "$work/json" '{"code":"massless-leaf-locked","severity":"warning","count":1}'
says "$work/json" '"ignored":[{"name":"damping","count":1,"line":23,'
says "$work/json" '{"name":"friction","count":1,"line":23,'
says "$work/json" '"regular":true'
says "$work/json" '"scene":null'

# and one finger of it, loaded
status 0 "$tool" model --json "$data/hand.urdf" --root palm --mimic lock --lock swing=0.3 \
    --tip left --payload left:1,0,0,0.1
tr -d ' \n' <"$work/out" >"$work/json"
says "$work/json" '"joints":["thumb"]'
says "$work/json" '"locked":2,"fused":0,"follows":0,"absent":2'
says "$work/json" '"name":"pitch","type":"revolute","fate":"absent","body":null'
says "$work/json" '"scene":{"root":"palm","tips":["left"],"locks":["swing"]'
says "$work/json" '"world_links":["palm","right","antenna"]'

# an inertia put right is told
sed 's/<inertia ixx="0.004"/<inertia ixx="-0.004"/' "$data/arm.urdf" >"$work/bent.urdf"
status 2 "$tool" model "$work/bent.urdf"
says "$work/err" "[inertia-not-positive]"
status 0 "$tool" model "$work/bent.urdf" --inertia repair
says "$work/out" "  repaired"
says "$work/out" "link 'slide': its inertia has the principal moments"
status 0 "$tool" model "$work/bent.urdf" --inertia warn
says "$work/out" "1 warning [inertia-not-positive]"

# the tree: merged links in brackets, joints that share a body, one that follows, branches
status 0 "$tool" model --tree "$data/arm.urdf"
cat >"$work/tree" <<'EOF'
arm  (fixed base)  [base]
`-- upper  (shoulder continuous)  3 kg
    lower  (elbow revolute)  2.5 kg  [plate]
    slide  (rail prismatic)  0.8 kg  [tool]
EOF
same "$work/out" "$work/tree" "the tree of the arm"
status 0 "$tool" model --tree --mimic project --lock-massless-leaves "$data/hand.urdf"
says "$work/out" '`-- palm  (pitch revolute + roll revolute)  0.6 kg  [cross, antenna]'
says "$work/out" '    |-- left  (thumb prismatic)  0.1 kg'
says "$work/out" '    `-- right  (finger prismatic that follows thumb)  0.1 kg'
status 0 "$tool" model --tree --base floating "$data/arm.urdf"
says "$work/out" '`-- base  (floating base)  5 kg'
status 3 "$tool" model --tree --json "$data/arm.urdf"
# branches of branches: as wide as 40 of them, not more
"$tool" chain side-branches --bodies 2000 >"$work/comb.urdf"
status 0 "$tool" model --tree "$work/comb.urdf"
awk 'length > 260 { exit 1 } END { exit NR < 2000 }' "$work/out" || fail "the tree of a comb"

# standard input in place of a file
"$tool" model "$data/arm.urdf" --json >"$work/want" 2>"$work/err"
"$tool" model - --json <"$data/arm.urdf" 2>"$work/err" | sed "s|\"(standard input)\"|\"$data/arm.urdf\"|; s|\"-\"|\"$data/arm.urdf\"|" >"$work/found"
same "$work/found" "$work/want" "model - is not model FILE"
echo '{"op":"mass_matrix","q":[0,0,0]}' >"$work/lines"
"$tool" solve "$data/arm.urdf" <"$work/lines" >"$work/want"
grep -q '"status":"ok"' "$work/want" || fail "no mass matrix"
"$tool" solve "$data/arm.urdf" - <"$work/lines" >"$work/found"
same "$work/found" "$work/want" "solve FILE - is not solve FILE"
"$tool" solve "$data/arm.urdf" "$work/lines" </dev/null >"$work/found"
same "$work/found" "$work/want" "requests from a file"
"$tool" solve - "$work/lines" <"$data/arm.urdf" >"$work/found"
same "$work/found" "$work/want" "a robot from standard input"
status 3 "$tool" solve -
says "$work/err" "the robot comes from standard input: name the file of the requests"
status 2 "$tool" model -
says "$work/err" "(standard input):1: error: "
status 2 "$tool" solve "$data/arm.urdf" "$work/absent.jsonl"
says "$work/err" "absent.jsonl: No such file or directory"

# standard output that cannot be written is a failure, not silence
"$tool" model "$data/arm.urdf" >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "model does not notice a full disk"
says "$work/err" "No space left"
finish
