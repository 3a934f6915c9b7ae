#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Runs the README: its programs and its shell commands, taken from its text, in the order in which
# they stand there, as a newcomer would, in a folder of its own. A block of a language that is not
# known here is an error, so no block can be forgotten.
#
#   readme.sh SOURCE_FOLDER BUILD_FOLDER
set -eu
source=$1
build=$2
scratch=$(mktemp -d)
finish() {
    status=$?
    # the daemon's process id, while it runs
    [ ! -s "$scratch/daemon" ] || kill -TERM "$(cat "$scratch/daemon")" 2>/dev/null || true
    rm -rf "$scratch"
    exit $status
}
trap finish EXIT
trap 'exit 130' INT TERM
fail() {
    echo "readme: $*"
    exit 1
}

# What is not run here, by how the line begins, and why.
cat >"$scratch/skipped" <<'SKIPPED'
tools/demo|builds everything and runs for a minute; a stage of tools/test
tools/test|runs this test
tools/setup --peers|installs packages as root
build/peers/bin/bench_suite|needs the peers
build/peers/bin/totalforce chart|needs the peers, and minutes
SKIPPED

# Programs go to their files, named in the first line; commands to one script. After a daemon was
# started, the script waits until a client can connect.
awk -v folder="$scratch" '
    function complain(text) { print "readme: line " NR ": " text; bad = 1 }
    BEGIN {
        while ((getline line < (folder "/skipped")) > 0)
            skip[substr(line, 1, index(line, "|") - 1)] = substr(line, index(line, "|") + 1)
        script = folder "/script"
        print "set -eo pipefail" > script
    }
    /^```/ && !inside {
        inside = substr($0, 4)
        file = ""
        if (inside !~ /^(sh|c|cmake|json)$/)
            complain("a block of language \"" inside "\"")
        next
    }
    /^```/ { inside = ""; next }
    !inside && /^(    |\t|\$ )/ { complain("a command outside of a block: " $0) }
    inside == "c" || inside == "cmake" {
        if (file == "") {
            if (!match($0, /[A-Za-z]+\.(c|txt)/))
                complain("the first line of a program names its file")
            file = substr($0, RSTART, RLENGTH)
            print "cp \"" folder "/" file "\" ." > script
        }
        print > (folder "/" file)
    }
    inside == "sh" {
        for (prefix in skip)
            if (index($0, prefix) == 1) {
                print "echo \"skipped: " prefix ": " skip[prefix] "\"" > script
                seen[prefix] = 1
                next
            }
        print > script
        commands++
        if (/& daemon=\$!/)
            print "await" > script
    }
    END {
        for (prefix in skip)
            if (!(prefix in seen))
                complain("nothing begins with \"" prefix "\"")
        print "readme: " commands " lines of commands"
        exit bad
    }' "$source/README.md" || exit 1

# A newcomer has the source folder, built, and an environment without any of ours. DDS keeps to
# ports and a tag of its own: other daemons of domain 0 on this machine are not met.
mkdir -p "$scratch/home" "$scratch/source/build" "$scratch/run" "$scratch/bin"
cp -rL "$source/config" "$source/idl" "$scratch/source"
ln -s "$build" "$scratch/source/build/release"
sed -i "s|<Discovery>|&<Ports><Base>$((8000 + $$ % 90 * 250))</Base></Ports>|" \
    "$scratch/source/config/dds/local.xml"
compiler=$(sed -n 's/^CMAKE_C_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
cat >"$scratch/bin/cc" <<CC
#!/bin/sh
# what idlc writes is not ours to judge
case "\$*" in *totalforce.c*) warn=-w ;; *) warn="-Wall -Wextra -Werror" ;; esac
exec "$compiler" -std=gnu17 \$warn "\$@"
CC
chmod +x "$scratch/bin/cc"
cat >"$scratch/run.sh" <<'RUN'
await() {
    echo $daemon >"$SCRATCH/daemon"
    turn=0
    until [ -S "$TOTALFORCE_RUNTIME_DIR/arm.sock" ]; do
        turn=$((turn + 1))
        [ $turn -le 300 ] && kill -0 $daemon
        sleep 0.1
    done
}
cd "$SCRATCH/source"
. "$SCRATCH/script"
wait $daemon
: >"$SCRATCH/daemon"
RUN
environment() {
    timeout 200 env -i HOME="$scratch/home" PATH="$scratch/bin:$PATH" SCRATCH="$scratch" \
        TOTALFORCE_RUNTIME_DIR="$scratch/run" ROBOT_TAG="readme-$$" "$@"
}
environment bash "$scratch/run.sh" >"$scratch/out" 2>"$scratch/err" || {
    cat "$scratch/out" "$scratch/err"
    fail "a command failed"
}

# The programs are of one opinion: the second acceleration by library, ring and DDS.
second=$(grep '^[a-z_0-9]* [-+][0-9.]* rad/s^2$' "$scratch/out" | sed -n '2s/^[^ ]* //p')
[ -n "$second" ] || fail "the library gives no accelerations"
for say in "^[a-z_0-9]* $second\$" "^$second\$" "^sample [0-9]*: qdd.1. $second\$"; do
    grep -q "$say" "$scratch/out" || {
        cat "$scratch/out"
        fail "no line '$say'"
    }
done
says() {
    grep -q "$2" "$1" || {
        cat "$1"
        fail "nothing says '$2'"
    }
}
says "$scratch/err" 'dds: domain 0, 1 robots: totalforce/request'
says "$scratch/err" 'dds: requests [1-9]'

# Every subcommand of the table exists.
sed -n 's/^| `totalforce \([a-z]*\).*/\1/p' "$source/README.md" >"$scratch/subcommands"
[ "$(wc -l <"$scratch/subcommands")" -ge 9 ] || fail "the table of subcommands is not found"
while read -r subcommand; do
    "$build/bin/totalforce" "$subcommand" --help >"$scratch/help" ||
        fail "totalforce $subcommand is in the table and does not exist"
done <"$scratch/subcommands"

# Without the robot's file and without a daemon the programs say what is missing, and where.
cd "$scratch"
for door in one two; do
    if environment LD_LIBRARY_PATH="$scratch/home/totalforce/lib" "$scratch/home/try/$door" \
        2>"$scratch/err"; then
        fail "$door succeeds without what it needs"
    fi
    case $door in
    one) says "$scratch/err" 'config/robots/arm7.urdf.*No such file' ;;
    two) says "$scratch/err" "no daemon listens at $scratch/run/arm.sock: start one" ;;
    esac
done
echo "readme: every command ran, and the three programs are of one opinion"
