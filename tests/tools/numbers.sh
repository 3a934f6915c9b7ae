# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Numbers on the command line are read whole or refused: every option of every command that takes
# one, as --help lists them, so that a new option is tested from its first day. Those of commands in
# Python have the readers of totalforce_tools/command.py: tests/python/commands.py.
. "$(dirname "$0")/check.sh"

arm=$data/arm.urdf

# refused COMMAND OPTION VALUE: the exit status of a wrong command line, and a message that names
# the option; VALUE is what follows the '='
refused() {
    case $1 in
        chain) positional=random ;;
        model | solve | specialise) positional=$arm ;;
        call | latency) positional=arm ;;
        *) positional= ;;
    esac
    # shellcheck disable=SC2086
    message=$("$tool" "$1" $positional "--$2=$3" 2>&1 >/dev/null </dev/null)
    found=$? # a command that takes it may run for long
    [ $found -eq 3 ] || fail "$1 --$2='$3' ends with $found, not 3"
    case $message in
        *"--$2"*) ;;
        *) fail "$1 --$2='$3': the message does not name the option" ;;
    esac
}
ulimit -t 60 # seconds of a processor

never="|1e|--1|0x10|1_000| 5|5 |5kg|1;2|nan|inf|1e400|1e-400|one"
whole="$never|1e3|1.5|2.0|+5|-1|010|2,,5|18446744073709551616|99999999999999999999999"
real="$never|2,5|1.2.3"
several="$never|1,2,|,1,2|1,,2|1,2;3|1,2,3,4,5,6,7,8,9,10,11"

options=0
for command in model solve call latency chain specialise; do
    "$tool" $command --help >"$work/help"
    grep -oE -e '--[a-z0-9-]+=[^ ]+' "$work/help" | sed 's/^--//' >"$work/options"
    while IFS='=' read -r option form; do
        prefix=
        case $form in
            N | MS | '0|1|2|3') spellings=$whole ;;
            X | M | ANGLE) spellings=$real ;;
            X,Y,Z) spellings=$several ;;
            JOINT=VALUE) spellings=$several prefix=elbow= ;;
            LINK:MASS*) spellings=$several prefix=tool: ;;
            LIST) case $option in bodies | threads) spellings=$whole ;; *) continue ;; esac ;;
            *) continue ;;
        esac
        options=$((options + 1))
        # the words between the bars
        rest="$spellings|"
        while [ -n "$rest" ]; do
            refused $command "$option" "$prefix${rest%%|*}"
            rest=${rest#*|}
        done
    done <"$work/options"
done
[ $options -ge 29 ] || fail "only $options options take numbers"

# and what is good is taken as it stands
status 0 "$tool" chain random --seed 18446744073709551615 --bodies 2
says "$work/out" " -s 18446744073709551615 "
status 0 "$tool" chain heavy-tip --mass-ratio 2.5E+2 --bodies 2
says "$work/out" '<mass value="250"/>'
status 0 "$tool" model --json "$arm" --gravity=-0.5,+1,.25
tr -d ' \n' <"$work/out" >"$work/json"
says "$work/json" '"gravity":[-0.5,1.0,0.25]'
finish
