# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# docs/charts/make.py writes the figures of docs/accuracy.md: a quick run fills every table, and the page as
# it stands has every table and picture it names.
. "$(dirname "$0")/check.sh"

source=$(cd "$(dirname "$0")/../.." && pwd)
page=accuracy.md
file=$source/docs/$page
awk -v page=$page '
/^<!-- made: / { if (open) bad = 1; open = 1; lines = 0; name = $3; next }
/^<!-- end -->/ { if (!open || !lines) { print page ": no figures: " name; bad = 1 } open = 0 }
open { lines++ }
END { exit bad || open }' "$file" || fail "$page: blocks"
for picture in $(sed -n 's/.*!\[[^]]*\](\([^)]*\)).*/\1/p' "$file"); do
    [ -s "$source/docs/$picture" ] || fail "$page: no $picture"
done

status 0 "$source/docs/charts/make.py" "$bin/.." --quick "$work/docs"
says "$work/docs/which-method.md" "| fastest for my arm? | [hero](pictures/hero.svg) | \`auto\`: "
grep '^not measured' "$work/err" | grep -vE ': (reference|laws|depth)$' && fail "tables that are not written"
# figures apart, the page is the same
for text in "$file" "$work/docs/$page"; do
    awk '/^<!-- end -->/ { inside = 0 } !inside { print } /^<!-- made/ { inside = 1 }' "$text"
done >"$work/both"
awk '{ line[NR] = $0 } END { for (i = 1; i <= NR / 2; i++) if (line[i] != line[i + NR / 2]) exit 1 }' \
    "$work/both" || fail "$page: text that is not a figure changes"
# seven mechanisms and three right-hand sides
says "$work/docs/work/blocks/fronts" "| panels | 21 | 21 |"
says "$work/docs/work/blocks/times" "(tfa-cr) |"
says "$work/docs/$page" "| mass ratio of neighbours | 1e"
says "$work/docs/$page" "Of 2376 default requests "
[ -s "$work/docs/pictures/atlas.png" ] || fail "no atlas.png"
for picture in hero:one.call lambda:pv-osimr cores:batch single:mixed drift:integrator singular:wrist \
    ellipsoid:reaching bodies:hessenberg; do
    grep -q "${picture#*:}" "$work/docs/pictures/${picture%:*}.svg" || fail "no ${picture%:*}.svg with its text"
done
status 3 "$source/docs/charts/make.py"
finish
