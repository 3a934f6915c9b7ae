# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce sweep` under mpirun: the same statistics and answers from 1, 2 and 4 ranks, and after a
# rank was killed; nothing else needs MPI.
. "$(dirname "$0")/check.sh"

for program in "$tool" "$bin/totalforced" "$bin/../lib/libtotalforce.so"; do
    [ -e "$program" ] || continue
    ldd "$program" | grep -i 'libmpi\|open-rte' && fail "$program is linked with MPI"
done
arm=$data/arm.urdf
# where there is no mpi4py: alone, and as if mpirun had started two ranks
echo 'raise ImportError("no such package")' >"$work/mpi4py.py"
status 0 env PYTHONPATH="$work" "$tool" sweep "$arm" --count 5
status 2 env OMPI_COMM_WORLD_SIZE=2 PYTHONPATH="$work" "$tool" sweep "$arm" --count 5
says "$work/err" "2 ranks were started, and mpi4py is not there: no such package; install "
[ $failures -eq 0 ] || finish
/usr/bin/python3 -c 'import mpi4py' 2>/dev/null || { echo "mpi4py is not installed: skipped"; exit 77; }
command -v mpirun >/dev/null || { echo "mpirun is not installed: skipped"; exit 77; }
mpi="mpirun --oversubscribe"
[ "$(id -u)" -ne 0 ] || mpi="$mpi --allow-run-as-root"
# ranks on one machine, without a network or a vendor's devices
export OMPI_MCA_btl=self,vader OMPI_MCA_pml=ob1 OMPI_MCA_plm_rsh_agent=false

sweep="$tool sweep $arm --quiet --threads 1"
common="--count 20000 --block 512 --seed 7"
status 0 $sweep $common --out "$work/a1" --out-states "$work/s1"
sed 's/ out=.*//' "$work/out" >"$work/whole"
for ranks in 1 2 4; do
    status 0 $mpi -n $ranks $sweep $common --out "$work/a" --out-states "$work/s"
    sed 's/ out=.*//' "$work/out" >"$work/found"
    same "$work/found" "$work/whole" "$ranks ranks: statistics"
    same "$work/a" "$work/a1" "$ranks ranks: answers"
    same "$work/s" "$work/s1" "$ranks ranks: states"
    rm "$work/a" "$work/s"
done

# a rank is killed: mpirun ends the others; what they finished is kept and not computed again. It is
# stopped first, so that there is something left to do (quadruple precision for every state).
long="--count 20000 --block 512 --seed 7 --reference 1"
status 0 $sweep $long
cp "$work/out" "$work/whole"
$mpi -n 2 sh -c '
    [ "$OMPI_COMM_WORLD_RANK" != 1 ] || echo $$ >"$0/victim"
    exec "$@"' "$work" $sweep $long --resume "$work/r" >"$work/out" 2>"$work/err" &
launcher=$!
blocks() {
    grep -c '^block ' "$work/r.1" 2>/dev/null || true
}
turn=0
until [ "0$(blocks)" -ge 2 ] || [ $turn -ge 15000 ]; do
    turn=$((turn + 1))
    sleep 0.02
done
victim=$(cat "$work/victim")
kill -STOP "$victim" 2>/dev/null
if [ "0$(blocks)" -lt 18 ] && kill -KILL "$victim" 2>/dev/null; then
    wait $launcher && fail "mpirun does not tell of a rank that was killed"
    status 1 $sweep $long --resume "$work/r" --merge
    says "$work/err" "blocks are missing ("
    says "$work/err" "run again with --resume $work/r"
else
    echo "the ranks were done before the kill"
    kill -CONT "$victim" 2>/dev/null
    wait $launcher
fi
status 0 $mpi -n 2 $sweep $long --resume "$work/r"
same "$work/out" "$work/whole" "statistics after a killed rank"
[ "$(cat "$work"/r.* | grep '^block ' | grep -c '#')" -eq 40 ] || fail "blocks computed twice"

# refusals are said once
status 3 $mpi -n 2 $sweep --count 5 --op forward
[ "$(grep -c "no 'forward'" "$work/err")" -eq 1 ] || fail "the command line is refused twice"
status 2 $mpi -n 2 "$tool" sweep "$work/absent.urdf" --count 5
[ "$(grep -c 'No such file' "$work/err")" -eq 1 ] || fail "a missing file is told twice"
status 2 $mpi -n 2 $sweep --count 5 --out "$work/absent/folder"
says "$work/err" "$work/absent/folder: No such file"
# other kernels on one rank would give other bits
if [ "$(TFA_ISA=nothing "$tool" methods 2>&1 | sed 's/.*one of: //')" != base ]; then
    status 2 $mpi -n 2 sh -c '[ "$OMPI_COMM_WORLD_RANK" = 0 ] || export TFA_ISA=base
        exec "$@"' rank $sweep --count 5
    says "$work/err" "rank 1 has the kernels base, rank 0 "
fi
# processes that MPI does not know of would all do the whole sweep
SLURM_STEP_NUM_TASKS=3 SLURM_PROCID=0 $sweep --count 5 >"$work/out" 2>"$work/err"
[ $? -eq 2 ] || fail "srun without MPI is not refused"
says "$work/err" "3 processes were started, and MPI knows of one only"
finish
