# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# bash completion: commands, options, words, robots and files; every word that it offers for an
# option is one that the program takes, and it offers all that the program names.
. "$(dirname "$0")/check.sh"
bin=$(cd "$bin" && pwd)
tool=$bin/totalforce
script=$bin/../tools/manual/totalforce
[ -e "$script" ] || {
    echo "SKIP: a cross build without completion"
    exit 77
}

# complete WORD...: the words that are offered for the last one, sorted, on one line
complete() {
    bash -c '. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _totalforce_complete
        printf "%s\n" "${COMPREPLY[@]}"' bash "$script" "$@" | LC_ALL=C sort | paste -s -d ' '
}
# offers "WORDS" WORD...
offers() {
    expected=$1
    shift
    found=$(complete "$@")
    [ "$found" = "$expected" ] || fail "after '$*': '$found', not '$expected'"
}
cd "$work" || exit 1
mkdir run folder
touch a.urdf b.urdf other.txt q.jsonl 'two words.urdf'
/usr/bin/python3 - <<'END'
import socket
for name in ('arm', 'arm.folded', '.control'):
    socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET).bind('run/' + name + '.sock')
END
export TOTALFORCE_RUNTIME_DIR="$work/run"

offers "methods model" totalforce m
offers "solve specialise status stop sweep" totalforce help s
offers "--base" totalforce model --ba
offers "fixed floating" totalforce model --base ""
offers "fixed floating" totalforce model --base =
offers "floating" totalforce model --base = fl
offers "tfa tfa-cr tfa-one-sided" totalforce call --method tfa
offers "tfa tfa-cr tfa-one-sided" totalforce solve a.urdf --method = tfa
offers "aba,tfa aba,tfa-cr" totalforce atlas --methods aba,tfa
if [ -x "$bin/totalforce-chart" ]; then
    offers "qdd,tau" totalforce chart --rhs qdd,t
    offers "heavy-tip" totalforce chart -m hea
    offers "folder run" totalforce chart -o ""
fi
offers "heavy-tip helix" totalforce chain he
offers "" totalforce chain helix he
offers "arm arm.folded" totalforce call a
offers "folder q.jsonl run" totalforce call arm ""
offers "arm arm.folded" totalforce call --via shm ""
offers "a.urdf b.urdf folder run two words.urdf" totalforce model ""
offers "a.urdf" totalforce specialise -o folder a
offers "a.urdf b.urdf folder other.txt q.jsonl run two words.urdf" totalforce specialise -o ""
offers "--check --check-rt" totalforced --ch
offers "folder run" totalforced ""
TOTALFORCE_RUNTIME_DIR=/nonexistent
offers "arm arm.folded" totalforce latency --runtime-dir run ""
offers "arm arm.folded" totalforce latency --runtime-dir = run ""
offers "" totalforce latency ""
[ "$(bash -c '. "$1"; complete -p totalforce totalforced | wc -l' bash "$script")" -eq 2 ] ||
    fail "the functions are not registered"

# words: what the completion offers is what the program checks against
bash -c '. "$1"
    for c in $_totalforce_commands; do
        for o in $(_totalforce_options $c); do
            name=$(_totalforce_takes $c:$o)
            COMP_WORDS=(totalforce $c $o "") COMP_CWORD=3
            case $name in
                *"|"*) ;;
                *) [ -n "$(_totalforce_values "$c:${name%%[[,]*}")" ] || continue ;;
            esac
            _totalforce_complete
            case $o in --*) echo $c $o "${COMPREPLY[@]}" ;; esac
        done
    done' bash "$script" >options
[ "$(wc -l <options)" -ge 40 ] || fail "$(wc -l <options) options with words"
sorted() {
    echo "$1" | tr ' ' '\n' | sort
}
while read -r command option words; do
    [ "$option" = --refine ] && continue # numbers
    # shellcheck disable=SC2046 # words
    status 3 "$tool" "$command" $(printf -- "$option=%s " $words) "$option=no-such"
    says err "$option: no 'no-such'" # the words before it were taken
    listed=$(sed -n 's/.*there are \(.*\)$/\1/p' err | head -n 1 | tr -d ',')
    [ -z "$listed" ] || [ "$(sorted "$listed")" = "$(sorted "$words")" ] ||
        fail "$command $option: offers '$words'; the program takes '$listed'"
done <options
finish
