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
for command in model solve call latency; do
    status 0 "$tool" $command --help
    says "$work/out" "Usage: totalforce $command"
    status 3 "$tool" $command
    status 3 "$tool" $command --no-such-option x
    status 3 "$tool" $command one two
done
status 3 "$tool"
status 3 "$tool" dance
says "$work/err" "no command 'dance'"

status 3 "$tool" solve "$data/arm.urdf" --base swimming
says "$work/err" "--base: no 'swimming'; there are fixed, floating"
status 3 "$tool" solve "$data/arm.urdf" --method magic
status 3 "$tool" solve "$data/arm.urdf" --refine 3
status 3 "$tool" solve "$data/arm.urdf" --gravity 0,0
status 3 "$tool" solve "$data/arm.urdf" --precision f16
status 2 "$tool" solve "$data/arm.urdf" --mimic project
says "$work/err" "--mimic project: not supported"
says "$work/err" "E_UNSUPPORTED"
status 0 "$tool" solve "$data/arm.urdf" --mimic free
status 2 "$tool" solve "$work/absent.urdf"
says "$work/err" "absent.urdf"
status 2 "$tool" model "$work/absent.urdf"
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
status 0 "$tool" model --json "$data/arm.urdf"
tr -d ' \n' <"$work/out" >"$work/json"
says "$work/json" '"joints":["shoulder","elbow","rail"]'
says "$work/json" '"body_count":3'
says "$work/json" '"base":"fixed"'
status 0 "$tool" model --json --base floating "$data/arm.urdf"
says "$work/out" '"base": "floating"'

# standard output that cannot be written is a failure, not silence
"$tool" model "$data/arm.urdf" >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "model does not notice a full disk"
says "$work/err" "No space left"
finish
