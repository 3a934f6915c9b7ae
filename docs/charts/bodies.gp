# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Error against number of bodies, a line for each method: three mechanisms.
# Given: chart, a chart.csv of `totalforce chart` with them, all methods and refine 0; output.
set terminal svg size 830,430 font 'sans,13' background rgb 'white'
set output output
set multiplot
set label 1 "aba and scan stay at the floor of the data; methods that invert body inertias lose digits" \
    at screen 0.5, screen 0.955 center font ',15' noenhanced
set label 2 "Relative error of forward dynamics against the number of bodies of a chain, unrefined; dashed: floor" \
    at screen 0.5, screen 0.905 center font ',12' tc rgb '#555555' noenhanced
set datafile separator ','
set logscale xy
set xrange [6:6000]; set yrange [1e-16:1e2]
set xtics ("8" 8, "32" 32, "128" 128, "1024" 1024, "4096" 4096) font ',11'
set grid xtics ytics lc rgb '#e4e4e4' lt 1 lw 0.6
set border 3 lc rgb '#888888'; set tics nomirror scale 0.4
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
methods = 'tfa hessenberg dca crba mujoco scan aba'
colours = '#08306B #E69F00 #7B3294 #555555 #CC3311 #1B9E77 #000000'
name = "'random' 'thin: radius 0.1 mm' 'taper: tip 0.01 of the root'"
mechanism = 'random thin taper'
row(m, s) = sprintf("< awk -F, '!/^#/ && $1 == \"%s\" && $3 == \"qdd\" && $5 == 0 && $8 == \"ok\" && $4 == \"%s\"' %s", m, s, chart)
floor_of(m) = sprintf("< awk -F, '!/^#/ && $1 == \"%s\" && $3 == \"qdd\" && $5 == 0 && $4 == \"aba\"' %s", m, chart)
do for [p=1:3] {
    set origin 0.07 + 0.31 * (p - 1), 0.09
    set size 0.285, 0.76
    if (p == 1) { set format y '10^{%L}'; set ytics 1e-16, 1e4 font ',11' } else { set format y '' }
    set label 3 word(name, p) at graph 0.03, graph 0.955 left font ',12' noenhanced
    if (p == 1) {
        set key at graph 0.99, graph 0.02 right bottom samplen 1.4 spacing 1.0 font ',11' noenhanced
    } else { unset key }
    plot floor_of(word(mechanism, p)) using 2:13 with lines dt 2 lc rgb '#888888' notitle, \
         for [k=1:words(methods)] row(word(mechanism, p), word(methods, k)) using 2:11 with linespoints pt 7 ps 0.45 lw 1.5 \
             lc rgb word(colours, k) title word(methods, k)
    unset label 1; unset label 2; unset label 3
}
unset multiplot
