# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: work (files of singular.sh), output, note.
set terminal svg size 800,420 font 'sans,14' background '#ffffff'
set output output
set logscale xy
set format x '10^{%L}'
set format y '10^{%L}'
set xrange [1e-8:0.5]
set yrange [5:1e9]
set grid lc rgb '#dddddd' lt 1 lw 1
set tics scale 0.5 nomirror; set border 3 lc rgb '#888888'
set tmargin 5; set bmargin 5; set rmargin 4
set label 1 'Damped torques stay flat through singularities, where the pseudoinverse explodes' \
    at screen 0.5, screen 0.95 center font ',17' noenhanced
set label 2 'Largest joint torque of one task (1 m/s², 1 rad/s²) on arm6, N m' \
    at screen 0.5, screen 0.88 center font ',14' tc rgb '#555555' noenhanced
set label 3 note at screen 0.99, screen 0.02 right font ',10' tc rgb '#888888' noenhanced
set xlabel 'distance from the singularity, rad'
set label 10 'truncate' at graph 0.08, graph 0.86 tc rgb '#CC3311' noenhanced
set label 11 'default: damp' at graph 0.08, graph 0.2 tc rgb '#1B9E77' noenhanced
set key at graph 0.99, graph 0.97 right noenhanced
plot work.'/wrist.truncate' with lines lw 2 lc rgb '#CC3311' title 'wrist', \
     work.'/elbow.truncate' with lines lw 2 dt 2 lc rgb '#CC3311' title 'elbow', \
     work.'/shoulder.truncate' with lines lw 2 dt 3 lc rgb '#CC3311' title 'shoulder', \
     work.'/wrist.default' with lines lw 2 lc rgb '#1B9E77' notitle, \
     work.'/elbow.default' with lines lw 2 dt 2 lc rgb '#1B9E77' notitle, \
     work.'/shoulder.default' with lines lw 2 dt 3 lc rgb '#1B9E77' notitle
