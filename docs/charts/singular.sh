#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Largest torque of a task along paths through three singularities of arm6, damped (the default) and cut
# off: singular.sh TOOL OUTPUT WORK
set -eu
here=$(cd "$(dirname "$0")" && pwd)
source=$(cd "$here/../.." && pwd)
tool=$1 output=$2 work=$3
mkdir -p "$work"
for path in wrist elbow shoulder; do
    for policy in default truncate; do
        awk -v path=$path -v policy=$policy 'BEGIN {
            for (k = 0; k <= 240; k++) {
                x = 10 ^ (-8 + k / 240 * 7.7)
                q = path == "wrist" ? "0.2,-0.9,1.1,0.35," x ",-0.15" : "0.2,-0.9," x ",0.35,0.9,-0.15"
                if (path == "shoulder") # where the wrist is above the first axis
                    q = sprintf("0.2,%.17g,1.1,0.35,0.9,-0.15", 0.94845039650633328 + x)
                printf "{\"id\":%.6g,\"op\":\"task_torques\",\"q\":[%s],\"rank_loss\":\"%s\",", x, q, policy
                printf "\"acceleration\":{\"tool0\":[0.3,-0.2,1,0.5,-1,0.7]}}\n"
            }
        }' | "$tool" solve "$source/config/robots/arm6.urdf" | awk '{
            match($0, /"id":[^,]*/); x = substr($0, RSTART + 5, RLENGTH - 5)
            match($0, /"tau":\[[^]]*/); n = split(substr($0, RSTART + 7, RLENGTH - 7), tau, ",")
            most = 0
            for (j = 1; j <= n; j++) { t = tau[j] < 0 ? -tau[j] : +tau[j]; if (t > most) most = t }
            print x, most
        }' >"$work/$path.$policy"
    done
done
processor=$(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -n 1)
gnuplot -e "work='$work'; output='$output'" \
    -e "note='$processor, $(date +%Y-%m-%d): sh docs/charts/singular.sh'" "$here/singular.gp"
