# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Draws hold.csv of bench_hold: gnuplot -e "csv='hold.csv'; out='hold'" hold.gp -> hold.svg, hold.png
set datafile separator ','
set logscale xy
set format y '10^{%T}'
set xrange [0.4:60]
set yrange [1e-17:3]
set xtics (0.5, 1, 2, 5, 10, 20, 50)
set grid ytics lc rgb '#dddddd'
set xlabel 'time of one answer / time of exact aba'
mechanisms = "'planar 512' '3-D 512' 'humanoid'"
titles = "'planar chain, 512 bodies' '3-D chain, 512 bodies' 'humanoid, 47 joints, floating'"

do for [device = 1:2] {
    if (device == 1) {
        set terminal svg size 1200,440 font 'DejaVu Sans,12' background 'white'
        set output out.'.svg'
    } else {
        set terminal pngcairo size 1200,440 font 'DejaVu Sans,10'
        set output out.'.png'
    }
    set multiplot layout 1,3
    do for [k = 1:3] {
        m = word(mechanisms, k)
        set title word(titles, k)
        if (k < 3) { unset key } else { # there is room in the third
            set key at graph 0.04, graph 0.52 left top Left reverse samplen 1
        }
        set ylabel (k == 1 ? 'relative error of qdd in the energy norm' : '')
        plot sprintf("< grep '^%s,given' '%s'", m, csv) using 8:10 with linespoints pt 7 ps 0.7 \
                 lc rgb '#0072b2' title 'joints given: true error', \
             '' using 8:11 with points pt 4 ps 1.1 lc rgb '#222222' title 'certificate', \
             '' using 9:11 with points pt 1 ps 0.8 lc rgb '#999999' \
                 title 'the same, its time included', \
             sprintf("< grep '^%s,auto' '%s'", m, csv) using 8:10 with points pt 9 ps 1.1 \
                 lc rgb '#d55e00' title 'auto: true error', \
             sprintf("< grep '^%s,aba' '%s'", m, csv) using 8:10 with points pt 3 ps 1.5 \
                 lc rgb '#009e73' title 'exact aba (rounding)'
    }
    unset multiplot
}
