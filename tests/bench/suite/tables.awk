# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The tables of docs/performance.md, and one more, from what performance.sh measured:
#   awk -f tables.awk -v table=NAME -v folder=FOLDER

# Rows of a file by their key, made of `keys` columns, and the head of it; "" where there is no file
function load(file, keys,    line, f, n, k, key, at, head) {
    while ((getline line < (folder "/" file)) > 0) {
        if (line ~ /^#/) { head = head line "\n"; continue }
        n = split(line, f, ",")
        if (!at) {
            for (k = 1; k <= n; k++) column[file, f[k]] = k
            at = 1
            continue
        }
        key = f[1]
        for (k = 2; k <= keys; k++) key = key SUBSEP f[k]
        for (k = 1; k <= n; k++) cell[file, key, k] = f[k]
        if (!((file, f[1], f[2]) in seen)) {
            seen[file, f[1], f[2]] = 1
            list[file, ++count[file]] = f[1] SUBSEP f[2]
        }
    }
    close(folder "/" file)
    return head
}
# suite.csv: robot, base, joints, task, contestant
function suite(robot, base, task, who, what) {
    return cell["suite.csv", robot SUBSEP base SUBSEP joints[robot] SUBSEP task SUBSEP who,
                column["suite.csv", what]]
}
function ns(robot, base, task, who) { return suite(robot, base, task, who == "" ? "now" : who, "ns") }
function times(robot, base, task, who) { return suite(robot, base, task, who, "times") }

# For people: three digits, us from 10 000 ns on
function time_of(x) {
    if (x == "") return "-"
    if (x >= 99950) return sprintf("%.0f us", x / 1000)
    if (x >= 9995) return sprintf("%.1f us", x / 1000)
    return sprintf(x >= 99.95 ? "%.0f" : "%.1f", x)
}
function ratio(x) { return x == "" ? "-" : sprintf(x >= 9.95 ? "%.0f" : "%.2f", x) }
function over(x, y) { return x == "" || y == "" || y == 0 ? "-" : ratio(x / y) }
function name_of(robot, base) { return base == "floating" ? robot ", floating" : robot }

function learn_joints(    k, parts, key) {
    for (key in cell) {
        split(key, parts, SUBSEP)
        if (parts[1] == "suite.csv" && parts[7] == column["suite.csv", "joints"])
            joints[parts[2]] = parts[4]
    }
}
function rows(file) { return count[file] }
function pick(file, k,    parts) {
    split(list[file, k], parts, SUBSEP)
    robot = parts[1]
    base = parts[2]
}

function table_machine(    head, line, n, k) {
    head = load("suite.csv", 5)
    n = split(head, line, "\n")
    for (k = 1; k < n; k++) line[k] = substr(line[k], 3)
    print "Measured by `" line[1] "`, " line[2] ","
    print line[3] ", " line[4]
}

# Forward dynamics, batches, Lambda^-1, inverse dynamics and M of some robots; the others are in the picture
function table_robots(    k) {
    print "| robot | qdd | cold | estimated | batch f64 | batch f32 | Λ⁻¹ | tau | M | MuJoCo |"
    print "|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= rows("suite.csv"); k++) {
        pick("suite.csv", k)
        if (robot !~ /^(arm7|quadruped|humanoid30)$/ || base == "floating" && robot != "quadruped") continue
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name_of(robot, base),
            time_of(ns(robot, base, "fd")), time_of(ns(robot, base, "fd-cold")),
            time_of(ns(robot, base, "fd+estimate")), time_of(ns(robot, base, "batch-f64")),
            time_of(ns(robot, base, "batch-f32")), time_of(ns(robot, base, "lambda")),
            time_of(ns(robot, base, "id")), time_of(ns(robot, base, "mass")),
            ratio(times(robot, base, "fd", "mujoco"))
    }
}

# One column for each chain, ns a body
function table_chains(    k, n, line, c, r, tasks, task, chains) {
    n = 0
    for (k = 1; k <= rows("suite.csv"); k++) {
        pick("suite.csv", k)
        if (robot ~ /^chain/ && base == "fixed") chains[++n] = robot
    }
    line = "| ns a body |"
    for (k = 1; k <= n; k++) line = line " " chains[k] " |"
    print line
    line = "|---|"
    for (k = 1; k <= n; k++) line = line "---|"
    print line
    c = split("aba scan scan-2 tfa-cr-2 tfa-cr+1-2 lambda lambda-tfa-cr-2", tasks, " ")
    for (r = 1; r <= c; r++) {
        task = tasks[r]
        line = "| " task " |"
        for (k = 1; k <= n; k++)
            line = line " " ratio(suite(chains[k], "fixed", task, "now", "ns_per_joint")) " |"
        print line
    }
}

# The same rows for several sets: the set is part of the key.
function table_isa(    k, n, r, tasks, task, isas, m, i, line) {
    m = split("avx512 avx2 base", isas, " ")
    take_isa("isa.csv")
    take_isa("suite.csv")
    print "| robot | task | avx512 | avx2 | base |"
    print "|---|---|---|---|---|"
    n = split("fd lambda batch-f64 batch-f32 scan scan-2 tfa-cr tfa-cr-2", tasks, " ")
    for (k = 1; k <= robots_of_isa; k++)
        for (r = 1; r <= n; r++) {
            robot = isa_robot[k]
            task = tasks[r]
            if (robot !~ /^(arm7|chain1000)$/) continue
            if (isa_ns[robot, task, "avx2"] == "" && isa_ns[robot, task, "base"] == "") continue
            line = "| " robot " | " task " |"
            for (i = 1; i <= m; i++) line = line " " time_of(isa_ns[robot, task, isas[i]]) " |"
            print line
        }
}
function take_isa(file,    line, f, n, at, k) {
    at = 0
    while ((getline line < (folder "/" file)) > 0) {
        n = split(line, f, ",")
        if (line ~ /^#/) continue
        if (!at) { for (k = 1; k <= n; k++) c_of[f[k]] = k; at = 1; continue }
        if (f[2] != "fixed" || f[5] != "now") continue
        if (file == "isa.csv" && !(f[1] in isa_known)) { isa_known[f[1]] = 1; isa_robot[++robots_of_isa] = f[1] }
        isa_ns[f[1], f[4], f[c_of["isa"]]] = f[c_of["ns"]]
    }
    close(folder "/" file)
}

BEGIN {
    SUBSEP = "\034"
    load("suite.csv", 5)
    learn_joints()
    if (table == "machine") table_machine()
    else if (table == "robots") table_robots()
    else if (table == "chains") table_chains()
    else if (table == "isa") table_isa()
    else { print "no table " table > "/dev/stderr"; exit 1 }
}
