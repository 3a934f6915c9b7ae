# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The tables of docs/specialised.md from what `bench_suite --kernels FOLDER` wrote:
#   awk -f own_tables.awk -v table=NAME own.csv [MORE.csv]
#
# Of a time that several runs have, the least counts: a virtual machine is sometimes slower, never faster.
# "There": on the machine for which targets are stated. How much faster that one is MuJoCo 2.2.2 tells, by its times there
# for UR10, iiwa14, panda, solo12 and atlas: of the robot itself or of one of its shape in this run, or else of the
# first four.
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
function own(task) { return value[name, "own", task] }
function generic(task) { return value[name, "generic", task] }
function pair(task) { return time_of(generic(task)) " | " time_of(own(task)) " | " over(generic(task), own(task)) }

function factor(    robot, sum, n) {
    ref["iiwa14"] = 1712; ref["panda"] = 2108; ref["solo12"] = 2660; ref["ur5"] = 1548
    for (robot in ref)
        if (value[robot, "mujoco", "fd"] != "") {
            sum += log(ref[robot] / value[robot, "mujoco", "fd"])
            n++
        }
    return n ? exp(sum / n) : 1
}

function second(x) { return x == "" ? "-" : sprintf("%.1f", x) }
function table_kernels(    k) {
    print "| robot | joints | code, KB | compile, s | of processors, s | load and test, ms | largest difference |"
    print "|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        printf "| %s | %s | %.0f | %s | %s | %.1f | %.0e |\n", name, joints[name], own("code_bytes") / 1000,
            second(own("compile_s")), second(own("compilers_s")), own("load_ms"), own("error")
    }
}
function table_warm(    k) {
    print "| robot | joints | fd | own | x | id | own | x | Λ⁻¹ | own | x | fd and Λ⁻¹ | own | x | MuJoCo fd |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        printf "| %s | %s | %s | %s | %s | %s | %s |\n", name, joints[name], pair("fd"), pair("id"), pair("lambda"),
            pair("fd+lambda"), time_of(value[name, "mujoco", "fd"])
    }
}
function table_cold(    k) {
    print "| robot | chained fd | own | x | cold fd | own | x | cold id | own | x | cold Λ⁻¹ | own | x |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        printf "| %s | %s | %s | %s | %s |\n", name, pair("fd-chained"), pair("fd-cold"), pair("id-cold"),
            pair("lambda-cold")
    }
}
function table_batch(    k) {
    print "| robot | fd | own | x | id | own | x |"
    print "|---|---|---|---|---|---|---|"
    for (k = 1; k <= count; k++) {
        name = list[k]
        printf "| %s | %s | %s |\n", name, pair("batch"), pair("batch-id")
    }
}
function target(what, robot, task, limit, stretch,    here, there, base) {
    name = robot
    here = own(task)
    if (here == "") return
    there = here * (robot in kin && value[robot, "mujoco", "fd"] != "" ? kin[robot] / value[robot, "mujoco", "fd"] : scale)
    printf "| %s | %s | %s%s | %s | %s | %s | %s |\n", what, robot, limit, stretch ? " (" stretch ")" : "",
        time_of(generic(task)), time_of(here), time_of(there),
        there <= limit ? (stretch && there <= stretch ? "stretch" : "yes") : sprintf("no: %.2f x", there / limit)
}
function seconds(what, robot, figure, limit, unit) {
    name = robot
    if (own(figure) == "") return
    printf "| %s | %s | %s %s | - | %.1f | - | %s |\n", what, robot, limit, unit, own(figure),
        own(figure) <= limit ? "yes" : sprintf("no: %.2f x", own(figure) / limit)
}
function each(what, robots, task, limit, stretch,    n, k, r) {
    n = split(robots, r, " ")
    for (k = 1; k <= n; k++) target(what, r[k], task, limit, stretch)
}
function table_targets() {
    scale = factor()
    printf "MuJoCo 2.2.2 takes %.2f times as long on the reference machine as in this run (geometric mean of ur5, iiwa14, panda " \
        "and solo12).\n\n", scale
    kin["arm6"] = kin["ur5"] = 1548; kin["arm7"] = kin["iiwa14"] = 1712; kin["panda"] = 2108
    kin["quadruped"] = kin["solo12"] = kin["go2"] = 2660; kin["humanoid30"] = 7496
    print "| what | robot | target (stretch), ns | generic here | own here | there | met |"
    print "|---|---|---|---|---|---|---|"
    each("forward dynamics, 6 joints", "arm6 ur5", "fd", 180)
    each("forward dynamics, 7 joints", "arm7 iiwa14", "fd", 290, 230)
    each("forward dynamics, 9 joints", "panda", "fd", 360)
    each("forward dynamics, quadruped", "quadruped solo12 go2", "fd", 280)
    each("forward dynamics, 30 joints", "humanoid30 simple_humanoid", "fd", 900)
    each("Λ⁻¹, 6 joints", "arm6 ur5", "lambda", 190)
    each("Λ⁻¹, 7 joints", "arm7 iiwa14", "lambda", 250)
    each("Λ⁻¹, 9 joints", "panda", "lambda", 300)
    each("Λ⁻¹, a leg", "quadruped solo12 go2", "lambda", 90)
    each("Λ⁻¹, 30 joints", "humanoid30 simple_humanoid", "lambda", 700)
    each("a state of a batch, 7 joints", "arm7 iiwa14", "batch", 75)
    each("a state of a batch, 30 joints", "humanoid30 simple_humanoid", "batch", 400)
    seconds("compile, arm", "arm7", "compile_s", 5, "s")
    seconds("compile, humanoid", "humanoid30", "compile_s", 20, "s")
    seconds("compile, humanoid", "humanoid", "compile_s", 20, "s")
    seconds("load and test, arm", "arm7", "load_ms", 50, "ms")
    seconds("load and test, humanoid", "humanoid30", "load_ms", 50, "ms")
    seconds("load and test, humanoid", "humanoid", "load_ms", 50, "ms")
}
END {
    if (table == "kernels") table_kernels()
    else if (table == "warm") table_warm()
    else if (table == "cold") table_cold()
    else if (table == "batch") table_batch()
    else if (table == "targets") table_targets()
    else { print "own_tables.awk: no table " table; exit 1 }
}
