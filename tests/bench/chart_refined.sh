#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Times of plain and refined calls in `totalforce chart`. No call may find the factors of its own state
# left by the one before: else refined calls take less than plain ones.
#   sh tests/bench/chart_refined.sh build/release/bin
set -eu
"$1/totalforce" chart --mechanisms random --bodies 128 --methods crba --rhs tau --refine 0,1,2 \
    --budget-ms 10 --seeds 1 | grep -v '^#' | awk -F, '
    NR > 1 { if ($5 == 0) plain = $15
        printf "%d refinements: %s us, %.2f of a plain call\n", $5, $15, $15 / plain }'
