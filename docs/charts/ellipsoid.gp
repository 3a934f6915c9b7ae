# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The arm in three postures with the ellipsoid of Lambda^-1 at its tool.
# Given: data, the output of demo_ellipsoid for three postures; scale, m for 1/kg; view, its words; output.
set terminal svg size 830,350 font 'sans,13' background rgb 'white'
set output output
mass(k, which) = real(system(sprintf("awk '/^# mass/ && ++n == %d { print $%d }' %s", k, which + 2, data)))
set multiplot
set label 1 sprintf("Pushed at its tool, the reaching arm weighs %.1f kg one way and %.0f kg another", mass(3, 1), mass(3, 2)) \
    at screen 0.5, screen 0.95 center font ',16' noenhanced
set label 2 "Λ⁻¹, linear block: acceleration of the tool by a force of 1 N in every direction; mass along an axis: 1 / half axis" \
    at screen 0.5, screen 0.885 center font ',11' tc rgb '#555555' noenhanced
set label 3 view at screen 0.985, screen 0.022 right font ',10' tc rgb '#666666' noenhanced
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
set size ratio -1
set xrange [-0.3:0.95]; set yrange [-0.22:0.8]
unset border; unset tics; unset key
names = "folded bent reaching"
do for [k=1:3] {
    set origin 0.02 + 0.325 * (k - 1), 0.06
    set size 0.31, 0.8
    set label 4 sprintf("%s: %.1f to %.1f kg", word(names, k), mass(k, 1), mass(k, 2)) at graph 0.5, graph 0.02 center font ',13' noenhanced
    plot data index 3 * (k - 1) using 1:2 with linespoints pt 7 ps 0.7 lw 5 lc rgb '#555555', \
         data index 3 * (k - 1) + 1 using 1:2 with filledcurves closed fc rgb '#56B4E9' fs transparent solid 0.35, \
         data index 3 * (k - 1) + 1 using 1:2 with lines lw 1.5 lc rgb '#0B3C8C', \
         data index 3 * (k - 1) + 2 using 1:2 with lines lw 1 lc rgb '#D55E00'
    unset label 1; unset label 2; unset label 3; unset label 4
}
unset multiplot
