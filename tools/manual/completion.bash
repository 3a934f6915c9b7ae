# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# bash completion of totalforce and totalforced: the tables above are those of the programs. zsh
# takes it, too: autoload -U bashcompinit; bashcompinit; source FILE

# Robots of the daemons that run: by their sockets
_totalforce_robots()
{
    local folder socket k
    local -a folders=("${XDG_RUNTIME_DIR:-/nonexistent}/totalforce" /run/totalforce)
    [ -z "$TOTALFORCE_RUNTIME_DIR" ] || folders=("$TOTALFORCE_RUNTIME_DIR")
    for ((k = 1; k < COMP_CWORD; k++)); do
        case ${COMP_WORDS[k]} in
            --runtime-dir)
                socket=${COMP_WORDS[k + 1]}
                [ "$socket" != = ] || socket=${COMP_WORDS[k + 2]}
                folders=("$socket")
                ;;
        esac
    done
    for folder in "${folders[@]}"; do
        for socket in "$folder"/*.sock; do
            [ ! -S "$socket" ] || { socket=${socket##*/} && echo "${socket%.sock}"; }
        done
    done
}

# Files whose names end so, and folders; the first line says that these are files
_totalforce_files()
{
    echo :files
    if [ "$1" = FOLDER ]; then
        compgen -d -- "$2"
    elif [ -n "$1" ]; then
        compgen -f -X "!*.$1" -- "$2"
        compgen -d -- "$2"
    else
        compgen -f -- "$2"
    fi
}

# _totalforce_argument COMMAND NAME WORD: an argument of that name, such as FILE.urdf, a|b or
# METHOD,... (a list: its last entry is completed)
_totalforce_argument()
{
    local command=$1 name=$2 word=$3 before='' words
    case $name in *,...)
        name=${name%,...}
        name=${name%'[:X]'}
        case $word in *,*)
            before=${word%,*},
            word=${word##*,}
            ;;
        esac
        ;;
    esac
    words=$(_totalforce_values "$command:$name")
    case $name in
        ROBOT) words=$(_totalforce_robots) ;;
        FILE | SCRIPT) _totalforce_files '' "$word" && return ;;
        FOLDER | DIR) _totalforce_files FOLDER "$word" && return ;;
        PROGRAM) compgen -c -- "$word" && return ;;
        *\|*) words=${name//|/ } ;;
        *.urdf | *.yaml | *.jsonl) _totalforce_files "${name##*.}" "$word" && return ;;
    esac
    compgen -P "$before" -W "$words" -- "$word"
}

# Number of arguments before the cursor that are no options and not theirs
_totalforce_position()
{
    local command=$1 k=$2 count=0 word
    for (( ; k < COMP_CWORD; k++)); do
        word=${COMP_WORDS[k]}
        case $word in
            -?*)
                [ "${COMP_WORDS[k + 1]}" != = ] || { k=$((k + 2)) && continue; }
                [ -z "$(_totalforce_takes "$command:$word")" ] || k=$((k + 1))
                ;;
            *) count=$((count + 1)) ;;
        esac
    done
    echo "$count"
}

# _totalforce_words COMMAND FIRST: possible words at the cursor, one a line; FIRST: place of the
# command's first word
_totalforce_words()
{
    local command=$1 word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} name
    local -a names
    [ "$word" != = ] || word=''
    [ "$before" != = ] || before=${COMP_WORDS[COMP_CWORD - 2]}
    [ "${COMP_WORDS[COMP_CWORD]}" != = ] || before=${COMP_WORDS[COMP_CWORD - 1]}
    name=$(_totalforce_takes "$command:$before")
    if [ -n "$name" ]; then
        _totalforce_argument "$command" "$name" "$word"
    elif [ "${word:0:1}" = - ] && [ "$word" != - ]; then
        compgen -W "$(_totalforce_options "$command")" -- "$word"
    else
        [ "$word" != - ] || compgen -W "$(_totalforce_options "$command")" -- "$word"
        name=$(_totalforce_arguments "$command")
        read -r -a names <<<"${name//[\[\]]/}"
        name=${names[$(_totalforce_position "$command" "$2")]}
        [ -z "$name" ] || [ "${name:0:1}" = - ] || _totalforce_argument "$command" "$name" "$word"
    fi
}

_totalforce_complete()
{
    local word=${COMP_WORDS[COMP_CWORD]} line words
    COMPREPLY=()
    if [ "${COMP_WORDS[0]##*/}" = totalforced ]; then
        words=$(_totalforce_words totalforced 1)
    elif [ "$COMP_CWORD" -eq 1 ]; then
        words=$(compgen -W "$_totalforce_commands $(_totalforce_options totalforce)" -- "$word")
    elif [ "${COMP_WORDS[1]}" = help ]; then
        words=$([ "$COMP_CWORD" -ne 2 ] || compgen -W "${_totalforce_commands% help}" -- "$word")
    else
        words=$(_totalforce_words "${COMP_WORDS[1]}" 2)
    fi
    while read -r line; do
        case $line in
            '') ;;
            :files) compopt -o filenames 2>/dev/null ;;
            *) COMPREPLY+=("$line") ;;
        esac
    done <<<"$words"
}
complete -F _totalforce_complete totalforce totalforced
