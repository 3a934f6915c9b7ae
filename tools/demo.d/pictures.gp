# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The demonstration's motions: gnuplot -e "folder='build/demo'" pictures.gp
#
# Colours are Okabe and Ito's, dashes differ too, so that they can be told apart in grey.

set style line 1 lc rgb '#0072B2' lw 2 dt 1
set style line 2 lc rgb '#D55E00' lw 2 dt 2
set style line 3 lc rgb '#009E73' lw 2 dt 3
set style line 4 lc rgb '#CC79A7' lw 2 dt 4
set style line 5 lc rgb '#000000' lw 2 dt 5
set style line 6 lc rgb '#E69F00' lw 2 dt 1
set style line 7 lc rgb '#56B4E9' lw 2 dt 2

do for [kind in "svg png"] {
    if (kind eq "svg") {
        set terminal svg size 900,560 font 'sans,13' background rgb 'white'
    } else {
        set terminal pngcairo size 900,560 font 'sans,11'
    }

    # --- joint angles
    set output sprintf('%s/arm_joints.%s', folder, kind)
    set title "Joint angles of the arm, driven by torques at 1 kHz"
    set xlabel 'time (s)'; set ylabel 'joint angle (rad)'
    set key outside right; set grid
    plot for [j=1:7] sprintf('%s/arm_motion.dat', folder) using 1:(column(3+j)) \
        with lines ls j title sprintf('joint %d', j)

    # --- stick figures, from the side and from the front
    do for [robot in "arm humanoid"] {
        set output sprintf('%s/%s_motion.%s', folder, robot, kind)
        figures = sprintf('%s/%s_figures.dat', folder, robot)
        last = robot eq "arm" ? 59 : 29
        grey(k) = int(210 - 150.0 * k / last) * 65793
        unset key
        set multiplot layout 1,2 \
            title "Motion of the ".robot.": a figure every 0.5 s, later ones darker, the last one blue"
        set size ratio -1; unset title
        set ylabel 'z (m)'; set xtics 0.2
        if (robot eq "arm") { set yrange [-0.05:1.25]; set xrange [-0.65:0.65] }
        do for [view in "1 2"] {
            set xlabel view eq "1" ? 'x (m), seen from the side' : 'y (m), seen from the front'
            column_x = int(view)
            plot for [k=0:last-1:5] figures index k using column_x:3 with lines lw 2 lc rgb grey(k), \
                 figures index last using column_x:3 with linespoints lw 3 pt 7 ps 0.5 lc rgb '#0072B2'
        }
        unset multiplot
        set size noratio; set autoscale; set key; set xtics autofreq
    }
}
