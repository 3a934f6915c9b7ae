# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# The demonstration's pictures. gnuplot -e "folder='build/demo'" pictures.gp
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

    # --- stick figures
    set output sprintf('%s/arm_motion.%s', folder, kind)
    set title "Motion of the arm: a figure every 0.5 s, the last one dark"
    set xlabel 'x (m)' offset 0,-1; set ylabel 'y (m)' offset -1,0; set zlabel 'z (m)' rotate parallel
    unset key; set view 65,40; set xyplane at 0; set view equal xyz
    last = 59
    splot for [k=0:last:5] sprintf('%s/arm_figures.dat', folder) index k using 1:2:3 \
              with lines lw 2 lc rgb int(200 - 170.0 * k / last) * 65793 notitle, \
          sprintf('%s/arm_figures.dat', folder) index last using 1:2:3 \
              with linespoints lw 4 pt 7 ps 0.6 lc rgb '#0072B2' notitle
    unset view; set key; unset zlabel

    # --- latency
    set output sprintf('%s/latency.%s', folder, kind)
    set title "Round trip of a 7-joint forward dynamics request: share of requests that took longer"
    set xlabel 'round trip (us)' offset 0,0; set ylabel 'share that took longer' offset 0,0
    set logscale xy; set key top right; set grid
    set format y '10^{%L}'
    set yrange [1e-5:1]
    plot sprintf('%s/shm.hgrm', folder) using 1:($2 < 1 ? 1 - $2 : NaN) with lines ls 1 \
             title 'shared memory (spin)', \
         sprintf('%s/dds.hgrm', folder) using 1:($2 < 1 ? 1 - $2 : NaN) with lines ls 2 title 'DDS'
    unset logscale; set autoscale; set format y
}
