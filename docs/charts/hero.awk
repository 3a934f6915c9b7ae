# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Rows of chart.csv as the points of hero.gp: panel, time, error, kind (1 ours, 2 single precision,
# 3 a peer), level of the label above the point (0: beside it; -1: right above it; -2: a line higher), label.
BEGIN {
    FS = ","
    ours["single/f64/1"] = "one call"
    ours["specialised/f64/1"] = "specialised kernel"
    ours["batch/f64/1"] = "batch"
    ours["batch/f64/2"] = "batch, 2 threads"
    ours["specialised-batch/f64/1"] = "specialised batch"
    ours["specialised-batch/f64/2"] = "specialised batch, 2 threads"
    beside["batch/f32/1"] = "batch, single precision"
    beside["specialised-batch/f32/1"] = "specialised batch, single precision"
    peers["mujoco"] = "MuJoCo"
    peers["kdl"] = "Orocos KDL"
    CHARACTER = 6.1 / 229 # width of one, in decades of the axis of time
}
/^#/ { next }
!head { for (i = 1; i <= NF; i++) column[$i] = i; head = 1; next }
function value(name) { return $column[name] }
value("status") == "ok" {
    if (!(value("mechanism") in panel))
        panel[value("mechanism")] = panels++
    strategy = value("strategy") "/" value("precision") "/" value("threads")
    method = value("method")
    if (method in peers) { kind = 3; label = peers[method] }
    else if (method == "auto" && strategy in ours) { kind = 1; label = ours[strategy] }
    else if (method == "auto" && strategy in beside) { kind = 2; label = beside[strategy] }
    else next
    n++
    where[n] = panel[value("mechanism")]
    time[n] = value("time_us") + 0
    error[n] = value("error") + 0
    kinds[n] = kind
    labels[n] = label
}
# Labels from the right to the left, each on the lowest level where it meets no other.
END {
    for (;;) {
        next_one = 0
        for (i = 1; i <= n; i++)
            if (!done[i] && (!next_one || time[i] > time[next_one]))
                next_one = i
        if (!next_one)
            break
        done[next_one] = 1
        p = where[next_one]
        left = log(time[next_one]) / log(10)
        level = kinds[next_one] == 2 ? labels[next_one] ~ /^specialised/ ? -2 : -1 : 0
        if (kinds[next_one] == 1)
            for (level = 1; (p, level) in from && left + CHARACTER * length(labels[next_one]) > from[p, level];)
                level++
        if (level > 0)
            from[p, level] = left
        printf "%d %g %g %d %d \"%s\"\n", p, time[next_one], error[next_one], kinds[next_one], level, labels[next_one]
    }
}
