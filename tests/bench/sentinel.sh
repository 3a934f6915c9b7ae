#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Cost of the sentinel: the library as it is against the same source without it, in turns in one
# process. Prints a table; its last row is what docs/performance.md says.
#
#   sh tests/bench/sentinel.sh BUILD [--robots FOLDER]       BUILD: a release build with benchmarks; some 3 minutes
set -eu
[ $# -eq 1 ] || { [ $# -eq 3 ] && [ "$2" = --robots ]; } || { sed -n 5,8p "$0" >&2; exit 3; }
source=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$1" && pwd)
bare=$build/without-sentinel
robots=
[ $# -eq 1 ] || robots=$(ls "$3"/*.urdf)

cmake -S "$source" -B "$bare" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS=-DTFA_WITHOUT_SENTINEL \
    >/dev/null
cmake --build "$bare" --target totalforce >/dev/null
cmake --build "$build" --target totalforce bench_suite >/dev/null

config=$source/config/robots
# shellcheck disable=SC2086
"$build/bin/bench_suite" --library "$build/lib/libtotalforce.so" --baseline "$bare/lib/libtotalforce.so" \
    --tasks fd+sentinel,batch-f64+sentinel,lambda+sentinel --turn-us 1000 --rounds 61 \
    "$config/arm7.urdf" "$config/quadruped.urdf" "$config/quadruped.urdf:floating" "$config/humanoid.urdf" \
    "$config/humanoid.urdf:floating" "$config/snake64.urdf" $robots |
    awk -F, '
        $5 != "former" { next }
        { name = $2 == "floating" ? $1 ", floating" : $1 }
        !(name in seen) { seen[name] = 1; row[++n] = name }
        { cost[name, $4] = 100 * (1 / $15 - 1) }
        function median_of(task,    list, m, i, k, x) {
            for (k = 1; k <= n; k++)
                if ((row[k], task) in cost) list[++m] = cost[row[k], task]
            for (i = 2; i <= m; i++)
                for (k = i; k > 1 && list[k] < list[k - 1]; k--) {
                    x = list[k]; list[k] = list[k - 1]; list[k - 1] = x
                }
            return m % 2 ? list[(m + 1) / 2] : (list[m / 2] + list[m / 2 + 1]) / 2
        }
        END {
            print "| robot | forward dynamics | batch of 512 | operational inertia |\n|---|---|---|---|"
            split("fd+sentinel batch-f64+sentinel lambda+sentinel", task, " ")
            for (k = 1; k <= n; k++) {
                printf "| %s", row[k]
                for (t = 1; t <= 3; t++)
                    printf " | " ((row[k], task[t]) in cost ? "%+.1f %%" : "-"), cost[row[k], task[t]]
                print " |"
            }
            printf "| median"
            for (t = 1; t <= 3; t++) printf " | %+.1f %%", median_of(task[t])
            print " |"
        }'
