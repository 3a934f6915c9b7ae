# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# What `totalforce model` says about files, line by line, and its exit status.
#
#   corpus.sh TOOL FILES EXPECTED            compares; 77 when there are no files
#   corpus.sh TOOL FILES EXPECTED --update   writes EXPECTED anew and shows what changed
#
# EXPECTED holds NAME.expect for each file of FILES: for each run a line "$ FILE OPTIONS", what
# standard error has, and "exit N". The lines with $ say which runs there are. The same messages
# must be in "messages" of --json.
set -u
tool=$1
files=$2
expected=$3
update=${4:-}
[ -d "$files" ] || {
    echo "skipped: no folder $files"
    exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$files" || exit 1
failures=0

# messages FILE: as standard error shows them, from the JSON report
messages() {
    awk -v file="$1" '
        function value(s) {
            sub(/^ *"[a-z]*": "?/, "", s)
            sub(/"?,?$/, "", s)
            gsub(/\\"/, "\"", s)
            gsub(/\\\\/, "\\", s)
            return s
        }
        /^  "message_counts"/ { exit }
        /^      "severity":/ { severity = value($0) }
        /^      "line":/ { line = value($0) }
        /^      "code":/ { code = value($0) }
        /^      "text":/ {
            print file (line > 0 ? ":" line : "") ": " severity ": " value($0) " [" code "]"
        }'
}

# run NAME.expect: all its runs
run() {
    grep '^\$ ' "$1" | while read -r _ file options; do
        echo "\$ $file${options:+ $options}"
        # shellcheck disable=SC2086 # options are words
        "$tool" model --notes "$file" $options >"$work/out" 2>"$work/err" </dev/null
        verdict=$?
        cat "$work/err"
        echo "exit $verdict"
        # shellcheck disable=SC2086
        "$tool" model --json "$file" $options 2>/dev/null </dev/null | messages "$file" |
            diff "$work/err" - || echo "the messages of --json differ"
    done
}

for want in "$expected"/*.expect; do
    run "$want" >"$work/found"
    diff -u "$want" "$work/found" && continue
    failures=$((failures + 1))
    [ "$update" = --update ] && cp "$work/found" "$want"
done
for file in *.*; do
    name=${file%%.*}
    case $file in
    *.expect | *.md | *.yaml) continue ;;
    esac
    grep -qF "\$ $file" "$expected/$name.expect" 2>/dev/null || {
        echo "FAILED: no $name.expect that runs $file"
        failures=$((failures + 1))
    }
done
echo "$(find "$expected" -name '*.expect' | wc -l) files, $failures differ"
[ "$failures" -eq 0 ]
