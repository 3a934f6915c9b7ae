# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The tables of the bash completion from what the programs print. Every file on the command line is
# the output of `totalforce COMMAND --print-options` and named after the command; totalforce and
# totalforced are the programs themselves.
BEGIN { FS = "\t" }
FNR == 1 { command = FILENAME; sub(/.*\//, "", command); order[++count] = command }
$1 == "command" { commands = commands " " $2 }
$1 == "arguments" { arguments[command] = $2 }
$1 == "option" {
    if ($2 != "") options[command] = options[command] " --" $2
    if ($3 != "" && $3 != "?") letters[command] = letters[command] " -" $3
    if ($4 != "") {
        name = $2 == "" ? "" : command ":--" $2
        letter = $3 == "" ? "" : command ":-" $3
        takes = takes "        " name (name != "" && letter != "" ? " | " : "") letter ") echo " \
            quote($4) " ;;\n"
    }
}
$1 == "values" {
    words = ""
    for (k = 3; k <= NF; k++) words = words " " $k
    values = values "        " command ":" $2 ") echo " quote(substr(words, 2)) " ;;\n"
}
function quote(text) { return "'" text "'" }
function table(name, about, rows) {
    print "\n# " about "\n" name "()\n{\n    case $1 in\n" rows "    esac\n}"
}
END {
    for (k = 1; k <= count; k++) {
        c = order[k]
        all = all "        " c ") echo " quote(substr(options[c], 2) letters[c]) " ;;\n"
        first = first "        " c ") echo " quote(arguments[c]) " ;;\n"
    }
    print "_totalforce_commands=" quote(substr(commands, 2) " help")
    table("_totalforce_options", "Options of a command", all)
    table("_totalforce_arguments", "Arguments of a command", first)
    table("_totalforce_takes", "Name of an option's argument", takes)
    table("_totalforce_values", "Words that a name stands for", values)
}
