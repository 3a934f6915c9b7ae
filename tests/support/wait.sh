# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Waiting for a condition, as wait.h: . tests/support/wait.sh

# wait_for COMMAND...: until it succeeds. Fails after five minutes.
wait_for() {
    wait_end=$(($(date +%s) + 300))
    until "$@"; do
        [ "$(date +%s)" -lt $wait_end ] || return 1
        sleep 0.05
    done
}
