# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# What latency.sh, two_robots.sh and warm.sh share, to be sourced with their arguments: a folder for
# the run, daemons in it, all of which end with the script.
build=$1
repetitions=${2:-7}
source=$(cd "$(dirname "$0")/../.." && pwd)
bin=$build/bin
run=$(mktemp -d)
domain=$((180 + $$ % 20))
processes=
finish() {
    status=$?
    for process in $processes; do
        kill -TERM "$process" 2>/dev/null && wait "$process" 2>/dev/null || true
    done
    rm -rf "$run"
    exit $status
}
trap finish EXIT
trap 'exit 130' INT TERM
export CYCLONEDDS_URI="file://$source/config/dds/local.xml"

# start NAME ROBOT ...: a daemon that serves the 7-joint arm by these names; standard input has the
# other keys of its configuration
start() {
    mkdir "$run/$1"
    cat >"$run/$1/bench.yaml"
    printf 'runtime_dir: %s\nrobots:\n' "$run/$1" >>"$run/$1/bench.yaml"
    for robot in "$@"; do
        [ "$robot" = "$1" ] || printf '  - {name: %s, urdf: %s}\n' "$robot" \
            "$source/config/robots/arm7.urdf" >>"$run/$1/bench.yaml"
    done
    "$bin/totalforced" "$run/$1/bench.yaml" 2>"$run/$1/log" &
    processes="$! $processes"
    turn=0
    until [ -S "$run/$1/arm.sock" ]; do
        turn=$((turn + 1))
        [ $turn -le 100 ] && kill -0 $! || { cat "$run/$1/log" >&2; exit 2; }
        sleep 0.1
    done
}

# Of the lines of standard input
median() {
    sort -g | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
}

# part NAME: p50 of a part of the round trip, us, in what `totalforce latency` prints
part() {
    awk -v part="$1" '$1 == part {print $3}'
}
