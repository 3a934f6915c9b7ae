# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# `totalforce atlas`: methods fail where theory says, the service answers there, and every row says
# who answered.
. "$(dirname "$0")/check.sh"
[ -x "$bin/totalforce-atlas" ] || {
    echo "skipped: commands in Python are not built"
    exit 77
}

header="map,value,bodies,rhs,method,mode,own,fallback,refused,status,about,answered_by,reason,error,worst,estimate,error_over_estimate,silent,floor,error_low,error_high,unsaid,same_as"
status 0 "$tool" atlas --maps thin,ratio,curl --points 3 --bodies 2,16 --states 1 --seeds 3
cp "$work/out" "$work/atlas.csv"
says "$work/atlas.csv" "# command: totalforce atlas --maps thin,ratio,curl"
says "$work/atlas.csv" "# ratio: Alone, wrong by more than 1e-4"
says "$work/atlas.csv" "estimated below 1e-7: 0."
grep -v '^#' "$work/atlas.csv" >"$work/rows"
[ "$(head -1 "$work/rows")" = "$header" ] || fail "another header"
sed 1d "$work/rows" | awk -F, '
    NF != 23 { print "fields: " $0; bad = 1 }
    { rows++; methods[$5] = 1; cells[$1 "," $2 "," $3] = 1; key = $1 "," $2 "," $3 "," $5 }
    $7 + $8 + $9 != 3 { print "states: " $0; bad = 1 }
    $9 == 0 && $14 !~ /^[0-9.]+e[-+][0-9]+$/ { print "no error: " $0; bad = 1 }
    $10 == "ok" && ($12 != $5 || $13 != "") { print "who answered: " $0; bad = 1 }
    $10 == "fallback" && ($12 == $5 || $13 == "" || $8 == 0) { print "who answered: " $0; bad = 1 }
    $6 == "plain" || $6 == "refined" {
        if ($16 != "" || $10 == "fallback") { print "not bare: " $0; bad = 1 }
    }
    $6 == "estimated" && $9 == 0 && $16 == "" { print "no estimate: " $0; bad = 1 }
    $9 == 0 && !($20 <= $14 && $14 <= $21 && $21 <= $15) { print "spread over seeds: " $0; bad = 1 }
    $9 == 0 && $20 < $21 { spread++ }
    $18 != 0 { print "silent: " $0; bad = 1 }
    # one refinement by hand and the one of the library are the same, where the library keeps it
    $6 == "refined" { refined[key] = $14 }
    $6 == "service" && $16 != "" && $7 == 3 {
        compared++
        if ($14 > 1e-12 && ($14 > 3 * refined[key] || refined[key] > 3 * $14)) {
            print "refined by hand " refined[key] ": " $0; bad = 1
        }
    }
    END {
        for (m in methods) count++
        for (c in cells) places++
        if (places != 18 || count < 10 || rows != 18 * count * 4) { print "rows: " rows; bad = 1 }
        if (spread < rows / 2) { print "rows with a spread: " spread; bad = 1 }
        if (compared < 20) { print "compared: " compared; bad = 1 }
        exit bad
    }' || fail "the rows of the atlas"

# number ROW-REGEX FIELD: of one row
number() {
    grep "^$1," "$work/rows" | cut -d, -f "$2"
}
# theory: what inverts inertias fails where they are nearly singular, the others do not
for where in ratio,1e+12,16 thin,1e-06,16; do
    for method in tfa tfa-cr cfa dca; do
        row="$where,qdd,$method"
        awk "BEGIN { exit !($(number "$row,plain" 14) > 1e-2) }" || fail "$row does not fail"
        [ "$(number "$row,service" 10)" = fallback ] || fail "$row: the service does not fall back"
        awk "BEGIN { exit !($(number "$row,service" 15) < 1e-9) }" || fail "$row: the fallback is wrong"
    done
    for method in aba crba scan-two-pass; do
        awk "BEGIN { exit !($(number "$where,qdd,$method,plain" 15) < 1e-9) }" ||
            fail "$where: $method fails"
    done
done
# benign: nobody falls back
grep -q '^curl,.*,fallback,' "$work/rows" && fail "a fallback on a curled chain"

# long chains: tfa-cr and cfa-cr give the same answers, and the row says so, but for those of aba
status 0 "$tool" atlas --maps ratio --points 2 --bodies 8,64 --states 1 --methods tfa-cr,cfa-cr
[ "$(grep -c '^ratio,.*,64,qdd,cfa-cr,plain,.*,tfa-cr$' "$work/out")" -eq 1 ] || fail "not the same"
[ "$(grep -c '^ratio,.*,8,qdd,cfa-cr,plain,.*,$' "$work/out")" -eq 2 ] || fail "the same at 8"

# refusals are rows with a name
status 0 "$tool" atlas --maps thin --points 2 --bodies 131 --states 2 --seeds 1 --methods hessenberg --rhs tau
grep '^thin,1,131,tau,hessenberg,service,0,0,2,E_UNSUPPORTED,method,,,,,,,0,' "$work/out" >/dev/null ||
    fail "hessenberg is not refused: $(tail -1 "$work/out")"

status 0 "$tool" atlas --maps taper --points 2 --bodies 3 --states 2 --seeds 1 --methods aba --rhs gravity --json
says "$work/out" '"map":"taper","value":1.0,"bodies":3,"rhs":"gravity","method":"aba","mode":"plain","own":2'
[ "$(wc -l <"$work/out")" -eq 8 ] || fail "not one line for each row"

status 3 "$tool" atlas --maps knot
says "$work/err" "--maps: no 'knot'; there are ratio, heavy-tip"
status 3 "$tool" atlas --methods magic
says "$work/err" "--methods: no 'magic'"
status 3 "$tool" atlas --methods rnea
says "$work/err" "--methods: no 'rnea' of forward dynamics"
status 3 "$tool" atlas --rhs sideways
says "$work/err" "--rhs: no 'sideways'; there are qdd, tau, gravity"
status 3 "$tool" atlas --bodies 8,4
says "$work/err" "'4' is not larger than the size before it"
status 3 "$tool" atlas --seeds 0
status 3 "$tool" atlas --points 1
says "$work/err" "--points: '1' is not a whole number from 2"
status 3 "$tool" atlas one
says "$work/err" "one argument too many: 'one'"
tiny="--maps thin --points 2 --bodies 2 --states 2 --seeds 1"
status 2 "$tool" atlas $tiny --output "$work/absent/folder"
says "$work/err" "totalforce atlas: $work/absent/folder: "
"$tool" atlas $tiny >/dev/full 2>"$work/err"
[ $? -eq 2 ] || fail "atlas does not notice a full disk"

status 0 "$tool" atlas --maps thin,curl --points 3 --bodies 2,16 --states 2 --output "$work/p" \
    --html "$work/page.html"
[ -s "$work/err" ] && fail "atlas complains: $(cat "$work/err")"
for picture in thin curl; do
    [ -s "$work/p/$picture.png" ] || fail "no $picture.png"
    for text in hessenberg "to the last bit" "totalforce atlas --maps thin,curl" '</svg>'; do
        says "$work/p/$picture.svg" "$text"
    done
done
says "$work/p/thin.svg" "radius of the rods"
says "$work/p/atlas.csv" "$header"
says "$work/page.html" "<h2>curl: from straight to a helix</h2>"
finish
