# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Sourced by the tests of the command: counts what fails, compares texts and numbers.
set -u
bin=$1
data=$2
tool=$bin/totalforce
[ -x "$tool" ] || {
    echo "FAILED: $tool is not built"
    exit 1
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

fail() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

# status WANT COMMAND...: the exit status; output goes to $work/out and $work/err.
status() {
    want=$1
    shift
    "$@" >"$work/out" 2>"$work/err" </dev/null
    found=$?
    [ "$found" -eq "$want" ] || {
        fail "exit status $found, not $want: $*"
        cat "$work/err"
    }
}

# says FILE TEXT: the file contains the text.
says() {
    grep -qF -e "$2" "$1" || {
        fail "'$2' is not in $(basename "$1"):"
        head -c 2000 "$1"
    }
}

# same A B WHAT: the files are equal to the byte.
same() {
    cmp "$1" "$2" || fail "$3"
}

# array KEY: the numbers of "KEY":[...] of the one reply on standard input, one a line.
array() {
    sed -n "s/.*\"$1\":\[\([^]]*\)\].*/\1/p" | tr ',' '\n'
}

# near A B BOUND WHAT: two files of numbers agree, relative 2-norm.
near() {
    paste "$1" "$2" | awk -v bound="$3" '
        { d += ($1 - $2) ^ 2; n += $2 ^ 2; rows++ }
        END { if (!rows || !(sqrt(d) <= bound * (n > 0 ? sqrt(n) : 1))) exit 1 }' ||
        {
            fail "$4"
            paste "$1" "$2"
        }
}

finish() {
    [ "$failures" -eq 0 ] && echo "all good"
    exit $((failures > 0))
}
