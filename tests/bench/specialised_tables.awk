# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Tables from what `bench_suite --kernels FOLDER` wrote; `page` is that of docs/specialised.md:
#   awk -f specialised_tables.awk -v table=NAME suite.csv [MORE.csv]
#
# Of a time that several runs have, the least counts: a virtual machine is sometimes slower, never faster.
BEGIN { FS = "," }
/^#/ || /^robot/ { next }
NF > 8 { # rows of the suite: robot, base, joints, contestant, figure, value, times, difference
    who = $5 == "now" ? "generic" : $5
    figure = $4 == "kernel_error" ? "error" : $4
    sub(/^batch-f64/, "batch", figure)
    $4 = who; $5 = figure; $6 = $12; $7 = $15; $8 = $16
}
{
    name = $2 == "floating" ? $1 ", floating" : $1
    if (!(name in joints)) list[++count] = name
    joints[name] = $3
    if ($7 == "" || !((name, $4, $5) in value) || $6 + 0 < value[name, $4, $5] + 0) value[name, $4, $5] = $6
    if ($8 != "" && $8 + 0 > worst[name] + 0) worst[name] = $8
}
function time_of(x) {
    if (x == "") return "-"
    return x >= 99950 ? sprintf("%.0f us", x / 1000) : x >= 9995 ? sprintf("%.1f us", x / 1000) : \
        sprintf(x >= 99.95 ? "%.0f" : "%.1f", x)
}
function over(x, y) { return x == "" || y == "" ? "-" : sprintf("%.2f", x / y) }
function specialised(task) { return value[name, "specialised", task] }
function generic(task) { return value[name, "generic", task] }
function pair(task) { return time_of(generic(task)) " | " time_of(specialised(task)) " | " over(generic(task), specialised(task)) }

function times(task) { return over(generic(task), specialised(task)) }
function second(x) { return x == "" ? "-" : sprintf("%.1f", x) }
function table_cold(    k) {
    print "| robot | chained fd | own | x | cold fd | own | x | cold id | own | x | cold Λ⁻¹ | own | x |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        printf "| %s | %s | %s | %s | %s |\n", name, pair("fd-chained"), pair("fd-cold"), pair("id-cold"),
            pair("lambda-cold")
    }
}
# The table of the page, of the bundled robots: how many times as long as the specialised kernel the generic one
# takes
function table_page(    k) {
    print "| robot | qdd, ns | x | tau | Λ⁻¹ | batch | in float | cold qdd | compile, s |"
    print "|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        if (name !~ /^(arm7|quadruped|humanoid)(,|$)/) continue
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name, time_of(generic("fd")), times("fd"), times("id"),
            times("lambda"), times("batch"), times("batch-f32"), times("fd-cold"), second(specialised("compile_s"))
    }
}
# Payloads and wrenches of requests
function table_loads(    k) {
    print "| robot | joints | payload: qdd | specialised | x | batch, x | in float, x | wrench: qdd | specialised | x | tau, x | batch qdd, x | tau, x | in float, qdd, x |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name, joints[name], pair("fd+payload"),
            times("batch+payload"), times("batch-f32+payload"), pair("fd+wrench"), times("id+wrench"),
            times("batch+wrench"), times("batch-id+wrench"), times("batch-f32+wrench")
    }
}
END {
    if (table == "cold") table_cold()
    else if (table == "loads") table_loads()
    else if (table == "page") table_page()
    else { print "specialised_tables.awk: no table " table; exit 1 }
}
