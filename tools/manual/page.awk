# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# A manual page from what PROGRAM --print-options prints. Variables: page (totalforce-model),
# section, what (one line), version, date, command (totalforce model), more (a file of further
# sections), pages (all pages, for SEE ALSO). With style.awk before it.
BEGIN { FS = "\t"; head(page, section) }
$1 == "about" { about = unescape($2) }
$1 == "after" { after = unescape($2) }
$1 == "arguments" { arguments = $2 }
$1 == "group" { sub(/:$/, "", $2); lines = lines paragraph($2) }
$1 == "option" { lines = lines option($2, $3, $4, $5) }
$1 == "command" {
    commands = commands ".TP\n.B " roff($2) "\n" sentence(roff($3)) \
        "; see\n.BR totalforce\\-" $2 " (1).\n"
}

function option(long, short, argument, text,    names) {
    if (short != "") names = "\\fB\\-" roff(short) "\\fR"
    if (short == "?") names = names ", \\fB\\-h\\fR"
    if (short != "" && argument != "") names = names " \\fI" roff(argument) "\\fR"
    if (long != "") names = names (names == "" ? "" : ", ") "\\fB\\-\\-" roff(long) "\\fR" \
        (argument == "" ? "" : "=\\fI" roff(argument) "\\fR")
    text = unescape(text)
    return ".TP\n" names "\n" marked(text) (text ~ /\.$/ ? "" : ".") "\n"
}
# A group of options has a heading, or is a remark if it has no colon at its end
function paragraph(text) {
    return text ~ /\.$/ ? ".PP\n" marked(text) "\n" : ".SS " roff(text) "\n"
}

END {
    print ".SH NAME\n" roff(page) " \\- " roff(what)
    print ".SH SYNOPSIS\n.B " roff(command)
    print (page == "totalforce" ? "\\fICOMMAND\\fR [\\fIOPTION\\fR...]" : \
        "[\\fIOPTION\\fR...] \\fI" roff(arguments) "\\fR")
    print ".SH DESCRIPTION\n" marked(about)
    if (commands == "") printf "%s", body(after)
    else print ".SH COMMANDS\n" commands ".PP\n\\fBtotalforce help COMMAND\\fR lists the options."
    print ".SH OPTIONS\n" lines
    while ((getline line < more) > 0) print line
    count = split(pages, see, " ")
    print ".SH SEE ALSO"
    for (k = 1; k <= count; k++) {
        name = see[k]
        sub(/\.[0-9]$/, "", name)
        if (name != page) list = list (list == "" ? "" : ",\n") ".BR " roff(name) " (" \
            substr(see[k], length(see[k])) ")"
    }
    print list
}
