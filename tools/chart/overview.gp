# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# All mechanisms and sizes at a glance: a line of small panels for each mechanism, a column for each
# size, one right-hand side. Given: $data, $words, $sentences, lines, columns, line_name, column_name,
# what chart_set_times sets, lambda, rhs_name, time_name, how, suffix (chart_name_how), and style.gp.

head_px = 104
panel_px = 150
left_px = 160
right_px = 170
step_px = 17
foot_px = 70 + step_px * (|$words| + |$sentences|)
wide_px = left_px + 290 * columns + right_px
wide_px = wide_px < 1180 ? 1180 : wide_px
high_px = head_px + panel_px * lines + foot_px
cell_px = (wide_px - left_px - right_px) * 1.0 / columns

do for [kind in "svg png"] {
    if (kind eq "svg") {
        set terminal svg size wide_px,high_px font 'sans,12' background rgb 'white'
    } else {
        set terminal pngcairo size wide_px,high_px font 'sans,10'
    }
    set output sprintf('%s/overview%s.%s', folder, suffix, kind)
    set multiplot
    set label 1 "Accuracy against speed".(lambda ? "" : ": ".rhs_name).how at screen 0.5, screen 1 - 25.0/high_px center font ',16' noenhanced
    set label 2 "up: relative error of ".(lambda ? "Λ⁻¹ (Frobenius norm)" : "qdd (2-norm)")."; right: ".time_name."\nhollow: as solved, filled: refined; bars: least and largest over the seeds; dashed: floor of the data" \
        at screen 0.5, screen 1 - 46.0/high_px center font ',11' noenhanced
    set logscale xy
    set yrange [1e-17:1e2]; set ytics 1e-16, 1e4, 1e2 font ',9'; unset mytics
    set grid xtics ytics lc rgb '#dddddd' lt 1 lw 0.5
    unset key
    set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
    do for [l=0:lines-1] {
        do for [c=0:columns-1] {
            set origin (left_px + cell_px * c + 4) / wide_px, (foot_px + panel_px * (lines - 1 - l) + 6.0) / high_px
            set size (cell_px - 10) / wide_px, (panel_px - 12.0) / high_px
            set xrange [low_time[c+1]:high_time[c+1]]
            set format y (c == 0 ? '10^{%L}' : '')
            set format x (l == lines - 1 ? time_format[c+1] : ''); set xtics font ',9'
            eval('set xtics '.time_tics[c+1])
            if (c == 0) { set label 3 line_name[l+1] at screen (left_px - 50.0)/wide_px, graph 0.5 right noenhanced }
            if (l == 0) { set label 4 column_name[c+1] at graph 0.5, graph 1.12 center noenhanced }
            # the first: so that a panel without answers is a panel all the same
            plot 1e-17 with dots lc rgb '#ffffff', \
                 $data using ($1==l && $2==c ? $5 : NaN):7 smooth unique with lines lc rgb '#777777' lw 1.2 dt 2, \
                 for [m in order] $data using ($1==l && $2==c && $3==m+0 ? $5 : NaN):6:9:10 \
                     with yerrorbars pt 0 lw 0.7 lc rgb colour[m+0], \
                 for [m in order] $data using ($1==l && $2==c && $3==m+0 && $4==0 ? $5 : NaN):6 \
                     with points pt shape[m+0] ps 0.75 lw 1.5 lc rgb colour[m+0], \
                 for [m in order] $data using ($1==l && $2==c && $3==m+0 && $4>0 ? $5 : NaN):6 \
                     with points pt shape[m+0]+1 ps 0.75 lc rgb colour[m+0]
            unset label 1; unset label 2; unset label 3; unset label 4
        }
    }

    # the key, and what follows
    unset logscale; unset grid; unset border; unset tics
    set xrange [0:1]; set yrange [0:1]
    set origin (wide_px - right_px + 10.0) / wide_px, 0
    set size (right_px - 10.0) / wide_px, 1 - head_px * 1.0 / high_px
    set key at graph 0.0, 1.0 left top Left reverse samplen 2 spacing 1.4 noenhanced
    y(k) = (foot_px - 40.0 - step_px * k) / high_px
    do for [i=1:|$sentences|] {
        set label 4+i $sentences[i] at screen 20.0/wide_px, screen y(i-1) left noenhanced font ',11'
    }
    do for [i=1:|$words|] {
        set label 20+i $words[i] at screen 20.0/wide_px, screen y(|$sentences| + i - 0.5) left noenhanced font 'monospace,9'
    }
    plot for [m in order] NaN with points pt shape[m+0] ps 1.1 lw 2 lc rgb colour[m+0] title label[m+0], \
         NaN with points pt 7 ps 1.1 lc rgb 'black' title 'filled: refined', \
         NaN with lines lc rgb '#777777' lw 1.2 dt 2 title 'floor of the data'
    unset multiplot
    unset output
    unset label
    reset
}
