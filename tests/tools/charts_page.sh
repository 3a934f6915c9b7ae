# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# docs/charts/make.sh writes the figures of the pages: a quick run fills every table, and the pages as
# they stand have every table and picture they name.
. "$(dirname "$0")/check.sh"

source=$(cd "$(dirname "$0")/../.." && pwd)
pages="charts/README.md atlas/README.md accuracy.md"
for page in $pages; do
    file=$source/docs/$page
    awk -v page=$page '
    /^<!-- made: / { if (open) bad = 1; open = 1; lines = 0; name = $3; next }
    /^<!-- end -->/ { if (!open || !lines) { print page ": no figures: " name; bad = 1 } open = 0 }
    open { lines++ }
    END { exit bad || open }' "$file" || fail "$page: blocks"
    for picture in $(sed -n 's/.*!\[[^]]*\](\([^)]*\)).*/\1/p' "$file"); do
        [ -s "$(dirname "$file")/$picture" ] || fail "$page: no $picture"
    done
done

command -v gnuplot >/dev/null || { echo "gnuplot is not installed: no quick run"; finish; }
status 0 sh "$source/docs/charts/make.sh" "$bin/.." --quick "$work/docs"
grep '^not measured' "$work/err" | grep -vE ': (heavy-tip|light-heavy|thin|taper)-|: (reference|laws)$' &&
    fail "tables that are not written"
for page in $pages; do
    # figures apart, the page is the same
    for file in "$source/docs/$page" "$work/docs/$page"; do
        awk '/^<!-- end -->/ { inside = 0 } !inside { print } /^<!-- made/ { inside = 1 }' "$file"
    done >"$work/both"
    awk '{ line[NR] = $0 } END { for (i = 1; i <= NR / 2; i++) if (line[i] != line[i + NR / 2]) exit 1 }' \
        "$work/both" || fail "$page: text that is not a figure changes"
done
# five mechanisms and three right-hand sides
says "$work/docs/charts/README.md" "| panels | 15 | 15 |"
says "$work/docs/charts/README.md" "(tfa-cr) |"
says "$work/docs/charts/README.md" "MuJoCo"
says "$work/docs/atlas/README.md" "* Alone, wrong by more than 1e-4"
grep -qE '^\| qdd \| 240 \| [0-9]+ \|' "$work/docs/atlas/README.md" || fail "answers of the atlas"
for picture in charts/mechanisms.png charts/precision.png atlas/ratio.png atlas/ratio-tau.png; do
    [ -s "$work/docs/$picture" ] || fail "no $picture"
done
status 3 sh "$source/docs/charts/make.sh"
finish
