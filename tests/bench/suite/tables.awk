# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The tables of docs/performance.md from what performance.sh measured:
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
    for (k = 1; k < n; k++) print "    " substr(line[k], 3)
}

function table_one(    k) {
    print "| robot | joints | ns a call | ns a joint | chained | cold | estimated | former | MuJoCo | KDL |"
    print "|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= rows("suite.csv"); k++) {
        pick("suite.csv", k)
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name_of(robot, base),
            joints[robot], time_of(ns(robot, base, "fd")), ratio(suite(robot, base, "fd", "now", "ns_per_joint")),
            time_of(ns(robot, base, "fd-chained")), time_of(ns(robot, base, "fd-cold")),
            time_of(ns(robot, base, "fd+estimate")), ratio(times(robot, base, "fd", "former")),
            ratio(times(robot, base, "fd", "mujoco")), ratio(times(robot, base, "fd", "kdl"))
    }
}

function table_lambda(    k) {
    print "| robot | one tip | four tips | one, estimated | former, one | with fd / fd | former | id | M |"
    print "|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= rows("suite.csv"); k++) {
        pick("suite.csv", k)
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name_of(robot, base),
            time_of(ns(robot, base, "lambda")), time_of(ns(robot, base, "lambda-4")),
            time_of(ns(robot, base, "lambda+estimate")), ratio(times(robot, base, "lambda", "former")),
            over(ns(robot, base, "fd+lambda"), ns(robot, base, "fd")),
            over(ns(robot, base, "fd+lambda", "former"), ns(robot, base, "fd", "former")),
            time_of(ns(robot, base, "id")), time_of(ns(robot, base, "mass"))
    }
}

function table_batches(    k) {
    print "| robot | joints | f64 | 2 threads | gain | f32 | 2 threads | gain | former f64 | former f32 | id | one tip |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for (k = 1; k <= rows("suite.csv"); k++) {
        pick("suite.csv", k)
        if (ns(robot, base, "batch-f64") == "") continue
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", name_of(robot, base), joints[robot],
            time_of(ns(robot, base, "batch-f64")), time_of(ns(robot, base, "batch-f64-2")),
            over(ns(robot, base, "batch-f64"), ns(robot, base, "batch-f64-2")),
            time_of(ns(robot, base, "batch-f32")), time_of(ns(robot, base, "batch-f32-2")),
            over(ns(robot, base, "batch-f32"), ns(robot, base, "batch-f32-2")),
            ratio(times(robot, base, "batch-f64", "former")), ratio(times(robot, base, "batch-f32", "former")),
            time_of(ns(robot, base, "batch-id")), time_of(ns(robot, base, "batch-lambda"))
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
    for (k = 1; k <= n; k++) line = line " " chains[k] " | former |"
    print line
    line = "|---|"
    for (k = 1; k <= n; k++) line = line "---|---|"
    print line
    c = split("aba aba+estimate auto-2 scan scan-2 scan+estimate scan+estimate-2 scan-two-pass tfa tfa-cr tfa-cr-2 " \
              "tfa-cr+1 tfa-cr+1-2 cfa-cr cfa-cr-2 lambda lambda-scan lambda-scan-2 lambda-tfa-cr lambda-tfa-cr-2", tasks, " ")
    for (r = 1; r <= c; r++) {
        task = tasks[r]
        line = "| " task " |"
        for (k = 1; k <= n; k++)
            line = line " " ratio(suite(chains[k], "fixed", task, "now", "ns_per_joint")) " | x" \
                   ratio(times(chains[k], "fixed", task, "former")) " |"
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

function table_instructions(    k, r, n, tasks, line, x, y) {
    load("instructions.csv", 5)
    n = split("fd fd+estimate fd+lambda lambda lambda-4 batch-f64 scan tfa-cr", tasks, " ")
    line = "| robot |"
    for (r = 1; r <= n; r++) line = line " " tasks[r] " | former |"
    print line
    gsub(/ [^|]+ /, "---", line)
    print line
    for (k = 1; k <= rows("instructions.csv"); k++) {
        pick("instructions.csv", k)
        line = "| " name_of(robot, base) " |"
        for (r = 1; r <= n; r++) {
            x = instructions(tasks[r], "now")
            y = instructions(tasks[r], "former")
            line = line " " (x == "" ? "-" : sprintf("%d", x)) " | x" over(y, x) " |"
        }
        print line
    }
}
function instructions(task, who) {
    return cell["instructions.csv", robot SUBSEP base SUBSEP joints[robot] SUBSEP task SUBSEP who,
                column["instructions.csv", "instructions"]]
}

function table_peak(    line, f, n, at) {
    print "| robot | bodies | number | what | how | set | ns a state | times | flop a state | Gflop/s | peak | share |"
    print "|---|---|---|---|---|---|---|---|---|---|---|---|"
    while ((getline line < (folder "/peak.csv")) > 0) {
        if (line ~ /^#/ || !at++ && line ~ /^robot/) continue
        n = split(line, f, ",")
        if (line ~ /^robot/) continue
        printf "| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", f[1], f[2], f[3], f[4], f[5],
            f[6], f[7], f[8], f[9], f[10], f[11], f[12]
    }
}

# ---- targets: stated for the reference machine, whose speed MuJoCo 2.2.2 tells ----

# What it takes there for robots of the kind of ours (docs: iiwa14, solo12, atlas, valkyrie, chain 64)
function machine_factor(    ref, robot, sum, n) {
    ref["arm7"] = 1712; ref["quadruped"] = 2660; ref["humanoid30"] = 7496
    ref["humanoid58"] = 15677; ref["chain64"] = 43379
    for (robot in ref)
        if (ns(robot, "fixed", "fd", "mujoco") != "") {
            sum += log(ref[robot] / ns(robot, "fixed", "fd", "mujoco"))
            n++
        }
    return n ? exp(sum / n) : 0
}
function target(what, robot, base, task, limit, stretch,    x, there) {
    x = ns(robot, base, task)
    if (x == "") return
    there = factor ? x * factor : ""
    printf "| %s | %s | %s | %s | %s | %s | %s |\n", what, limit == "" ? "-" : time_of(limit),
        stretch == "" ? "-" : time_of(stretch), time_of(x), time_of(there),
        ratio(times(robot, base, task, "former")),
        there == "" || limit == "" ? "" : there <= limit ? (stretch != "" && there <= stretch ? "stretch" : "yes") : \
            sprintf("no: %.2f x", there / limit)
}
function target_ratio(what, x, limit, most) {
    if (x == "-") return
    printf "| %s | %s | - | %s | - | - | %s |\n", what, limit, x, (most ? x <= limit : x >= limit) ? "yes" : "no"
}
function table_targets() {
    factor = machine_factor()
    if (factor)
        printf "MuJoCo 2.2.2 takes %.2f times as long on the reference machine as in this run (geometric mean of five " \
            "robots): times \"there\" are ours times that.\n\n", factor
    print "| what | target | stretch | here | there | former / now | met |"
    print "|---|---|---|---|---|---|---|"
    target("7-joint arm", "arm7", "fixed", "fd", 420, 350)
    target("12-joint quadruped", "quadruped", "fixed", "fd", 400, 329)
    target("30-joint humanoid", "humanoid30", "fixed", "fd", 1000, "")
    target("58-joint humanoid", "humanoid58", "fixed", "fd", 1900, "")
    target_ratio("arm, floating / fixed", over(ns("arm7", "floating", "fd"), ns("arm7", "fixed", "fd")), 1.3, 1)
    target_ratio("quadruped, floating / fixed", over(ns("quadruped", "floating", "fd"), ns("quadruped", "fixed", "fd")), 1.3, 1)
    target_ratio("humanoid30, floating / fixed", over(ns("humanoid30", "floating", "fd"), ns("humanoid30", "fixed", "fd")), 1.3, 1)
    target_ratio("humanoid58, floating / fixed", over(ns("humanoid58", "floating", "fd"), ns("humanoid58", "fixed", "fd")), 1.3, 1)
    target("arm, batch, f64", "arm7", "fixed", "batch-f64", 115, 95)
    target("arm, batch, f32", "arm7", "fixed", "batch-f32", 65, "")
    target("humanoid30, batch, f64", "humanoid30", "fixed", "batch-f64", 500, "")
    target_ratio("arm, batch, two threads", over(ns("arm7", "fixed", "batch-f64"), ns("arm7", "fixed", "batch-f64-2")), 1.9, 0)
    target_ratio("humanoid30, batch, two threads", over(ns("humanoid30", "fixed", "batch-f64"), ns("humanoid30", "fixed", "batch-f64-2")), 1.9, 0)
    target("chain of 1000, aba", "chain1000", "fixed", "aba", 80000, "")
    target("chain of 1000, aba, estimated", "chain1000", "fixed", "aba+estimate", "", "")
    target("chain of 1000, scan", "chain1000", "fixed", "scan", 40000, "")
    target("chain of 1000, scan, two threads", "chain1000", "fixed", "scan-2", 22000, 18000)
    target("chain of 1000, scan, two threads, estimated", "chain1000", "fixed", "scan+estimate-2", "", "")
    target("chain of 1000, tfa-cr", "chain1000", "fixed", "tfa-cr", 110000, "")
    target("chain of 1000, tfa-cr, two threads", "chain1000", "fixed", "tfa-cr-2", 60000, 45000)
    target_ratio("tfa-cr refined and estimated / bare", over(ns("chain1000", "fixed", "tfa-cr+1"), ns("chain1000", "fixed", "tfa-cr")), 1.6, 1)
    target_ratio("the same, two threads", over(ns("chain1000", "fixed", "tfa-cr+1-2"), ns("chain1000", "fixed", "tfa-cr-2")), 1.6, 1)
    target_ratio("aba, ns a body, chain of 4096 / of 64", over(suite("chain4096", "fixed", "aba", "now", "ns_per_joint"), suite("chain64", "fixed", "aba", "now", "ns_per_joint")), 1.1, 1)
    target("arm, lambda_inv", "arm7", "fixed", "lambda", 500, 306)
    target("quadruped, lambda_inv of a leg", "quadruped", "fixed", "lambda", 200, 97)
    target("humanoid30, lambda_inv", "humanoid30", "fixed", "lambda", 950, "")
    target("humanoid30, lambda_inv of four tips", "humanoid30", "fixed", "lambda-4", 2000, "")
    target_ratio("arm, both in one request / fd", over(ns("arm7", "fixed", "fd+lambda"), ns("arm7", "fixed", "fd")), 1.35, 1)
    target_ratio("humanoid30, both in one request / fd", over(ns("humanoid30", "fixed", "fd+lambda"), ns("humanoid30", "fixed", "fd")), 1.35, 1)
    target("chain of 1000, lambda_inv by scan, two threads", "chain1000", "fixed", "lambda-scan-2", "", "")
    target("chain of 1000, lambda_inv by tfa-cr, two threads", "chain1000", "fixed", "lambda-tfa-cr-2", "", "")
}

# ---- fixed marks: published by others for the reference machine ----

function mark(robot, joints, best, generated, ours, base,    x) {
    x = ns(ours, "fixed", "fd")
    printf "| %s | %s | %s | %s | %s | %s | %s |\n", robot, joints, time_of(best), time_of(generated), ours,
        time_of(x == "" || !factor ? "" : x * factor), over(best, x == "" || !factor ? "" : x * factor)
}
function first_of(a, b) { return ns(a, "fixed", "fd") != "" ? a : b }
function table_marks() {
    factor = machine_factor()
    print "| robot | joints | best library | code-generated | ours | there, ns | best library / ours |"
    print "|---|---|---|---|---|---|---|"
    mark("iiwa14", 7, 1035, 348, first_of("iiwa14", "arm7"))
    mark("panda with fingers", 9, 1353, 422, first_of("panda", "arm7"))
    mark("solo12", 12, 1490, 329, first_of("solo12", "quadruped"))
    mark("allegro", 16, 1995, "", first_of("allegro_right", ""))
    mark("g1", 29, 4453, 1718, "humanoid30")
    mark("atlas", 30, 4700, 1523, "humanoid30")
    mark("valkyrie", 58, 8934, "", "humanoid58")
    mark("chain 64", 64, 10287, "", "chain64")
    mark("chain 1000", 1000, 168000, "", "chain1000")
    mark("chain 4096", 4096, 705000, "", "chain4096")
}

BEGIN {
    SUBSEP = "\034"
    load("suite.csv", 5)
    learn_joints()
    if (table == "machine") table_machine()
    else if (table == "targets") table_targets()
    else if (table == "marks") table_marks()
    else if (table == "one") table_one()
    else if (table == "batches") table_batches()
    else if (table == "chains") table_chains()
    else if (table == "lambda") table_lambda()
    else if (table == "isa") table_isa()
    else if (table == "instructions") table_instructions()
    else if (table == "peak") table_peak()
    else { print "no table " table > "/dev/stderr"; exit 1 }
}
