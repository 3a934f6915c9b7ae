# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce specialise`: a kernel from a URDF, found by `totalforce model`; and what it says where
# there is none to be had.
. "$(dirname "$0")/check.sh"

chmod go-w "$work"
status 0 "$tool" specialise "$data/arm.urdf" -o "$work" --tables --snap 1e-6 --lanes one --algorithm aba
says "$work/out" "loaded and tested in"
says "$work/err" "the largest change is"
set -- "$work"/*.so
[ -f "$1" ] || fail "no shared object"
says "${1%.so}.h" "static const struct tfa_body robot_body"
status 0 "$tool" model "$data/arm.urdf" --snap 1e-6 --kernels "$work"
says "$work/out" "specialised: $1"
status 0 "$tool" model "$data/arm.urdf" --base floating --kernels "$work" # another model
says "$work/out" "generic: "

# a sweep by it; its blocks are not those of the generic kernel
sweep="$tool sweep $data/arm.urdf --snap 1e-6 --count 1000 --block 512 --quiet"
status 0 $sweep --kernels "$work" --resume "$work/swept" --reference 10 --expect-error 1e-9
digest=$(sed -n '1s/.* kernel=\([0-9a-f]*\) .*/\1/p' "$work/out")
[ ${#digest} -eq 16 ] || fail "a sweep does not say which kernel: $(cat "$work/out")"
status 2 $sweep --resume "$work/swept" --reference 10
says "$work/err" "it has kernel=$digest, this one kernel=; take another"
status 2 $sweep --kernels "$work" --base floating
says "$work/err" "totalforce sweep: --kernels: "

chmod o+w "$work"
status 0 "$tool" model "$data/arm.urdf" --snap 1e-6 --kernels "$work"
says "$work/out" "can be written by others"
chmod o-w "$work"
status 2 "$tool" specialise "$data/../../../config/robots/flexible_arm.urdf" -o "$work" \
    --modes "$data/../../../config/robots/flexible_arm.yaml"
says "$work/err" "link 'upper_beam' is flexible, modes are not specialised"

# a signal that ends it ends the compilers, and leaves nothing behind
mkdir "$work/ended"
cat >"$work/slow" <<END
#!/bin/sh
[ "\$1" = --version ] && exec echo slow 1.0
echo \$\$ >>"$work/pids"
exec sleep 1000
END
chmod +x "$work/slow"
"$tool" specialise "$data/arm.urdf" -o "$work/ended" --compiler "$work/slow" 2>"$work/err" &
builder=$!
for turn in $(seq 3000); do
    [ -s "$work/pids" ] && break
    sleep 0.1
done
kill -TERM $builder
wait $builder
[ $? -eq 143 ] || fail "SIGTERM does not end a build"
[ -s "$work/pids" ] || fail "no compiler ran: $(cat "$work/err")"
while read -r pid; do
    kill "$pid" 2>/dev/null && fail "a compiler of a build that was ended runs on"
done <"$work/pids"
[ -z "$(ls -A "$work/ended")" ] || fail "an ended build left $(ls -A "$work/ended")"

status 2 env PATH=/nowhere "$tool" specialise "$data/arm.urdf" -o "$work/none.so"
says "$work/err" "no compiler found: looked for clang, gcc and cc in PATH; \`apt install clang\`"
[ ! -e "$work/none.so" ] || fail "a file without a compiler"
status 2 "$tool" specialise "$data/hand.urdf" --lock-massless-leaves --mimic project -o "$work/none.so"
says "$work/err" "the generic kernel answers"
status 2 "$tool" specialise "$data/arm.urdf" -o "$work/no/folder.so"
says "$work/err" "cannot be written"
status 3 "$tool" specialise "$data/arm.urdf"
says "$work/err" "where to?"
status 3 "$tool" specialise "$data/arm.urdf" -o "$work" --snap 1
says "$work/err" "is not an angle"
finish
