# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# roff for the manual pages.

# Fields of --print-options
function unescape(text) {
    gsub(/\\n/, "\n", text)
    gsub(/\\\\/, "\\", text)
    return text
}
# Plain text as roff: hyphens as on the command line, no request at the start of a line
function roff(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    gsub(/'/, "\\(aq", text)
    gsub(/\^/, "\\(ha", text)
    gsub(/~/, "\\(ti", text)
    sub(/^\./, "\\\\\\&.", text)
    return text
}
# The same with `commands` in bold
function marked(text,    out, k, parts, count) {
    count = split(text, parts, "`")
    for (k = 1; k <= count; k++)
        out = out (k % 2 ? roff(parts[k]) : "\\fB" roff(parts[k]) "\\fR")
    return out
}
function sentence(text) { return toupper(substr(text, 1, 1)) substr(text, 2) }

# Lines as paragraphs; lines "  WORD: TEXT" or "  WORD  TEXT" as a list, in which lines that are
# indented further go on with an entry
function body(text,    rows, count, k, out, end, row, begun) {
    count = split(text, rows, "\n")
    for (k = 1; k <= count; k++) {
        row = rows[k]
        if (row ~ /^   /) {
            sub(/^ +/, "", row)
            out = out marked(row) "\n"
        } else if (row ~ /^  /) {
            row = substr(row, 3)
            match(row, /^[^ ]*[^ :]/)
            end = RLENGTH
            out = out ".TP\n.B " roff(substr(row, 1, end)) "\n"
            row = substr(row, end + 1)
            sub(/^:? */, "", row)
            out = out (row == "" ? "" : marked(row) "\n")
            begun = 0
        } else if (row != "") {
            out = out (begun ? ".br\n" : ".PP\n") marked(row) "\n"
            begun = 1
        } else {
            begun = 0
        }
    }
    return out
}
function head(page, section) {
    print ".\\\" SPDX-License-Identifier: Apache-2.0"
    print ".\\\" SPDX-FileCopyrightText: The totalforce authors"
    print ".\\\" Written by tools/manual from the tables of the program."
    print ".TH " toupper(page) " " section " " date " \"totalforce " version "\" totalforce"
    print ".nh\n.ad l"
}
