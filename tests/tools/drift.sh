# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce drift`: rows of every line, sentences, the picture, refusals.
. "$(dirname "$0")/check.sh"
[ -x "$bin/totalforce-drift" ] || {
    echo "skipped: commands in Python are not built"
    exit 77
}

status 0 "$tool" drift --mechanism random --bodies 3 --methods aba,crba --precision f64,f32 \
    --step 0.01,0.005 --seconds 0.5 --samples 5
grep -v '^#' "$work/out" | awk -F, '
    NR == 1 { bad = $0 != "mechanism,bodies,integrator,step_s,method,precision,refine,floor,time_s,energy_error,largest_error,status"; next }
    NF != 12 || $1 != "random" || $2 != 3 || $3 != "gbs8" || $12 != "ok" || $11 < 0 { print; bad = 1 }
    { rows++; floors += $8; if ($9 == 0.5) last[$4, $5, $6] = $11 }
    END { exit bad || rows != 50 || floors != 10 || !(last[0.01, "aba", "f32"] > 1e3 * last[0.01, "aba", "f64"]) }' ||
    fail "rows: $(cat "$work/out")"
says "$work/out" "# step 0.01 s, gbs8: the integrator drifts by "
says "$work/out" "#   aba f32: "
# a method that fails has a row that says so
status 0 "$tool" drift --mechanism rank-deficient --bodies 5 --methods tfa --seconds 0.1 --samples 2
says "$work/out" ",tfa,f64,0,0,,,,E_SINGULAR"
says "$work/out" "; then E_SINGULAR"
status 0 "$tool" drift --urdf "$data/arm.urdf" --integrator rk4 --seconds 0.1 --samples 2

status 3 "$tool" drift --mechanism knot
status 3 "$tool" drift --methods rnea
says "$work/err" "--methods: no 'rnea' of forward dynamics"
status 3 "$tool" drift --methods aba,aba
says "$work/err" "--methods: aba twice"
status 3 "$tool" drift --precision f64,f16
says "$work/err" "--precision: no 'f16'; there are f64, f32, "
status 3 "$tool" drift --step 0.001,0
says "$work/err" "--step: 0, must be above 0 and at most 10"
status 3 "$tool" drift --seconds -1
says "$work/err" "--seconds: -1, must be above 0"
status 3 "$tool" drift --step 1
says "$work/err" "--samples says how many energies"
status 3 "$tool" drift --integrator magic
says "$work/err" "there are euler, rk4, gbs8"
status 2 "$tool" drift --urdf "$work/absent.urdf"
status 2 "$tool" drift --seconds 0.1 --samples 2 --output "$work/absent/folder"
"$tool" drift --seconds 0.1 --samples 2 >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "drift does not notice a full disk"

status 0 "$tool" drift --methods aba,tfa --precision f64,f32 --step 0.01,0.001 --seconds 0.2 --samples 10 \
    --output "$work/p"
[ -s "$work/err" ] && fail "drift complains: $(cat "$work/err")"
says "$work/out" "step 0.001 s, gbs8: the integrator drifts by "
[ -s "$work/p/drift.png" ] || fail "no drift.png"
for text in "random, 8 bodies, steps of 0.001 s: the integrator" "integrator alone" \
    "tfa f32" "totalforce drift --methods aba,tfa" '</svg>'; do
    says "$work/p/drift.svg" "$text"
done
finish
