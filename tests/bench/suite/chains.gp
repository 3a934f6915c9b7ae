# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: folder. Chains: time of a body by length and method, on one thread and two.
set terminal svg size 900,520 font 'sans,13' background '#ffffff'
set output folder.'/chains.svg'
set logscale xy
set xlabel 'bodies'
set ylabel 'ns a body'
set xtics (64, 256, 1000, 4096)
set xrange [50:5200]
set grid lc '#dddddd'
set key outside right
set title 'Forward dynamics of one state of a chain'
rows(task, who) = sprintf("< awk -F, '$1 ~ /^chain/ && $2 == \"fixed\" && $4 == \"%s\" && $5 == \"%s\" { print $3, $14 }' %s/suite.csv", task, who, folder)
plot rows('aba', 'now') with linespoints lw 2 pt 6 lc '#000000' title 'aba', \
     rows('scan', 'now') with linespoints lw 2 pt 10 lc '#66C2A4' title 'scan', \
     rows('scan-2', 'now') with linespoints lw 2 pt 11 lc '#00441B' title 'scan, 2 threads', \
     rows('tfa-cr', 'now') with linespoints lw 2 pt 8 lc '#56B4E9' title 'tfa-cr', \
     rows('tfa-cr-2', 'now') with linespoints lw 2 pt 9 lc '#08306B' title 'tfa-cr, 2 threads', \
     rows('tfa-cr+1-2', 'now') with linespoints lw 1 pt 9 lc '#08306B' title '.. refined, estimated', \
     rows('cfa-cr-2', 'now') with linespoints lw 2 pt 12 lc '#F4A582' title 'cfa-cr, 2 threads', \
     rows('fd', 'mujoco') with linespoints lw 1 pt 1 lc '#E69F00' title 'MuJoCo 2.2.2'
