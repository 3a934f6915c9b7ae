# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Arrays of the DDS types Request and Reply are the inputs and outputs of lib/interface/fields.h.
set -eu
source=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# arrays STRUCT: its sequences, but those of indices
arrays() {
    sed -n "/^        struct $1 {/,/^        };/s/^ *sequence<[A-Za-z ]*> *\([a-z_]*\);.*/\1/p" \
        "$source/idl/totalforce.idl" | grep -v '^tips$\|_frames$' | sort
}
# members LIST COLUMN: a column of the rows of a list
members() {
    sed -n "/^#define $1(X)/,/^$/s/^    X(\([^)]*\).*/\1/p" "$source/lib/interface/fields.h" |
        cut -d, -f"$2" | tr -d ' ' | sort
}
arrays Request >"$work/request"
members TFA_INPUT_LIST 2 | diff "$work/request" -
arrays Reply | grep -v '^answers$' >"$work/reply"
members TFA_OUTPUT_WORD_LIST 2 | diff "$work/reply" -
[ "$(wc -l <"$work/request")" -ge 15 ] && [ "$(wc -l <"$work/reply")" -ge 31 ]
