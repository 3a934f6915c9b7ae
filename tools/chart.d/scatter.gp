# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Accuracy against speed for one mechanism and size: a panel for each right-hand side, and a key.
# Given: $data, low, high, subject, file, folder, has_N, front_N, silent, and style.gp.

do for [kind in "svg png"] {
    if (kind eq "svg") {
        set terminal svg size 1280,560 font 'sans,12' background rgb 'white'
    } else {
        set terminal pngcairo size 1280,560 font 'sans,10'
    }
    set output sprintf('%s/%s.%s', folder, file, kind)
    panels = has_0 + has_1 + has_2
    wide = 0.83 / panels
    set multiplot title sprintf("Accuracy against speed: %s", subject) font ',15' noenhanced
    set logscale xy
    set format x '10^{%L}'; set format y '10^{%L}'
    set yrange [low:high]; set autoscale x; set offsets graph 0.06, graph 0.06, 0, 0
    set ytics 1e-20,(high/low > 1e9 ? 100 : 10); unset mytics
    set grid xtics ytics lc rgb '#dddddd' lt 1 lw 0.5
    set xlabel 'CPU time of a call (µs)' offset 0,0.3
    set tmargin 3; set bmargin 8.5; set lmargin 9; set rmargin 1
    unset key
    at = 0
    do for [r=0:2] {
        if (!value(sprintf('has_%d', r))) { continue }
        set origin at * wide, 0; set size wide, 0.95
        set ylabel (at == 0 ? 'relative error of qdd, 2-norm' : '')
        set title value(sprintf('rhs_%d', r)) noenhanced offset 0,-0.4
        front = value(sprintf('front_%d', r))
        # two lines at most where it is long
        cut = strlen(front) <= 42 ? 0 : strstrt(front[32:*], ', ')
        set label 1 (cut ? 'front: '.front[1:cut+32]."\n           ".front[cut+33:*] : 'front: '.front) \
            at graph 0, screen 0.14 left noenhanced font ',10'
        plot $data using ($1==r ? $4 : NaN):7 smooth unique with lines lc rgb '#888888' lw 1.5 dt 2, \
             $data using ($1==r && $6==1 ? $4 : NaN):5 smooth unique with steps lc rgb '#bbbbbb' lw 5, \
             $data using ($1==r && $6==1 ? $4 : NaN):5 with points pt 7 ps 2.6 lc rgb '#bbbbbb', \
             for [m in order] $data using ($1==r && $2==m+0 && $3==0 ? $4 : NaN):5 \
                 with points pt shape[m+0] ps 1.1 lw 2 lc rgb colour[m+0], \
             for [m in order] $data using ($1==r && $2==m+0 && $3>0 ? $4 : NaN):5 \
                 with points pt shape[m+0]+1 ps 1.1 lc rgb colour[m+0]
        unset label 1
        at = at + 1
    }

    # the key, and what to conclude
    set origin 0.83, 0; set size 0.17, 0.95
    unset logscale; unset grid; unset border; unset tics; unset xlabel; unset ylabel; unset title
    set lmargin 0; set xrange [0:1]; set yrange [0:1]; unset offsets
    set key at graph 0.0, 1.0 left top Left reverse samplen 2 spacing 1.35 noenhanced
    # as many characters as fit in a line, three lines at most
    lost = 'not shown: '.silent
    rest = lost[171:*]
    cut = strlen(lost) > 170 ? 170 + strstrt(rest.' ', ' ') : strlen(lost)
    set label 2 lost[1:cut]."\n".lost[cut+1:*] at screen 0.02, 0.045 left noenhanced font ',10'
    set label 3 "Left is fast, low is exact. Every method off the grey front is slower or less exact than one on it. Below the dashed line the last bit of q, v and tau matters more than the method." \
        at screen 0.02, 0.08 left noenhanced font ',10'
    plot for [m in order] NaN with points pt shape[m+0] ps 1.1 lw 2 lc rgb colour[m+0] title label[m+0], \
         NaN with points pt 7 ps 1.1 lc rgb 'black' title 'filled: refined (+1, +2)', \
         NaN with points pt 7 ps 2.6 lc rgb '#bbbbbb' title 'on the Pareto front', \
         NaN with lines lc rgb '#888888' lw 1.5 dt 2 title 'floor of the data'
    unset multiplot
    unset output
    unset label
    reset
}
