# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Hosts of a network of their own: . tests/support/namespaces.sh, after wait.sh and `test`, the name
# of the script, whose `finish` kills $namespaces. Exits with 77 where they cannot be made.

skip() {
    echo "$test: skipped: $1" >&2
    exit 77
}

fail() {
    echo "$test: $1" >&2
    tail -n 50 "$work"/*.log >&2
    exit 1
}

in_namespace() {
    pid=$1
    shift
    nsenter --target "$pid" --net "$@"
}

has_entered() {
    [ "$(cat "/proc/$1/comm")" = sleep ]
}

# make_namespaces NAME...: sets each name. A namespace lives as long as its process, which has
# entered it when it is another program.
make_namespaces() {
    command -v ip >/dev/null && command -v bridge >/dev/null || skip "no iproute2"
    unshare --net true 2>/dev/null || skip "not allowed to make network namespaces"
    for name in "$@"; do
        unshare --net sleep infinity </dev/null >/dev/null 2>&1 &
        eval "$name=$!"
        namespaces="$namespaces $!"
    done
    for p in $namespaces; do
        wait_for has_entered "$p" || skip "no network namespace"
    done
}

# make_bridge: br0 in $switch
make_bridge() {
    in_namespace "$switch" ip link add br0 type bridge mcast_snooping 0 2>/dev/null ||
        skip "the kernel has no bridge"
    in_namespace "$switch" ip link set br0 up
}
