# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Manual pages and completion have the options that --help lists, and no others; the page of the
# configuration has the keys of the table; no page has a fault.
. "$(dirname "$0")/check.sh"
pages=$bin/../tools/manual
root=$(dirname "$0")/../..
[ -e "$pages/totalforce.1" ] || {
    echo "SKIP: a cross build without manual pages"
    exit 77
}

# Options as argp's own --help prints them: one a line
options_of_help() {
    "$@" --help | sed -n 's/^ \{2,6\}\(-.*\)/\1/p' | sed 's/  .*//' | tr ' ' '\n' |
        sed 's/[=[].*//; s/,$//' | grep -e '^-' | sort
}
options_of_page() {
    sed -n '/^\.TP$/{n;/^\\fB\\-/{s/\\-/-/g;s/\\f[BRI]//g;p}}' "$1" | tr ' ' '\n' |
        sed 's/=.*//; s/,$//' | grep -e '^-' | grep -v -e '^-h$' | sort
}
options_of_completion() {
    bash -c '. "$1"; _totalforce_options "$2"' bash "$pages/totalforce" "$1" | tr ' ' '\n' | sort
}
# compare NAME PAGE PROGRAM...
compare() {
    name=$1 page=$2
    shift 2
    options_of_help "$@" >"$work/help"
    [ "$(wc -l <"$work/help")" -ge 4 ] || fail "$*: --help lists no options"
    options_of_page "$pages/$page" >"$work/page"
    diff "$work/help" "$work/page" || fail "$page: options differ from those of $* --help"
    grep -v -e '^-?$' "$work/help" >"$work/long"
    options_of_completion "$name" >"$work/completion"
    diff "$work/long" "$work/completion" || fail "completion of $name: options differ"
}
commands=$("$tool" --help | sed -n 's/^  \([a-z]*\)  *[a-z].*/\1/p')
[ "$(echo "$commands" | wc -l)" -ge 13 ] || fail "--help lists no commands"
# those in Python, where it is built
for command in $commands; do
    if "$tool" "$command" --print-options >/dev/null 2>&1; then
        built="${built:-} $command"
    fi
done
commands=$(echo $built | tr ' ' '\n')
for command in $commands; do
    compare "$command" "totalforce-$command.1" "$tool" "$command"
    "$tool" "$command" --help | sed -n 's/^ \([A-Z].*\):$/\1/p' | grep -vx Help >"$work/groups"
    sed -n 's/^\.SS //p' "$pages/totalforce-$command.1" | grep -vx Help | diff "$work/groups" - ||
        fail "totalforce-$command.1: groups differ from those of $command --help"
    grep -q "^.BR totalforce.-$command (1)" "$pages/totalforce.1" ||
        fail "totalforce.1: no $command"
done
compare totalforce totalforce.1 "$tool"
compare totalforced totalforced.8 "$bin/totalforced"
find "$pages" -maxdepth 1 -name 'totalforce-*.1' | wc -l >"$work/count"
[ "$(cat "$work/count")" -eq "$(echo "$commands" | wc -l)" ] || fail "a page without a command"

# keys: the rows of the table in the source against the last words of the paths in the page, once
# each: both frames of a constraint have the same rows
sed -n 's/^    {"\([a-z_0-9]*\)", CONFIG_.*/\1/p' "$root/service/config/config_table.c" |
    sort -u >"$work/rows"
sed -n '/^.SH KEYS/,$s/^\.B \(.*\.\)*\([a-z_0-9]*\)$/\2/p' "$pages/totalforced.yaml.5" |
    sed 's/.*\.//' | sort -u >"$work/keys"
diff "$work/rows" "$work/keys" || fail "totalforced.yaml.5: keys differ from the table"
# names of keys that bear a unit, and their units
"$bin/totalforced" --print-keys | awk -F '\t' '
    BEGIN { unit["ns"] = "ns"; unit["us"] = "us"; unit["ms"] = "ms"; unit["mib"] = "MiB" }
    { n = split($2, words, "_") }
    words[n] in unit && $7 != unit[words[n]] { print $2 }' >"$work/units"
[ ! -s "$work/units" ] || fail "keys whose unit is not that of their name: $(cat "$work/units")"

for page in "$pages"/*.[158]; do
    if command -v mandoc >/dev/null; then
        mandoc -Tlint -Wwarning "$page" >"$work/lint" || fail "$(cat "$work/lint")"
    fi
    if command -v groff >/dev/null; then
        groff -ww -man -Tutf8 "$page" 2>"$work/lint" >/dev/null
        [ ! -s "$work/lint" ] || fail "$page: $(cat "$work/lint")"
    fi
done
finish
