# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce chain` and `totalforce chart`: mechanisms load back to the same numbers, and every row
# of a chart is an answer with a finite error or a refusal by name.
. "$(dirname "$0")/check.sh"

mechanisms="straight zigzag helix random taper heavy-tip alternating thin light-heavy massless
    rank-deficient side-branches planar"
for name in $mechanisms; do
    for bodies in 1 2 9; do
        status 0 "$tool" chain $name --bodies $bodies
        cp "$work/out" "$work/chain.urdf"
        status 0 "$tool" chain $name --bodies $bodies
        same "$work/out" "$work/chain.urdf" "chain $name is not the same twice"
        status 0 "$tool" model --json "$work/chain.urdf"
        says "$work/out" "\"robot\": \"$name-$bodies\""
    done
done
status 0 "$tool" chain random --bodies 3 --seed 1
cp "$work/out" "$work/one"
status 0 "$tool" chain random --bodies 3 --seed 2
cmp -s "$work/out" "$work/one" && fail "the seed makes no difference"
status 0 "$tool" chain heavy-tip --bodies 3 --mass-ratio 123456.75
says "$work/out" '<mass value="123456.75"/>'
status 0 "$tool" chain helix --bodies 3 --curl 0
says "$work/out" 'rpy="0 0 0"'
status 3 "$tool" chain
status 3 "$tool" chain knot
says "$work/err" "no mechanism 'knot'; nearest: "
says "$work/err" "; there are straight, zigzag"
status 3 "$tool" chain random --bodies 0
status 3 "$tool" chain random --curl 2
says "$work/err" "curl: 2, must be 0 (straight) to 1 (curled)"
status 3 "$tool" chain random --radius -1
says "$work/err" "radius: -1"
"$tool" chain random >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chain does not notice a full disk"

header="mechanism,bodies,rhs,method,refine,precision,threads,status,about,answered_by,error,worst_component,floor,estimate,time_us,aba_us,time_ratio,samples,front,error_low,error_high,time_low_us,time_high_us,same_as,strategy,op"
# peers come on top of what is counted here
methods=crba,aba,tfa,tfa-cr,hessenberg,cfa,cfa-cr,dca,scan,scan-two-pass
status 0 "$tool" chart --bodies 2,5 --budget-ms 1 --states 2 --methods $methods
cp "$work/out" "$work/chart.csv"
says "$work/chart.csv" "# command: "
[ "$(grep -v '^#' "$work/chart.csv" | head -1)" = "$header" ] || fail "another header"
# 13 mechanisms, 2 sizes, 3 right-hand sides, 2 refinements, and at least aba, crba and tfa
grep -v '^#' "$work/chart.csv" | awk -F, '
    NR == 1 { next }
    NF != 26 { print "fields: " $0; bad = 1 }
    { rows++; methods[$4] = 1; key = $1 "," $2 "," $3; keys[key] = 1; if ($19) front[key] = 1 }
    $8 == "ok" || $8 == "fallback" {
        if ($11 !~ /^[0-9.]+e[-+][0-9]+$/ || $12 == "" || $15 <= 0 || $16 <= 0 || $17 <= 0) {
            print "not finite: " $0; bad = 1
        }
        if (!($20 <= $11 && $11 <= $21 && $22 <= $15 && $15 <= $23)) {
            print "spread over seeds: " $0; bad = 1
        }
        if ($20 < $21) spread++
        if ($24 != "" && $19) { print "twice on the front: " $0; bad = 1 }
        if ($4 == "aba" && $11 > 1e-6) { print "aba is far off: " $0; bad = 1 }
        next
    }
    $8 !~ /^E_/ || $11 != "" || $9 == "" { print "refused without a name: " $0; bad = 1 }
    $8 == "E_SINGULAR" && $9 !~ /^body link/ { print "no body named: " $0; bad = 1 }
    END {
        for (key in keys) { n++; if (!front[key]) { print "no front: " key; bad = 1 } }
        for (m in methods) count++
        if (spread < rows / 2) { print "rows with a spread: " spread; bad = 1 }
        if (n != 78) { print "cells: " n; bad = 1 }
        if (count < 10 || rows != n * count * 2) { print "rows: " rows; bad = 1 }
        exit bad
    }' || fail "the rows of the chart"
grep -q '^rank-deficient,5,qdd,tfa,0,f64,1,E_SINGULAR,body link' "$work/chart.csv" ||
    fail "tfa is not refused on a rank-deficient body"

# one seed has no spread; long chains: tfa-cr and cfa-cr give the same answers, and the row says so
status 0 "$tool" chart --mechanisms random --bodies 8,64 --methods aba,tfa-cr,cfa-cr --rhs tau \
    --refine 0,1 --budget-ms 1 --seeds 1
grep -v '^#' "$work/out" | awk -F, 'NR > 1 && ($20 != $21 || $22 != $23) { exit 1 }' || fail "one seed"
[ "$(grep -c '^random,64,tau,cfa-cr,.*,tfa-cr,single,forward_dynamics$' "$work/out")" -eq 2 ] || fail "not the same"
[ "$(grep -c '^random,8,tau,cfa-cr,.*,,single,forward_dynamics$' "$work/out")" -eq 2 ] || fail "the same at 8"

# a robot, floating, as JSON; the theory of a thin chain
status 0 "$tool" chart --urdf "$data/arm.urdf" --base floating --rhs tau --refine 0 --json --budget-ms 1
says "$work/out" '"mechanism":"arm"'
says "$work/out" '"rhs":"tau","method":"aba","refine":0,"precision":"f64","threads":1,"strategy":"single","status":"ok"'
status 0 "$tool" chart --mechanisms thin --bodies 24 --methods aba,tfa --rhs qdd --refine 0 --budget-ms 1
grep -v '^#' "$work/out" | awk -F, '$4 == "aba" { a = $11 } $4 == "tfa" { t = $11 }
    END { exit !(a > 0 && t > 1e3 * a) }' || fail "tfa is not seen to fail on thin rods"
# the chain of a chart is the chain of `totalforce chain`
"$tool" chain random --bodies 6 >"$work/chain.urdf"
for source in "--mechanisms random --bodies 6" "--urdf $work/chain.urdf"; do
    status 0 "$tool" chart $source --turn 1 --seeds 1 --methods aba,tfa,crba --rhs tau --refine 0 --budget-ms 1
    grep -v '^#' "$work/out" | sed 1d | cut -d, -f 3-14 >"$work/errors.$(expr "$source" : '--u')"
done
same "$work/errors.0" "$work/errors.3" "a mechanism and its file do not give the same errors"

# rows of one method in one file: FIELD METHOD FILE
field() {
    grep -v '^#' "$3" | awk -F, -v field="$1" -v method="$2" '$4 == method { print $field }'
}

# precision: the reference itself has no error, and f64 with f128 residuals is a chart of its own
status 0 "$tool" chart --mechanisms random --bodies 5 --methods aba,tfa --rhs tau --refine 0,1 \
    --precision f64,f64+f128,f128 --budget-ms 1
[ "$(field 6 aba "$work/out" | tr '\n' ' ')" = "f64 f64 f64+f128 f128 f128 " ] ||
    fail "rows by precision: $(cat "$work/out")"
grep -v '^#' "$work/out" | awk -F, '$4 == "aba" && $6 == "f128" && $5 == 0 { n++; bad = $11 > 1e-20 }
    END { exit !(n == 1 && !bad) }' || fail "the reference differs from itself"
# a precision that is not there has rows that say so
status 0 "$tool" chart --mechanisms random --bodies 5 --methods aba,tfa --rhs tau --precision f32 \
    --budget-ms 1
for word in $(field 8 tfa "$work/out"); do
    [ $word = ok ] || [ $word = fallback ] || [ $word = E_UNSUPPORTED ] || fail "f32: $word"
done
[ "$(field 6 tfa "$work/out" | sort -u)" = f32 ] || fail "no rows in f32"

# strategies: batches have the bits of one state after the other; a kernel that is not there has rows
# that say so, and the rest is charted
status 0 "$tool" chart --urdf "$data/arm.urdf" --methods auto,aba --rhs qdd --threads 1,2 --refine 0 \
    --strategies single,batch,specialised --kernels "$work" --precision f64,f32 --budget-ms 1
says "$work/err" "no specialised kernel: "
grep -v '^#' "$work/out" | awk -F, '
    $25 == "specialised" { kernels++; if ($8 != "E_UNSUPPORTED" || $9 != "kernel" || $4 != "auto") exit 1; next }
    NR > 1 { rows++; if ($8 != "ok") exit 1
        key = $4 "," $6; if (key in error && error[key] != $11) exit 1
        error[key] = $11 }
    END { exit rows != 16 || kernels != 4 || error["aba,f32"] < 1e3 * error["aba,f64"] }' ||
    fail "strategies: $(cat "$work/out")"

# threads: the same states, so the same errors, however many threads
status 0 "$tool" chart --mechanisms random --bodies 9 --methods aba,tfa --rhs tau --threads 1,2 \
    --budget-ms 1
for method in aba tfa; do
    [ "$(field 7 $method "$work/out" | tr '\n' ' ')" = "1 1 2 2 " ] || fail "rows by threads"
    [ "$(field 11 $method "$work/out" | sort | uniq -c | awk '$1 % 2' | wc -l)" -eq 0 ] ||
        fail "errors by threads"
    field 15 $method "$work/out" | awk '!($1 > 0) { exit 1 }' || fail "no time by threads"
done

# Lambda^-1: methods and peers that have it, single states and batches of one error; none in f32
status 0 "$tool" chart --urdf "$data/arm.urdf" --op operational_inertia,forward_dynamics --rhs tau,qdd \
    --strategies single,batch --refine 0 --precision f64,f32 --budget-ms 1
grep -v '^#' "$work/out" | awk -F, '
    $26 != "operational_inertia" { if ($26 == "forward_dynamics" && $3 == "") exit 1; next }
    $3 != "" || $6 != "f64" || $8 != "ok" || !($11 < 1e-12) || !($15 > 0) { print; exit 1 }
    { methods[$4] = 1; key = $4; if (key in error && error[key] != $11) { print; exit 1 }
      error[key] = $11; front += $19 }
    END { for (m in methods) n++
        exit !(front >= 2 && n >= 11 && "pv-osimr" in methods && "crba" in methods && !("aba" in methods)) }' ||
    fail "rows of Lambda^-1: $(cat "$work/out")"
status 0 "$tool" chart --urdf "$data/arm.urdf" --op operational_inertia --methods efpa --json --budget-ms 1
says "$work/out" '"op":"operational_inertia"'
status 3 "$tool" chart --op operational_inertia --methods rnea
says "$work/err" "--methods: rnea answers none of --op"
status 3 "$tool" chart --op sideways

# the title of a page counts charts: a mechanism is no robot
status 0 "$tool" chart --mechanisms random --bodies 2,3 --methods aba --rhs tau --refine 0 --budget-ms 1 \
    --html "$work/page.html"
says "$work/page.html" "aba: fastest answer exact to rounding on 2 of 2 charts, "

# what would take too long is skipped, and says so. Processor time, far from the bound of 200 ms on
# either side: crba needs a second or so, aba half a millisecond.
status 0 "$tool" chart --mechanisms straight --bodies 8,2048,2049 --methods aba,crba,hessenberg \
    --rhs tau --refine 0 --budget-ms 10 --states 2 --seeds 1
[ "$(field 8 crba "$work/out" | tr '\n' ' ')" = "ok over_budget over_budget " ] || fail "over budget"
[ "$(field 8 hessenberg "$work/out" | tr '\n' ' ')" = "ok E_UNSUPPORTED E_UNSUPPORTED " ] ||
    fail "hessenberg of 2048 bodies"
[ "$(field 8 aba "$work/out" | tr '\n' ' ')" = "ok ok ok " ] || fail "aba of 2048 bodies"

# peers, where they are built in
if "$tool" chart --methods mujoco,kdl --mechanisms random,side-branches --bodies 5,301 --rhs tau \
    --budget-ms 1 >"$work/out" 2>"$work/err"; then
    for peer in mujoco kdl; do
        grep -q "^random,5,tau,$peer,0,f64,1,ok,,$peer," "$work/out" || fail "no $peer"
        grep -q "^random,301,tau,$peer,0,f64,1,too_large,more than" "$work/out" || fail "$peer of 301"
        field 11 $peer "$work/out" | awk '$1 > 1e-6 { exit 1 }' || fail "$peer is far off"
    done
    grep -q "^side-branches,5,tau,kdl,0,f64,1,refused,joint" "$work/out" || fail "kdl takes a tree"
else
    says "$work/err" "--methods: no 'mujoco'"
fi

status 3 "$tool" chart --mechanisms knot
says "$work/err" "--mechanisms: no 'knot'"
status 3 "$tool" chart --methods magic
status 3 "$tool" chart --rhs sideways
says "$work/err" "--rhs: no 'sideways'; there are qdd, tau, gravity"
status 3 "$tool" chart --refine 3
status 3 "$tool" chart --precision f16
says "$work/err" "--precision: no 'f16'; there are f64, f32, f32+f64, f64+f128, f128"
status 3 "$tool" chart --precision f32+f64 --refine 0
says "$work/err" "--precision f32+f64 needs --refine 1 or 2"
status 3 "$tool" chart --strategies batch,sideways
says "$work/err" "--strategies: no 'sideways'; there are single, batch, specialised, specialised-batch"
status 3 "$tool" chart --strategies batch,batch
says "$work/err" "--strategies: batch twice"
status 3 "$tool" chart --threads 1,2,3,4,5,6,7,8,9
says "$work/err" "--threads: more than 8"
status 3 "$tool" chart --strategies specialised
says "$work/err" "--strategies specialised needs --kernels FOLDER"
status 3 "$tool" chart --threads 0
status 3 "$tool" chart --seeds 17
status 3 "$tool" chart --turn 0
says "$work/err" "--turn: 0, must be above 0"
status 3 "$tool" chart one
status 2 "$tool" chart --urdf "$work/absent.urdf"
says "$work/err" "[unreadable]"
grep -q bodies "$work/err" && fail "a file that was refused has bodies: $(cat "$work/err")"
status 2 "$tool" chart --mechanisms random --bodies 2 --output "$work/absent/folder"
"$tool" chart --mechanisms random --bodies 2 --budget-ms 1 >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chart does not notice a full disk"
says "$work/err" "totalforce chart: output: No space left on device"
# and ends with the first rows that cannot be written
"$tool" chart --mechanisms random --bodies 2,256 --methods aba --budget-ms 1 \
    --html "$work/full.html" >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "chart does not notice a full disk, with a page"
says "$work/full.html" "random, 2 bodies"
grep -q 'random, 256 bodies' "$work/full.html" && fail "chart goes on with a full disk"

# pictures, where there is gnuplot
status 2 "$tool" chart --mechanisms random --bodies 2 --budget-ms 1 --output "$work/p" --scripts "$work/absent"
says "$work/err" "--scripts says where they are"
if command -v gnuplot >/dev/null; then
    status 0 "$tool" chart --mechanisms random,heavy-tip:1e3,rank-deficient --bodies 3,6 \
        --budget-ms 1 --output "$work/p"
    [ -s "$work/err" ] && fail "gnuplot complains: $(cat "$work/err")"
    for picture in random-3 random-6 heavy-tip-1e3-6 rank-deficient-3 overview; do
        [ -s "$work/p/$picture.png" ] || fail "no $picture.png"
        grep -q '</svg>' "$work/p/$picture.svg" || fail "no whole $picture.svg"
    done
    says "$work/p/random-3.svg" "hessenberg"
    says "$work/p/random-3.svg" "from the least to the largest"
    status 0 "$tool" chart --mechanisms rank-deficient --bodies 4 --methods tfa --budget-ms 1 \
        --output "$work/t"
    [ -s "$work/err" ] && fail "gnuplot complains of no answers: $(cat "$work/err")"
    says "$work/t/rank-deficient-4.svg" "not shown: singular inertia: tfa, tfa+1"
    status 0 "$tool" chart --mechanisms random --bodies 4 --methods aba,tfa,scan --budget-ms 1 \
        --threads 2,1 --output "$work/t"
    [ -s "$work/err" ] && fail "gnuplot complains of threads: $(cat "$work/err")"
    says "$work/t/random-4-2-threads-batch.svg" "wall time of a state in a batch"
    says "$work/t/overview-2-threads-batch.svg" ", 2 threads, batch"
    says "$work/t/overview.svg" "CPU time of a call"
    status 0 "$tool" chart --mechanisms random --bodies 4 --methods aba,efpa --budget-ms 1 \
        --op forward_dynamics,operational_inertia --output "$work/t"
    [ -s "$work/err" ] && fail "gnuplot complains of Lambda^-1: $(cat "$work/err")"
    says "$work/t/random-4-lambda.svg" "efpa"
    says "$work/t/overview-lambda.svg" "Frobenius norm"
    status 0 "$tool" chart --mechanisms random --bodies 4 --methods aba,tfa --budget-ms 1 \
        --precision f64,f128 --output "$work/t"
    [ -s "$work/err" ] && fail "gnuplot complains of precisions: $(cat "$work/err")"
    says "$work/t/random-4.svg" "f128"
    says "$work/t/random-4.svg" "tfa"
    grep -q hessenberg "$work/t/random-4.svg" && fail "the key has methods that are not charted"
else
    echo "gnuplot is not installed: pictures are not tested"
fi
finish
