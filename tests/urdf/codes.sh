# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Each code of a message stands in the table of docs/loading.md and occurs among the expectations.
#
#   codes.sh DOCUMENT FOLDER...
set -eu
document=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# first cells of the table of codes, which ends before the first heading after it
sed -n '/^| code /,/^#/p' "$document" | sed -n 's/^| \(`[^|]*`\) |.*/\1/p' |
    grep -o '`[a-z-]*`' | tr -d '`' | sort -u >"$work/document"
cat $(find "$@" -name '*.expect') | sed -n 's/.* \[\([a-z-]*\)\]$/\1/p' | sort -u >"$work/expected"
# What no URDF can cause: a robot or an option that a program made, faults behind other checks, and
# faults of side files (tests/modes).
cat >"$work/program" <<'END'
bad-base
bad-friction-velocity
bad-gravity
bad-policy
bad-quaternion
bad-snap
bad-type
constraints
internal
modes
no-root
urdfdom
END
bad=0
for code in $(comm -13 "$work/document" "$work/expected"); do
    echo "FAILED: [$code] is not in $document"
    bad=1
done
for code in $(sort "$work/expected" "$work/program" | comm -23 "$work/document" -); do
    echo "FAILED: [$code] of $document occurs in no expectation"
    bad=1
done
echo "$(wc -l <"$work/document") codes"
exit $bad
