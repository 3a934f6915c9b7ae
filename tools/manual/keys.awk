# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# totalforced.yaml(5) from `totalforced --print-keys`. Variables: version, date, more. With
# style.awk before it.
BEGIN {
    FS = "\t"
    page = "totalforced.yaml"
    head(page, 5)
    print ".SH NAME\n" page " \\- configuration of totalforced"
    while ((getline line < more) > 0) print line
    print ".SH KEYS"
}
$1 == "key" {
    print ".TP\n.B " roff($2)
    facts = roff($3)
    if ($4 != "") facts = facts "; " $4
    if ($5 != "") facts = facts "; default " roff($5)
    if ($6 != "") facts = facts "; " roff($6)
    if ($7 != "") facts = facts "; unit " roff($7)
    if ($8 == "reload") facts = facts "; a reload may change it"
    if ($8 == "restart") facts = facts "; a change needs a restart"
    print "\\fI" facts "\\fR"
    print ".br\n" marked(unescape($9)) "."
}
END { print ".SH SEE ALSO\n.BR totalforced (8),\n.BR totalforce (1)" }
