# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Energy error over simulated time: a panel for each step, a line for each method and precision.
# Given: subject, $data (a block for each line), count, panels, low, high, seconds, step, panel_of, mark,
# precision, place, name (of each line).
charted = ''
load scripts.'/../chart/style.gp'
dash(k) = precision[k] == 1 ? 2 : precision[k] == 2 ? 4 : precision[k] == 3 ? 3 : 1 # f32, f32+f64, f64+f128
wide_px = 100 + 430 * panels
high_px = 470
do for [kind in "svg png"] {
    if (kind eq "svg") {
        set terminal svg size wide_px,high_px font 'sans,12' background rgb 'white'
    } else {
        set terminal pngcairo size wide_px,high_px font 'sans,10'
    }
    set output sprintf('%s/drift.%s', folder, kind)
    set multiplot
    set label 1 subject at screen 0.5, screen 0.95 center font ',14' noenhanced
    set logscale y; set format y '10^{%L}'; set yrange [low:high]; set xrange [0:seconds]
    set ytics 1e-20,(high/low > 1e9 ? 100 : 10); unset mytics
    set grid xtics ytics lc rgb '#dddddd' lt 1 lw 0.5
    set border 3 lc rgb '#888888'; set tics nomirror scale 0.4
    set xlabel 'simulated time (s)'
    set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
    unset key
    do for [p=1:panels] {
        set origin (75.0 + 430 * (p - 1)) / wide_px, 0.13
        set size 270.0 / wide_px, 0.72
        if (p == 1) { set ylabel 'largest energy error so far, relative' } else { unset ylabel }
        set label 2 sprintf('step %g s', step[p]) at graph 0.03, graph 0.95 left noenhanced
        do for [k=1:count] {
            if (panel_of[k] == p) {
                set label 10+k name[k] at graph 1.02, graph place[k] left noenhanced \
                    tc rgb (precision[k] == 4 ? '#777777' : colour[mark[k]]) font ',11'
            }
        }
        plot low with dots lc rgb '#ffffff', \
             for [k=1:count] $data index (k - 1) using 1:(panel_of[k] == p ? $2 : NaN) with lines \
                 lw (precision[k] == 4 ? 5 : 1.8) dt dash(k) \
                 lc rgb (precision[k] == 4 ? '#bbbbbb' : colour[mark[k]])
        unset label
    }
    unset multiplot
    unset output
    reset
}
