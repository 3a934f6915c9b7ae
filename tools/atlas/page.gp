# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# One map: a column of panels for each method, a line for each mode; in a panel a cell for each size
# (right) and value (up), its colour the log10 of the error. Given: $cells, $marks, $floor, $key,
# $words, page_title, axis, file, rhs_word, method_name, size_name, value_name.

methods = |method_name|
sizes = |size_name|
values = |value_name|

panel_wide = 132; panel_high = 182; gap_x = 12; gap_y = 26
left_px = 100; head_px = 96; right_px = 70
step_px = 19
foot_px = 62 + step_px * |$words|
wide_px = left_px + (panel_wide + gap_x) * (methods + 1) + right_px
wide_px = wide_px < 1500 ? 1500 : wide_px # the sentences
high_px = head_px + (panel_high + gap_y) * 3 + foot_px
array mode_name[3] = ['alone', 'refined once', 'as the service answers']

# margins of the panel in a column and line, from the top left
margins(c, l) = sprintf("set lmargin at screen %f; set rmargin at screen %f; set tmargin at screen %f; set bmargin at screen %f", \
    (left_px + (panel_wide + gap_x) * c) * 1.0 / wide_px, \
    (left_px + (panel_wide + gap_x) * c + panel_wide) * 1.0 / wide_px, \
    1 - (head_px + (panel_high + gap_y) * l) * 1.0 / high_px, \
    1 - (head_px + (panel_high + gap_y) * l + panel_high) * 1.0 / high_px)
# ticks with room for their labels
size_step = int(ceil(sizes / 4.0))
value_step = int(ceil(values / 8.0))

do for [kind in "svg png"] {
    if (kind eq "svg") {
        set terminal svg size wide_px,high_px font 'sans,12' background rgb 'white'
    } else {
        set terminal pngcairo size wide_px,high_px font 'sans,10'
    }
    set output sprintf('%s/%s.%s', folder, file, kind)
    # dark is wrong and light is exact, evenly so in grey: cividis, backwards, two decades a step
    set palette maxcolors 8
    set palette defined (0 '#FEE838', 1 '#E1CC55', 2 '#C3B369', 3 '#A59C74', 4 '#8A8678', \
                         5 '#707173', 6 '#575D6D', 7 '#3B496C', 8 '#123570', 9 '#00224E')
    set cbrange [-16:0]
    set multiplot
    unset key; unset colorbox
    set xrange [-0.5:sizes-0.5]; set yrange [-0.5:values-0.5]
    set tics out scale 0.4 nomirror; set border 15 lc rgb '#888888' lw 0.7
    set label 1 page_title at screen 0.5, screen 1 - 24.0/high_px center font ',16' noenhanced
    set label 2 "relative error of qdd, 2-norm, median over seeds and states; right: moving bodies; up: ".axis."; right-hand side: ".rhs_word \
        at screen 0.5, screen 1 - 50.0/high_px center font ',11' noenhanced
    do for [l=0:2] {
        do for [c=0:methods] {
            if (c == methods && l > 0) { continue }
            eval(margins(c, l))
            set xtics () ; set ytics ()
            if (l == 2 || c == methods) {
                do for [k=0:sizes-1:size_step] { set xtics add (size_name[k+1] k) font ',9' offset 0,0.4 }
            } else {
                do for [k=0:sizes-1:size_step] { set xtics add ('' k) }
            }
            do for [k=0:values-1:value_step] { set ytics add ((c == 0 ? value_name[k+1] : '') k) font ',9' offset 0.4,0 }
            if (l == 0 || c == methods) { set label 3 (c < methods ? method_name[c+1] : 'floor of the data') at graph 0.5, graph 1.06 center noenhanced font ',11' }
            if (c == 0) { set label 4 mode_name[l+1] at screen 22.0/wide_px, graph 0.5 center rotate font ',12' }
            if (l == 2 && c == 0) { set label 6 'moving bodies' at screen (left_px + (panel_wide + gap_x) * methods * 0.5) / wide_px, screen (foot_px - 6.0) / high_px center font ',10' }
            if (c == 0) { set label 5 axis at screen 46.0/wide_px, graph 0.5 center rotate noenhanced font ',8' }
            if (c == methods) {
                plot $floor using 1:2:(0.52):(0.52):3 with boxxyerror fs solid 1 noborder fc palette
            } else {
                # marks of other panels go outside: labels without a single point crash gnuplot 5.4
                plot $cells using ($3==c && $4==l ? $1 : NaN):2:(0.52):(0.52):5 with boxxyerror fs solid 1 noborder fc palette, \
                     $marks using ($3==c && $4==l ? $1 : -9):2:5:($6 > 0 ? 0xffffff : 0x000000) with labels font ',8' tc rgb variable
            }
            unset label 1; unset label 2; unset label 3; unset label 4; unset label 5; unset label 6
        }
    }

    # the colours, the marks, and what follows
    eval(margins(methods, 1))
    unset border; unset tics
    set colorbox user origin screen (left_px + (panel_wide + gap_x) * methods + 6.0) / wide_px, \
        screen 1 - (head_px + (panel_high + gap_y) * 2 - gap_y - 8.0) / high_px \
        size screen 18.0 / wide_px, screen (panel_high - 26.0) / high_px
    set cbtics -16, 2, 0 font ',9' format '10^{%.0f}' scale 0.3
    set label 1 'error' at screen (left_px + (panel_wide + gap_x) * methods + 6.0) / wide_px, graph 1.0 left font ',10'
    do for [i=1:|$key|] {
        set label 10+i $key[i] at screen (left_px + (panel_wide + gap_x) * methods + 6.0) / wide_px, \
            screen 1 - (head_px + (panel_high + gap_y) * 2 + 14.0 + step_px * (i + 1)) / high_px left noenhanced font ',10'
    }
    set label 10 "Who answered:\n(no mark) the method" at screen (left_px + (panel_wide + gap_x) * methods + 6.0) / wide_px, \
        screen 1 - (head_px + (panel_high + gap_y) * 2 + 4.0) / high_px left noenhanced font ',10'
    do for [i=1:|$words|] {
        set label 30+i $words[i] at screen 20.0/wide_px, screen (foot_px - 44.0 - step_px * (i - 1)) / high_px left noenhanced font ',11'
    }
    plot NaN with boxxyerror fc palette
    unset multiplot
    unset output
    unset label; unset colorbox
    reset
}
