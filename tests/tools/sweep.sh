# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce sweep` on one machine: the same statistics and answers for any split into blocks,
# threads and parts, resumed runs, states from a file, refusals.
. "$(dirname "$0")/check.sh"

arm=$data/arm.urdf
tip=tool
sweep="$tool sweep $arm --quiet"

# numbers FILE: eight-byte doubles, one a line
numbers() {
    od -An -v -t f8 -w8 "$1"
}

# blocks FILE: finished ones in a resume file, which may not be there yet
blocks() {
    grep -c '^block .*#' "$1" 2>/dev/null || true
}

# agrees WHAT: statistics of the last run are those of $work/whole
agrees() {
    same "$work/out" "$work/whole" "$1"
}

# blocks, threads and parts
common="--count 5000 --block 512 --seed 7 --estimate always --reference 97"
status 0 $sweep $common --threads 1
cp "$work/out" "$work/whole"
says "$work/whole" "states               5000"
says "$work/whole" "references           52"
says "$work/whole" "error_over_estimate: error / estimate"
status 0 $sweep $common --threads 2
agrees "two threads"
for part in 2 1 3; do
    status 0 $sweep $common --resume "$work/parts" --part $part/3 --threads 1
    [ -s "$work/out" ] && fail "a part prints statistics"
done
status 0 $sweep $common --resume "$work/parts" --merge
agrees "three parts"
status 0 $sweep --count 5000 --block 1024 --seed 7 --estimate always --reference 97
sed 's/block=1024/block=512/' "$work/out" >"$work/other"
same "$work/other" "$work/whole" "blocks of another size"
status 0 $sweep --count 5000 --seed 8
grep -v '^#' "$work/whole" | grep mean | head -1 >"$work/mean"
grep mean "$work/out" | cmp -s - "$work/mean" && fail "another seed has the same states"

# a link that others have put there is not written through
printf x >"$work/theirs"
ln -s theirs "$work/link.0"
status 2 $sweep $common --resume "$work/link" --threads 1
says "$work/err" "a symbolic link"
[ "$(cat "$work/theirs")" = x ] || fail "a sweep wrote through a symbolic link"

# resumed: a line that was cut off, a block that is missing
status 0 $sweep $common --resume "$work/r" --threads 1
[ "$(grep -c '^block ' "$work/r.0")" -eq 10 ] || fail "not ten blocks in the resume file"
grep -v '^block [36] ' "$work/r.0" >"$work/r.1"
rm "$work/r.0"
printf 'block 3 0:200' >>"$work/r.1"
status 1 $sweep $common --resume "$work/r" --merge
says "$work/err" "2 of 10 blocks are missing (3, 6): run again with --resume $work/r"
status 0 $sweep $common --resume "$work/r"
agrees "a resumed sweep"
[ "$(cat "$work"/r.? | grep -c '^block [0-9]* .*#')" -eq 10 ] || fail "not the missing blocks only"
status 0 $sweep $common --resume "$work/r" --json
says "$work/out" '"computed":0,"blocks_found":10'
status 2 $sweep --count 5000 --block 512 --seed 8 --resume "$work/r"
says "$work/err" "is of another sweep: it has estimate=2, this one estimate=0"

# interrupted: the block under way is finished, the same command goes on
long="--count 40000000 --block 512 --seed 7 --threads 1"
$sweep $long --resume "$work/i" >"$work/out" 2>"$work/err" &
process=$!
turn=0
until [ "0$(blocks "$work/i.0")" -ge 1 ] || [ $turn -ge 6000 ]; do
    turn=$((turn + 1))
    sleep 0.05
done
kill -TERM $process
wait $process
[ $? -eq 1 ] || fail "an interrupted sweep does not end with 1"
says "$work/err" "interrupted: "
says "$work/err" "run again with --resume $work/i"

# killed: what is on disk is kept
$sweep $long --resume "$work/k" >"$work/out" 2>"$work/err" &
process=$!
turn=0
until [ "0$(blocks "$work/k.0")" -ge 4 ] || [ $turn -ge 6000 ]; do
    turn=$((turn + 1))
    sleep 0.05
done
kill -KILL $process
wait $process 2>/dev/null
status 1 $sweep $long --resume "$work/k" --merge
says "$work/err" "of 78125 blocks are missing"

# states to a file and back, answers at their offsets
for op in forward_dynamics inverse_dynamics mass_matrix; do
    for base in fixed floating; do
        same="--op $op --base $base --count 1500 --block 512"
        status 0 $sweep $same --out "$work/a" --out-states "$work/s" --threads 1
        grep -v '^#' "$work/out" >"$work/whole"
        status 0 $sweep $same --states "$work/s" --out "$work/b" --threads 2
        grep -v '^#' "$work/out" >"$work/other"
        same "$work/other" "$work/whole" "$op $base: statistics of states from a file"
        same "$work/a" "$work/b" "$op $base: answers of states from a file"
        status 0 $sweep --op $op --base $base --states "$work/s" --offset 600 --out "$work/c"
        size=$(($(wc -c <"$work/a") / 1500 * 900))
        tail -c $size "$work/a" | cmp -s - "$work/c" || fail "$op $base: answers from state 600 on"
    done
done
# the answers are those of `solve`: arm.urdf, fixed base, first state
status 0 $sweep --count 3 --out "$work/a" --out-states "$work/s"
joints=$(($(wc -c <"$work/a") / 24))
numbers "$work/s" | head -$((3 * joints)) >"$work/state"
list() { # FIRST
    sed -n "$1,$(($1 + joints - 1))p" "$work/state" | tr -d ' ' | paste -sd,
}
# od rounds to 17 digits, which are enough
echo "{\"op\":\"forward_dynamics\",\"q\":[$(list 1)],\"v\":[$(list $((joints + 1)))],\"tau\":[$(list $((2 * joints + 1)))]}" |
    "$tool" solve "$arm" | array qdd >"$work/solved"
numbers "$work/a" | head -$joints >"$work/swept"
near "$work/swept" "$work/solved" 1e-15 "the answers are not those of solve"

# states that cannot be answered are counted, and their neighbours are answered
status 0 $sweep --count 600 --out-states "$work/s"
printf '\377\377\377\377\377\377\377\177' |
    dd of="$work/s" bs=8 seek=$((5 * 3 * joints)) conv=notrunc 2>/dev/null
status 0 $sweep --states "$work/s" --out "$work/a"
says "$work/out" "status OK            599"
says "$work/out" "status E_VALUE       1"
[ "$(numbers "$work/a" | grep -ci nan)" -eq "$joints" ] || fail "not one answer of NaN"
status 1 $sweep --states "$work/s" --expect-error 1e-9
says "$work/err" "1 states failed, --expect-error 1e-09"
status 1 $sweep --count 600 --reference 10 --expect-error 1e-30
says "$work/err" "--expect-error 1e-30"
status 0 $sweep --count 600 --reference 10 --expect-error 1e-10
status 0 $sweep --op operational_inertia --tips "$tip" --count 600 --reference 100
says "$work/out" "references           6"

# refusals
status 3 "$tool" sweep "$arm"
says "$work/err" "how many states? --count N"
status 3 "$tool" sweep --count 5
says "$work/err" "which URDF file?"
status 3 $sweep --count 5 --op forward
says "$work/err" "--op: no 'forward'; there are forward_dynamics"
status 3 $sweep --count 5 --method abba
says "$work/err" "--method: no 'abba'; nearest: 'aba'"
status 3 $sweep --count 5 --method efpa
says "$work/err" "--method: efpa does not answer forward_dynamics"
status 3 $sweep --count 5 --part 1/3
says "$work/err" "--part: finished blocks are kept in a file: --resume FILE"
status 3 $sweep --count 5 --part 4/3 --resume "$work/x"
status 3 $sweep --count 5 --part 4 --resume "$work/x"
says "$work/err" "--part: '4' is not I/N"
status 3 $sweep --count 5 --block 1000
says "$work/err" "--block: 1000 is not a multiple of 512"
status 3 $sweep --count 5 --velocity 0
status 3 $sweep --count 5 --op operational_inertia
says "$work/err" "operational_inertia of which links?"
status 2 $sweep --count 5 --op operational_inertia --tips toool
says "$work/err" "--tips: no link 'toool' in the robot; nearest: "
status 2 $sweep --states "$work/absent"
says "$work/err" "$work/absent: No such file"
printf 12345 >"$work/short"
status 2 $sweep --states "$work/short"
says "$work/err" "5 bytes are no whole number of records of $((3 * joints)) doubles"
status 2 $sweep --states "$work/s" --offset 600
says "$work/err" "has 600 states; --offset 600"
status 2 "$tool" sweep "$work/absent.urdf" --count 5
says "$work/err" "$work/absent.urdf: error: file: cannot be read: No such file"
status 2 $sweep --count 5 --out "$work/absent/folder"
says "$work/err" "$work/absent/folder: No such file"
status 0 $sweep --count 5
says "$work/out" " refine=default "
status 0 $sweep --count 5 --refine 1
says "$work/out" " refine=1 "
$sweep --count 5 >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "sweep does not notice a full disk"
finish
