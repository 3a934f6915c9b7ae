# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Called by make.sh: the tables of the page, from the CSV files in WORK, into WORK/blocks.
#   sh tables.sh WORK ONE          ONE: the number of bodies of the tables of one size
set -eu
work=$1 one=$2

# rows NAME: of a chart or an atlas, without head
rows() {
    grep -v '^#' "$work/$1.csv" | sed 1d
}
chart() {
    rows "$1/chart"
}
block() {
    cat >"$work/blocks/$1"
}
fact() { # of the head of the first chart
    sed -n "s/^# $1: //p" "$work/mechanisms/chart.csv"
}

# table "HEAD,OF,COLUMNS": lines of fields separated by | on standard input
table() {
    awk -F'|' -v head="$1" '
    BEGIN {
        n = split(head, title, ",")
        for (i = 1; i <= n; i++) { line = line "| " title[i] " "; rule = rule "|---" }
        print line "|"; print rule "|"
    }
    { line = ""; for (i = 1; i <= n; i++) line = line "| " $i " "; print line "|" }'
}

{
    printf 'Measured on %s, %s processors, kernels for `%s`, %s, version %s; %s.\n' \
        "$(fact processor)" "$(getconf _NPROCESSORS_ONLN)" "$(fact client_kernels)" "$(fact date)" \
        "$(fact version)" "$(sed -n 's/^# states of each row and seed: \([0-9]*\), seeds: \([0-9]*\).*/\1 states of each of \2 seeds/p' \
            "$work/mechanisms/chart.csv")"
} | fold -s -w 100 | sed 's/ *$//' | block measured
sed 's/^\([^|]*\)|\([^|]*\)|/`\1`|`totalforce \2`|/' "$work/runs" | table "run,command,seconds" | block runs

# The questions of which-method.md: "FIELD of KEYS" in the charts, by the names of their columns
{
    for name in hero cores single mechanisms; do
        sed "s/^/$name,/" "$work/$name/chart.csv"
    done
} | awk -F, -v one="$one" '
    $2 ~ /^#/ { next }
    $2 == "mechanism" { for (i = 1; i <= NF; i++) c[$i] = i; next }
    $c["status"] != "ok" { next }
    { key = $1 "/" $c["mechanism"] "/" $c["bodies"] "/" $c["method"] "/" $c["strategy"] "/" $c["precision"] "/" $c["threads"] "/" $c["refine"] "/" $c["rhs"] }
    { time[key] = $c["time_us"]; error[key] = $c["error"] }
    function at(list, key) { return key in list ? list[key] : "" }
    function us(key) { return key in time ? sprintf("%.2g µs", time[key]) : "(not measured)" }
    function off(method, mechanism) {
        key = "mechanisms/" mechanism "/" one "/" method "/single/f64/1/0/qdd"
        return key in error ? sprintf("%.0e", error[key]) : "(not measured)"
    }
    function over(a, b) { return (a in time) && (b in time) ? time[a] / time[b] : 0 }
    function median(list, n,    i, k, x) {
        for (i = 2; i <= n; i++)
            for (k = i; k > 1 && list[k] < list[k - 1]; k--) { x = list[k]; list[k] = list[k - 1]; list[k - 1] = x }
        return n ? list[int((n + 1) / 2)] : 0
    }
    END {
        arm = "hero/arm7/7/auto/"
        printf "fastest for my arm?|hero.svg|`auto`: %s a call, %s by a specialised kernel, %s in a batch; MuJoCo %s\n", us(arm "single/f64/1/0/qdd"),
            us(arm "specialised/f64/1/0/qdd"), us(arm "batch/f64/1/0/qdd"), us("hero/arm7/7/mujoco/single/f64/1/0/qdd")
        printf "exact on my chain?|bodies.svg|`aba`, `scan`: %s on %d random bodies, the floor of the data; `tfa` %s\n", off("aba", "random"), one, off("tfa", "random")
        for (key in time) {
            other = key
            if (key ~ /^cores.*\/f64\/1\// && sub(/f64\/1/, "f64/2", other) && other in time) {
                if (key ~ /batch/) batch[++batches] = over(key, other)
                else if (over(key, other) > best) { best = over(key, other); split(key, part_of, "/"); longest = part_of[3] }
            }
            if (key ~ /^single.*batch\/f32\/1\/0/ && sub(/f32/, "f64", other) && other in time) part[++parts] = over(key, other)
            if (key ~ /^single.*batch\/f32\/1\/0/ && other in error) lost[parts] = int(log(error[key] / error[other]) / log(10) + 0.5)
            other = key
            if (key ~ /^single.*single\/f32\/1\/0/ && sub(/f32/, "f64", other) && other in time) slower[++calls] = over(key, other)
        }
        printf "how many cores?|cores.svg|a second makes batches %.1f times as fast, one answer %s\n", median(batch, batches),
            best < 1.1 ? "no faster" : sprintf("up to %.1f times (%d bodies)", best, longest)
        printf "single precision?|single.svg|for batches: %.2f of the time for %d digits; one call takes %.1f times as long\n", median(part, parts), median(lost, parts), median(slower, calls)
        printf "which method fails?|atlas.png|`tfa`, `cfa`, `dca` beside light or thin links: `tfa` %s on %d thin rods, `aba` %s\n", off("tfa", "thin"), one, off("aba", "thin")
    }' | sed 's#|\([a-z]*\)\.\([a-z]*\)|#|[\1](pictures/\1.\2)|#' | table "question,picture,answer" | block questions

# on how many fronts a method is, alone or refined, by size
chart mechanisms | awk -F, '
    !($4 in seen) { seen[$4] = 1; method[++methods] = $4 }
    !($2 in known) { known[$2] = 1; size[++sizes] = $2 }
    { panel = $1 "," $2 "," $3 }
    !(panel in panels) { panels[panel] = 1; all[$2]++ }
    $19 && !((panel, $4) in on) { on[panel, $4] = 1; count[$4, $2]++; total[$4]++ }
    END {
        line = "bodies"
        for (k = 1; k <= sizes; k++) line = line "|" size[k]
        print line
        for (m = 1; m <= methods; m++) {
            if (!total[method[m]]) continue
            line = "`" method[m] "`"
            for (k = 1; k <= sizes; k++) line = line "|" count[method[m], size[k]] + 0
            print line
        }
        line = "panels"
        for (k = 1; k <= sizes; k++) line = line "|" all[size[k]]
        print line
    }' >"$work/fronts"
sed 1d "$work/fronts" | table "$(head -1 "$work/fronts" | sed 's/^bodies/on the front/; s/|/,/g')" | block fronts

# time over that of aba on random chains, alone: median over the right-hand sides
chart mechanisms | awk -F, '
    function median(list, n,  i, k, x, v) {
        split(list, v, " ")
        for (i = 2; i <= n; i++)
            for (k = i; k > 1 && v[k] + 0 < v[k - 1] + 0; k--) { x = v[k]; v[k] = v[k - 1]; v[k - 1] = x }
        return n % 2 ? v[(n + 1) / 2] : (v[n / 2] + v[n / 2 + 1]) / 2
    }
    $1 != "random" || $5 != 0 { next }
    !($4 in seen) { seen[$4] = 1; method[++methods] = $4 }
    !($2 in known) { known[$2] = 1; size[++sizes] = $2 }
    { state[$4, $2] = $8 }
    $8 == "ok" { n[$4, $2]++; all[$4, $2] = all[$4, $2] " " $17 }
    $8 == "ok" && $4 == "aba" { us[$2] = us[$2] " " $15; same["aba", $2] = "" }
    $24 != "" { same[$4, $2] = $24 }
    END {
        line = "method"
        for (k = 1; k <= sizes; k++) line = line "|" size[k]
        print line
        line = "`aba`, µs"
        for (k = 1; k <= sizes; k++) line = line "|" sprintf("%.3g", median(us[size[k]], n["aba", size[k]]))
        print line
        for (m = 1; m <= methods; m++) {
            if (method[m] == "aba") continue
            line = "`" method[m] "`"
            for (k = 1; k <= sizes; k++) {
                key = method[m] SUBSEP size[k]
                if (!n[key]) cell = state[key]
                else cell = sprintf("%.2g", median(all[key], n[key]))
                if (n[key] && same[key] != "") cell = cell " (" same[key] ")"
                line = line "|" cell
            }
            print line
        }
    }' >"$work/times"
sed 1d "$work/times" | table "$(head -1 "$work/times" | sed 's/^method/time over `aba`/; s/|/,/g')" | block times

# panels near the floor and far from it
chart mechanisms | awk -F, '
    $4 ~ /mujoco|kdl/ && $5 > 0 { next }
    !($4 in seen) { seen[$4] = 1; method[++methods] = $4 }
    $8 == "too_large" || $8 == "over_budget" { next }
    { floor = $13 > 1e-15 ? $13 : 1e-15 }
    $8 != "ok" { refused[$4, $5]++; next }
    { n[$4, $5]++; near[$4, $5] += $11 <= 10 * floor; far[$4, $5] += $11 > 100 * floor }
    { if ($21 / $20 > spread[$4, $5]) spread[$4, $5] = $20 > 0 ? $21 / $20 : 0 }
    END {
        for (m = 1; m <= methods; m++) {
            line = "`" method[m] "`"
            for (r = 0; r < 2; r++)
                if (n[method[m], r])
                    line = line sprintf("|%d|%d|%d|%d|%.2g", n[method[m], r], near[method[m], r], far[method[m], r],
                        refused[method[m], r], spread[method[m], r])
                else
                    line = line "|-|-|-|-|-"
            print line
        }
    }' | table "method,alone: answers,near,far,refused,spread,refined: answers,near,far,refused,spread" | block near

# the scans beside aba
for method in scan scan-two-pass; do
    chart mechanisms | awk -F, -v method=$method '
    $5 != 0 || $8 != "ok" { next }
    { key = $1 "`, " $2 " bodies, `" $3 }
    $4 == "aba" { aba[key] = $11 > 1e-14 ? $11 : 1e-14 }
    $4 == method { own[key] = $11 }
    END {
        for (key in own)
            if (key in aba) {
                n++
                ratio = own[key] / aba[key]
                above += ratio > 5
                if (ratio > most) { most = ratio; where = key }
            }
        printf "%s|%d|%d|%.2g|`%s`\n", "`" method "`", n, above, most, where
    }'
done | table 'method,cells,above five times `aba`,most,where' | block scan

# aba refined once, the best that double gives, over the floor
chart mechanisms | awk -F, '$4 == "aba" && $5 == 1 && $8 == "ok" {
        k = $3 "|" $2; if (!(k in n)) order[++keys] = k
        n[k]++; ratio = $11 / $13; within[k] += ratio <= 3
        if (ratio > most[k]) { most[k] = ratio; where[k] = $1 }
    }
    END { for (i = 1; i <= keys; i++) { k = order[i]
        printf "%s|%d|%d|%.2g|`%s`\n", k, n[k], within[k], most[k], where[k] } }' |
    sort -t'|' -k1,1 -k2,2n | table "right-hand side,bodies,mechanisms,within 3 floors,most,where" | block floor

# peers beside crba, where both answered: geometric mean of the ratio of errors
for name in mechanisms robots; do
    chart $name | awk -F, -v name=$name '
    $5 != 0 || $8 != "ok" || !($11 > 0) { next }
    { key = $1 "," $2 "," $3 }
    $4 == "crba" { crba[key] = $11 }
    $4 == "mujoco" || $4 == "kdl" { error[$4, key] = $11; peer[$4] = 1; keys[key] = 1 }
    END {
        for (p in peer) {
            n = sum = most = 0
            for (key in keys)
                if ((p, key) in error && key in crba) {
                    n++; sum += log(error[p, key] / crba[key])
                    if (error[p, key] > most) most = error[p, key]
                }
            if (n) printf "%s|`%s`|%d|%.2g|%.1e\n", p, name, n, exp(sum / n), most
        }
    }'
done | sort | table 'peer,run,cells,error over that of `crba`,largest error' | block peers

# the order that the paper states: error of tfa over that of others, median of the mechanisms without
# extreme masses and radii
chart mechanisms | awk -F, '
    $1 ~ /^(alternating|light-heavy|heavy-tip|thin)$/ || $3 == "gravity" || $5 != 0 { next }
    $8 == "ok" && $11 > 0 { error[$4, $3, $2, $1] = $11 }
    END {
        for (key in error) {
            split(key, k, SUBSEP)
            if (k[1] ~ /^(cfa|dca|scan|aba|crba)$/ && ("tfa", k[2], k[3], k[4]) in error)
                print k[3], k[1], k[2], error["tfa", k[2], k[3], k[4]] / error[key]
        }
    }' | sort -k1,1n -k2,3 -k4,4g | awk '
    { key = $2 " " $3; size = $1 }
    key " " size != now { now = key " " size; n = 0 }
    !(size in known) { known[size] = 1; sizes[++count] = size }
    { list[++n] = $4; at[key, size] = (list[int((n + 1) / 2)] + list[int(n / 2) + 1]) / 2 }
    function cells(key,  k, x, line) {
        for (k = 1; k <= count; k++) {
            x = at[key, sizes[k]]
            line = line " " (x == "" ? "-" : sprintf(x < 10 ? "%.2g" : "%.0f", x))
        }
        return line
    }
    END {
        for (k = 1; k <= count; k++) line = line " " sizes[k]
        print "`tfa` over, bodies|" line "|" line
        n = split("cfa dca scan aba crba", method, " ")
        for (m = 1; m <= n; m++)
            print "`" method[m] "`|" cells(method[m] " qdd") "|" cells(method[m] " tau")
    }' | sed 's/| */|/g' | table "$(fact processor) (\`$(fact client_kernels)\`),\`qdd\`,\`tau\`" | block order

# precisions of two methods
chart precision | awk -F, '
    $4 != "aba" && $4 != "tfa" { next }
    $8 == "ok" || $8 == "fallback" || $8 ~ /^E_/ {
        k = $6 "|" $4; if (!(k in seen)) { seen[k] = 1; order[++keys] = k }
        error[k, $3, $5] = $8 == "ok" ? sprintf("%.0e", $11) : $8
    }
    END { for (i = 1; i <= keys; i++) { k = order[i]; line = k
        for (r = 0; r < 3; r++) line = line "|" (error[k, "qdd", r] == "" ? "-" : error[k, "qdd", r])
        for (r = 0; r < 3; r++) line = line "|" (error[k, "tau", r] == "" ? "-" : error[k, "tau", r])
        print line } }' |
    sed 's/|\([a-z-]*\)|/|`\1`|/' |
    table "precision,method,qdd: 0 steps,1 step,2 steps,tau: 0 steps,1 step,2 steps" | block precision

# the atlas: its own sentences, a list for each map
for rhs in qdd tau gravity; do
    csv=$work/atlas-$rhs/atlas.csv
    sed -n 's/^# \([a-z-]*\): \(Alone\|Refined once\|From\|Largest\|The service\|Its largest\).*/\1/p' "$csv" | sort -u |
        while read -r map; do
            sed -n "s/^# $map: \(\(Alone\|Refined once\|From\|Largest\|The service\|Its largest\).*\)/* \1/p" "$csv" |
                block "$map-$rhs"
        done
    sed -n "s/^# all maps: Of \([0-9]*\) estimates the least is \([^ ]*\) times.* broken in \([0-9]*\) cells.*: \([0-9]*\)\.$/$rhs|\1|\2|\3|\4/p" "$csv"
done | table 'right-hand side,estimates,least over the true error,below 1/30 of it,errors above 1e-6 estimated below 1e-7' |
    block estimates
sed -n '/^# [a-z-]*: .*; value: /s/^# \([a-z-]*\): .*; value: \(.*\)/\1|\2/p' "$work/atlas-qdd/atlas.csv" |
    while IFS='|' read -r map value; do
        echo "$value|$(sed -n "s/^# $map: Alone,.* at some size: \(.*\)/\1/p" "$work/atlas-qdd/atlas.csv")|$(
            sed -n "s/^# $map: Refined once, still: \(.*\)/\1/p" "$work/atlas-qdd/atlas.csv")"
    done | sed 's/\. Never: [^|]*//g; s/none\./none/g' >"$work/fails"
table "axis,alone,refined once" <"$work/fails" | block fails-alone
cut -d'|' -f1,3 "$work/fails" | table "axis,refined once" | block fails
for rhs in qdd tau gravity; do
    rows atlas-$rhs/atlas | awk -F, -v rhs=$rhs '
    $6 == "service" { n += $7 + $8 + $9; own += $7; other += $8; none += $9; unsaid += $22 }
    END { printf "%s|%d|%d|%d|%d|%d\n", rhs, n, own, other, none, unsaid }'
done >"$work/service"
table "right-hand side,requests,answered by the method asked for,by another one,refused by name,wrong by more than 1e-4 without an estimate" \
    <"$work/service" | block service-table
awk -F'|' '{ for (k = 2; k <= 6; k++) sum[k] += $k }
    END { printf "Of %d default requests %d were answered by the method asked for, %d by another one,\n" \
        "%d refused by name; %d were wrong by more than 1e-4 without an estimate.\n",
        sum[2], sum[3], sum[4], sum[5], sum[6] }' "$work/service" | block service

# accuracy.md: what two tests print
if [ -s "$work/test_reference.txt" ]; then
    awk '
    /joints.*worst of/ { sub(/\.json:.*/, "", $1); robot = $1 }
    !/^  [a-z]/ { next }
    {
        name = $1
        for (k = 2; k < NF; k++) name = name " " $k
        if (!(name in worst)) order[++names] = name
        if ($NF + 0 > worst[name] + 0) { worst[name] = $NF; where[name] = robot }
    }
    END { for (k = 1; k <= names; k++) printf "%s|%s|%s\n", order[k], worst[order[k]], where[order[k]] }' \
        "$work/test_reference.txt" | table 'answer,worst error,robot' | block reference
fi
if [ -s "$work/test_laws.txt" ]; then
    awk '
    /^\[ RUN/ { column = $NF ~ /acceleration/ ? 1 : $NF ~ /lambda/ ? 3 : 0 }
    !/ worst .*, bound / { next }
    {
        line = $0; sub(/^ +/, "", line); name = line; sub(/ +worst .*/, "", name)
        split(line, part, /worst |, bound /)
    }
    name ~ /f128/ { if (part[2] + 0 > exact + 0) exact = part[2]; next }
    name ~ /f32|twice/ { next }
    name == "rnea" { rnea = part[2]; next }
    name == "M" { mass = part[2]; next }
    {
        refined = sub(/, refined/, "", name)
        if (!(name in seen)) { seen[name] = 1; method[++methods] = name }
        value[name, column + refined] = part[2]
    }
    END {
        for (m = 1; m <= methods; m++) {
            line = "`" method[m] "`"
            for (k = 1; k <= 4; k++)
                line = line "|" (value[method[m], k] == "" ? "-" : value[method[m], k])
            print line
        }
        printf "`rnea`: %s; mass matrix: %s; the worst of all in quadruple precision: %s.\n", rnea, mass, exact
    }' "$work/test_laws.txt" >"$work/laws"
    {
        sed '$d' "$work/laws" | table 'method,qdd,refined once,Λ⁻¹,refined once'
        echo
        tail -1 "$work/laws"
    } | block laws-table
    sed '$d' "$work/laws" | awk -F'|' -v exact="$(sed -n '$s/.*precision: \(.*\)\.$/\1/p' "$work/laws")" '
    { for (k = 2; k <= 5; k++) if ($k != "-" && $k + 0 > most[k] + 0) { most[k] = $k; where[k] = $1 } }
    function worst(k) { return most[k] " (" where[k] ")" }
    END { printf "Worst of all methods: qdd %s, refined %s; Λ⁻¹ %s,\nrefined %s; in quadruple precision %s.\n",
        worst(2), worst(3), worst(4), worst(5), exact }' | block laws
fi
