# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: atlas (atlas.csv of `totalforce atlas`), bodies, output. Five columns, one for each map: the
# error of methods alone, of the default request, and the floor of the data, at one number of bodies.
# Twice the size at which the page shows it.
set terminal pngcairo size 1660,940 font 'sans,18' background '#ffffff'
set output output
set datafile missing '-'
set logscale xy
set format x '10^{%L}'
set yrange [1e-16:1e4]
set ytics 1e-16,1e4 tc rgb '#333333'; set mytics 1
set grid lc rgb '#dddddd' lt 1 lw 1
set tics scale 0.5 nomirror; set border 3 lc rgb '#888888'
set multiplot
set label 1 'Ill-conditioned chains: tfa, cfa and dca lose every digit, a default request stays near the floor or is refused' \
    at screen 0.5, screen 0.96 center font ',23' noenhanced
set label 2 sprintf('Relative error of forward dynamics against quadruple precision, chains of %d bodies', bodies) \
    at screen 0.5, screen 0.91 center font ',18' tc rgb '#555555' noenhanced

# value and error of the rows of a map, a method and a mode; of `service` the largest of all methods
rows(map, method, mode, column) = sprintf("< awk -F, '$1 == \"%s\" && $3 == %d && $6 == \"%s\" && " \
    ."(\"%s\" == \"all\" || $5 == \"%s\") { if (!($2 in n)) { order[++k] = $2; n[$2] = 1; e[$2] = \"-\" } " \
    ."if ($%d != \"\" && (e[$2] == \"-\" || $%d + 0 > e[$2] + 0)) e[$2] = $%d } " \
    ."END { for (i = 1; i <= k; i++) print order[i], e[order[i]] }' %s", \
    map, bodies, mode, method, method, column, column, column, atlas)

array map[5] = ['ratio', 'heavy-tip', 'light-heavy', 'thin', 'taper']
array what[5] = ["mass ratio\nof neighbours", "mass of the tip /\nmass of a body", \
    "mass ratio\nof the halves", "radius of the\nrods / length", "mass of the tip /\nmass of the root"]
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
do for [k = 1:5] {
    set origin 0.062 + 0.188 * (k - 1), 0.27
    set size 0.17, 0.58
    set xlabel what[k] offset 0,0.4
    set format y (k == 1 ? '10^{%L}' : '')
    if (k >= 4) { set xrange [*:*] reverse } else { set xrange [*:*] noreverse }
    set mxtics 1
    if (k < 4) { set xtics ("1" 1, "10^4" 1e4, "10^8" 1e8, "" 1e12) }
    if (k == 4) { set xtics ("1" 1, "0.01" 1e-2, "10^{-4}" 1e-4, "" 1e-6) }
    if (k == 5) { set xtics ("1" 1, "10^{-4}" 1e-4, "10^{-8}" 1e-8, "" 1e-12) }
    plot rows(map[k], 'tfa', 'plain', 14) with linespoints lw 2 ps 1.5 lc rgb '#08306B' pt 8 notitle, \
         rows(map[k], 'cfa', 'plain', 14) with linespoints lw 2 ps 1.3 lc rgb '#56B4E9' pt 4 notitle, \
         rows(map[k], 'dca', 'plain', 14) with linespoints lw 2 ps 1.5 lc rgb '#762A83' pt 12 notitle, \
         rows(map[k], 'hessenberg', 'plain', 14) with linespoints lw 2 ps 1.5 lc rgb '#E69F00' pt 10 notitle, \
         rows(map[k], 'crba', 'plain', 14) with linespoints lw 2 ps 1.3 lc rgb '#555555' pt 6 notitle, \
         rows(map[k], 'aba', 'plain', 14) with linespoints lw 2 ps 1.5 lc rgb '#1B9E77' pt 2 notitle, \
         rows(map[k], 'all', 'service', 14) with lines lw 5 lc rgb '#CC3311' notitle, \
         rows(map[k], 'aba', 'plain', 19) with lines dt 2 lw 3 lc rgb '#000000' notitle
    unset label 1; unset label 2
}
# the key below all columns
set origin 0.05, 0; set size 0.9, 0.13
unset logscale; unset grid; unset border; unset tics; unset xlabel
set xrange [0:1] noreverse; set yrange [0:1]
set key at graph 0.5, graph 0.5 center center horizontal maxrows 2 Left reverse font ',17' spacing 1.4 samplen 2 noenhanced
plot NaN with linespoints lw 2 ps 1.5 lc rgb '#08306B' pt 8 title 'tfa alone', \
     NaN with linespoints lw 2 ps 1.3 lc rgb '#56B4E9' pt 4 title 'cfa alone', \
     NaN with linespoints lw 2 ps 1.5 lc rgb '#762A83' pt 12 title 'dca alone', \
     NaN with linespoints lw 2 ps 1.5 lc rgb '#E69F00' pt 10 title 'hessenberg alone', \
     NaN with linespoints lw 2 ps 1.3 lc rgb '#555555' pt 6 title 'crba alone', \
     NaN with linespoints lw 2 ps 1.5 lc rgb '#1B9E77' pt 2 title 'aba alone', \
     NaN with lines lw 5 lc rgb '#CC3311' title 'default request, worst method', \
     NaN with lines dt 2 lw 3 lc rgb '#000000' title 'floor of the data'
unset multiplot
