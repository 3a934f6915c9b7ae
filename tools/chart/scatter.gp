# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Accuracy against speed for one mechanism and size: a column of panels for each right-hand side, a
# line for each precision, and a key. All panels of a column share front, floor and ranges.
# Given: $data, same, low, high, what chart_set_times sets, subject, file, folder, lambda, has_N, front_N, lines, line_name, time_name,
# silent, and style.gp.

wide_px = 1280
head_px = 66
line_px = 350
foot_px = 190
high_px = head_px + line_px * lines + foot_px
panels = has_0 + has_1 + has_2
left_px = 75
front_px = lines > 1 ? 2 : 5
cell_px = (0.83 * wide_px - left_px + 55) / panels

do for [kind in "svg png"] {
    if (kind eq "svg") {
        set terminal svg size wide_px,high_px font 'sans,12' background rgb 'white'
    } else {
        set terminal pngcairo size wide_px,high_px font 'sans,10'
    }
    set output sprintf('%s/%s.%s', folder, file, kind)
    set multiplot
    set label 1 "Accuracy against speed: ".subject at screen 0.45, screen 1 - 20.0/high_px center font ',15' noenhanced
    set logscale xy
    set format y '10^{%L}'
    set yrange [low:high]
    set ytics 1e-20,(high/low > 1e9 ? 100 : 10); unset mytics
    set grid xtics ytics lc rgb '#dddddd' lt 1 lw 0.5
    set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
    unset key
    at = 0
    do for [r=0:2] {
        if (!value(sprintf('has_%d', r))) { continue }
        set xrange [low_time[r+1]:high_time[r+1]]
        eval('set xtics '.time_tics[r+1])
        do for [l=0:lines-1] {
            set origin (left_px + cell_px * at) / wide_px, (foot_px + line_px * (lines - 1 - l)) * 1.0 / high_px
            set size (cell_px - 70) / wide_px, (line_px - 16.0) / high_px
            set ylabel (at == 0 ? 'relative error of '.answer_name(lambda) : '') offset 0.5,0
            set title (l == 0 ? (lambda ? 'Λ⁻¹ of one link' : value(sprintf('rhs_%d', r))) : '') noenhanced offset 0,-0.4
            set format x (l == lines - 1 ? time_format[r+1] : '')
            set xlabel (l == lines - 1 ? time_name : '') offset 0,0.3
            if (lines > 1) {
                set label 5 line_name[l+1] at graph 0.97, graph 0.94 right noenhanced font ',11' front
            }
            if (l == lines - 1) {
                set label 3 value(sprintf('front_%d', r)) at graph 0, screen (foot_px - 60.0)/high_px left noenhanced font ',10'
            }
            # the first: so that a panel without answers is a panel all the same
            plot low with dots lc rgb '#ffffff', \
                 $data using ($1==r ? $4 : NaN):7 smooth unique with lines lc rgb '#888888' lw 1.5 dt 2, \
                 $data using ($1==r && $6==1 ? $4 : NaN):5 smooth unique with steps lc rgb '#bbbbbb' lw front_px, \
                 $data using ($1==r && $8==l && $6==1 ? $4 : NaN):5 with points pt 7 ps 2.6 lc rgb '#bbbbbb', \
                 for [m in order] $data using ($1==r && $8==l && $2==m+0 ? $4 : NaN):5:11:12:9:10 \
                     with xyerrorbars pt 0 lw 1 lc rgb colour[m+0], \
                 for [m in order] $data using ($1==r && $8==l && $2==m+0 && $3==0 ? $4 : NaN):5 \
                     with points pt shape[m+0] ps 1.1 lw 2 lc rgb colour[m+0], \
                 for [m in order] $data using ($1==r && $8==l && $2==m+0 && $3>0 ? $4 : NaN):5 \
                     with points pt shape[m+0]+1 ps 1.1 lc rgb colour[m+0]
            unset label 1; unset label 3; unset label 5
        }
        at = at + 1
    }

    # the key, and what to conclude
    set origin 0.845, 0; set size 0.155, 1 - head_px * 1.0/high_px
    unset logscale; unset grid; unset border; unset tics; unset xlabel; unset ylabel; unset title
    set xrange [0:1]; set yrange [0:1]
    set key at graph 0.0, 1.0 left top Left reverse samplen 2 spacing 1.35 noenhanced
    set label 2 silent at screen 0.02, screen 28.0/high_px left noenhanced font ',10'
    set label 6 same at screen 0.02, screen 46.0/high_px left noenhanced font ',10'
    set label 4 "Left is fast, low is exact. A mark is the median over the seeds, its bars reach from the least to the largest of them. What is off the grey front is slower or less exact than a mark on it.\nBelow the dashed line the rounding of the inputs matters more than the method." \
        at screen 0.02, screen 78.0/high_px left noenhanced font ',10'
    plot for [m in order] NaN with points pt shape[m+0] ps 1.1 lw 2 lc rgb colour[m+0] title label[m+0], \
         NaN with points pt 7 ps 1.1 lc rgb 'black' title 'filled: refined (+1, +2)', \
         NaN with points pt 7 ps 2.6 lc rgb '#bbbbbb' title 'on the Pareto front', \
         NaN with lines lc rgb '#888888' lw 1.5 dt 2 title 'floor of the data'
    unset multiplot
    unset output
    unset label
    reset
}
