# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Energy error of robots that swing freely. Given: data and labels, the output of drift.awk for the arm with two steps and
# for a chain of thin rods; output; note.
set terminal svg size 830,430 font 'sans,13' background rgb 'white'
set output output
set multiplot
set label 1 "Energy tells digits apart: aba in double drifts as the integrator does, thin rods break tfa" \
    at screen 0.5, screen 0.955 center font ',16' noenhanced
set label 2 "Free swinging by an integrator of order 8: largest energy error so far; grey: accelerations in quadruple precision" \
    at screen 0.5, screen 0.905 center font ',12' tc rgb '#555555' noenhanced
set label 3 note at screen 0.985, screen 0.02 right font ',10' tc rgb '#666666' noenhanced
names = "'7-joint arm, step 4 ms' '7-joint arm, step 1 ms' '8 thin rods, step 2 ms'"
ends = '10 10 5'
set logscale y; set yrange [1e-16:1e4]
set ytics ("10^{-15}" 1e-15, "10^{-10}" 1e-10, "10^{-5}" 1e-5, "1" 1) font ',11'; unset mytics
set grid xtics ytics lc rgb '#e4e4e4' lt 1 lw 0.6
set border 2 lc rgb '#888888'; set tics nomirror scale 0.4
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
unset key
do for [p=1:3] {
    set origin 0.065 + 0.31 * (p - 1), 0.15
    set size 0.295, 0.66
    end = word(ends, p) + 0
    set xrange [0:end * 1.75]; set xtics 0, end / 5, end font ',11'
    set label 5 'simulated time (s)' at end / 2.0, graph -0.13 center font ',12'
    set label 4 word(names, p) at graph 0.02, graph 1.045 left font ',12' noenhanced
    plot data using ($1 == p - 1 && $2 == 1 ? $3 : NaN):4:5 with lines lw 6 lc rgb variable, \
         data using ($1 == p - 1 && $2 == 0 ? $3 : NaN):4:5 with lines lw 1.8 lc rgb variable, \
         labels using ($1 == p - 1 ? end * 1.03 : NaN):2:4:3 with labels left font ',12' tc rgb variable noenhanced
    unset label 1; unset label 2; unset label 3; unset label 4; unset label 5
}
unset multiplot
