# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: atlas (atlas.csv of `totalforce atlas`), bodies, output. One panel for each map: the error of
# methods alone, of the default request, and the floor of the data, at one number of bodies.
set terminal pngcairo size 1200,760 font 'sans,10' background '#ffffff'
set output output
set datafile missing '-'
set logscale xy
set format x '10^{%L}'
set format y '10^{%L}'
set yrange [1e-16:1e4]
set ytics 1e4
set grid lc '#dddddd'
set tics scale 0.5
set multiplot layout 2,3 title sprintf('Relative error of qdd, chains of %d bodies', bodies) font ',14' \
    margins 0.06,0.98,0.08,0.92 spacing 0.055,0.12

# value and error of the rows of a map, a method and a mode; of `service` the largest of all methods
rows(map, method, mode, column) = sprintf("< awk -F, '$1 == \"%s\" && $3 == %d && $6 == \"%s\" && " \
    ."(\"%s\" == \"all\" || $5 == \"%s\") { if (!($2 in n)) { order[++k] = $2; n[$2] = 1; e[$2] = \"-\" } " \
    ."if ($%d != \"\" && (e[$2] == \"-\" || $%d + 0 > e[$2] + 0)) e[$2] = $%d } " \
    ."END { for (i = 1; i <= k; i++) print order[i], e[order[i]] }' %s", \
    map, bodies, mode, method, method, column, column, column, atlas)

array map[5] = ['ratio', 'heavy-tip', 'light-heavy', 'thin', 'taper']
array what[5] = ['mass ratio of neighbours', 'mass of the tip / mass of a body', \
    'mass ratio of the halves', 'radius of the rods / length', 'mass of the tip / mass of the root']
# the key takes the place of the sixth panel
set key at screen 0.97,0.42 top right vertical maxrows 8 font ',12' spacing 1.5
do for [k = 1:5] {
    set xlabel what[k] offset 0,0.5
    if (k >= 4) { set xrange [*:*] reverse } else { set xrange [*:*] noreverse }
    if (k == 2) { unset key }
    plot rows(map[k], 'tfa', 'plain', 14) with linespoints lc '#08306B' pt 8 title 'tfa alone', \
         rows(map[k], 'cfa', 'plain', 14) with linespoints lc '#56B4E9' pt 4 title 'cfa alone', \
         rows(map[k], 'dca', 'plain', 14) with linespoints lc '#762A83' pt 12 title 'dca alone', \
         rows(map[k], 'hessenberg', 'plain', 14) with linespoints lc '#E69F00' pt 10 title 'hessenberg alone', \
         rows(map[k], 'crba', 'plain', 14) with linespoints lc '#00441B' pt 6 title 'crba alone', \
         rows(map[k], 'aba', 'plain', 14) with linespoints lc '#66C2A4' pt 2 title 'aba alone', \
         rows(map[k], 'all', 'service', 14) with lines lw 3 lc '#CC3311' title 'default request, worst method', \
         rows(map[k], 'aba', 'plain', 19) with lines dt 2 lw 2 lc '#000000' title 'floor of the data'
}
unset multiplot
