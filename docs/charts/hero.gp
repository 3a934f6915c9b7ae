# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The chart of the README: error against time of one answer, a panel for each robot.
# Given: data, the output of hero.awk; output; note, the line below the chart.
set terminal svg size 830,600 font 'sans,13' background rgb 'white'
set output output
set multiplot
set label 1 "In double precision every strategy is exact to rounding: choose by time" \
    at screen 0.5, screen 0.97 center font ',17' noenhanced
set label 2 "Forward dynamics: relative error against quadruple precision, and time of one answer" \
    at screen 0.5, screen 0.932 center font ',12' tc rgb '#555555' noenhanced
set logscale xy
set xrange [0.02:40]; set yrange [1e-16:1e0]
set ytics ("10^{-15}" 1e-15, "10^{-10}" 1e-10, "10^{-5}" 1e-5) font ',11' tc rgb '#333333'; unset mytics
set grid xtics ytics lc rgb '#e4e4e4' lt 1 lw 0.6
set border 3 lc rgb '#888888'; set tics nomirror scale 0.4
unset key
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
colour(k) = k == 1 ? 0x0B3C8C : k == 2 ? 0x2F7FBF : 0xB5401B
name = "'7-joint arm' '12-joint quadruped' '47-joint humanoid'"
# of the panel's points, those whose label stands at a level above (1), beside it (0), right above (-1), a line higher (-2)
x(p, place) = column(1) == p && (column(5) > 0 ? 1 : column(5)) == place ? column(2) : NaN
top(level) = 10 ** (-13.8 + 1.45 * level)
do for [p=0:2] {
    set origin 0.075, 0.645 - 0.285 * p
    set size 0.91, 0.25
    set label 3 word(name, p + 1) at graph 0.99, graph 0.93 right front font ',13' noenhanced
    if (p < 2) {
        set xtics ("" 0.02, "" 0.05, "" 0.1, "" 0.2, "" 0.5, "" 1, "" 2, "" 5, "" 10, "" 20)
    } else {
        set xtics ("20 ns" 0.02, "50 ns" 0.05, "0.1 µs" 0.1, "0.2 µs" 0.2, "0.5 µs" 0.5, "1 µs" 1, "2 µs" 2, \
                   "5 µs" 5, "10 µs" 10, "20 µs" 20) font ',11' tc rgb '#333333'
        set label 4 note at screen 0.985, screen 0.016 right font ',10' tc rgb '#666666' noenhanced
    }
    plot data using (x(p, 1)):3:(0):(top($5) - $3) with vectors nohead lw 0.8 lc rgb '#9fb2d0', \
         data using ($1 == p ? $2 : NaN):3:(colour($4)) with points pt 7 ps 0.75 lc rgb variable, \
         data using (x(p, 1)):(top($5)):6:(colour($4)) with labels left offset -0.2,0.5 font ',11' tc rgb variable noenhanced, \
         data using (x(p, 0)):3:6:(colour($4)) with labels left offset 0.8,0 font ',11' tc rgb variable noenhanced, \
         data using (x(p, -1)):3:6:(colour($4)) with labels left offset -0.5,0.7 font ',11' tc rgb variable noenhanced, \
         data using (x(p, -2)):3:6:(colour($4)) with labels left offset -0.5,1.75 font ',11' tc rgb variable noenhanced
    unset label 1; unset label 2; unset label 3; unset label 4
}
unset multiplot
