# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Time of the Lambda^-1 of one link, a row for each method, a panel for each robot; errors that are no
# rounding stand beside their points.
# Given: chart, a chart.csv with --op operational_inertia; output; note, the line below the chart.
set terminal svg size 830,470 font 'sans,13' background rgb 'white'
set output output
set multiplot
set label 1 "Λ⁻¹ of a tool: specialised kernels, pv-osimr and propagation lead, exact to rounding" \
    at screen 0.5, screen 0.955 center font ',16' noenhanced
set label 2 "Time of one call, one thread; orange: relative error above 1e-14, as written beside the point" \
    at screen 0.5, screen 0.905 center font ',12' tc rgb '#555555' noenhanced
set label 3 note at screen 0.985, screen 0.02 right font ',10' tc rgb '#666666' noenhanced
methods = 'specialised pv-osimr propagation efpa scan crba mujoco tfa-one-sided tfa tfa-cr cfa cfa-cr dca hessenberg'
shown(k) = word(methods, k) eq 'specialised' ? 'specialised kernel' : word(methods, k) eq 'mujoco' ? 'MuJoCo' : word(methods, k)
robots = 'arm7 quadruped humanoid random'
names = "'7-joint arm' '12-joint quadruped' '47-joint humanoid' 'chain of 128'"
rows = words(methods)
# place of the method, time, error; of one robot
points(robot) = sprintf("< awk -F, -v methods='%s' 'BEGIN { n = split(methods, m, \" \"); for (i = 1; i <= n; i++) at[m[i]] = n - i } " \
    ."/^#/ { next } !head { for (i = 1; i <= NF; i++) c[$i] = i; head = 1; next } " \
    ."{ name = $c[\"strategy\"] == \"specialised\" ? \"specialised\" : $c[\"strategy\"] == \"single\" ? $c[\"method\"] : \"\" } " \
    ."$c[\"mechanism\"] == \"%s\" && $c[\"op\"] == \"operational_inertia\" && $c[\"status\"] == \"ok\" && $c[\"threads\"] == 1 && (name in at) " \
    ."{ print at[name], $c[\"time_us\"], $c[\"error\"], sprintf(\"%%.0e\", $c[\"error\"]) }' %s", methods, robot, chart)
set logscale x
set xrange [0.1:4000]; set yrange [-0.7:rows - 0.3]
set xtics ("0.1" 0.1, "1 µs" 1, "10" 10, "100" 100, "1 ms" 1000) font ',11'
set grid xtics ytics lc rgb '#e4e4e4' lt 1 lw 0.6
set border 3 lc rgb '#888888'; set tics nomirror scale 0.4
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
unset key
do for [p=1:4] {
    set origin 0.175 + 0.205 * (p - 1), 0.1
    set size 0.185, 0.72
    set ytics ()
    do for [k=1:rows] { set ytics add ((p == 1 ? shown(k) : '') rows - k) font ',12' noenhanced }
    set label 4 word(names, p) at graph 0.5, graph 1.04 center font ',12' noenhanced
    plot points(word(robots, p)) using ($3 <= 1e-14 ? $2 : NaN):1 with points pt 7 ps 0.9 lc rgb '#0B3C8C', \
         points(word(robots, p)) using ($3 > 1e-14 ? $2 : NaN):1 with points pt 7 ps 0.9 lc rgb '#D55E00', \
         points(word(robots, p)) using ($3 > 1e-14 && $2 < 300 ? $2 : NaN):1:4 with labels left offset 0.8,0 font ',10' tc rgb '#B5401B', \
         points(word(robots, p)) using ($3 > 1e-14 && $2 >= 300 ? $2 : NaN):1:4 with labels right offset -0.8,0 font ',10' tc rgb '#B5401B'
    unset label 1; unset label 2; unset label 3
}
unset multiplot
