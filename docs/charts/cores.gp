# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Speed-up by a second thread, and time of an answer over the number of bodies: random chains, method
# auto, one state a request, request after request, and batches.
# Given: chart, a chart.csv with --threads 1,2 --strategies single,batch; output; note. The title holds the
# median speed-up of batches and the greatest of single states.
set terminal svg size 830,430 font 'sans,13' background rgb 'white'
set output output
set multiplot
# median or greatest of the speed-ups of a strategy
speedup(strategy, which) = real(system(sprintf("awk -F, '/^#/ { next } !head { for (i = 1; i <= NF; i++) c[$i] = i; head = 1; next } " \
    ."$c[\"strategy\"] == \"%s\" { t[$c[\"bodies\"], $c[\"threads\"]] = $c[\"time_us\"]; n[$c[\"bodies\"]] = 1 } " \
    ."END { for (b in n) print t[b, 1] / t[b, 2] }' %s | sort -g | awk '{ v[NR] = $1 } END { print v[%s] }'", strategy, chart, which)))
median = "int((NR + 1) / 2)"
best = speedup("single", "NR")
set label 1 sprintf("A second core makes batches %.1f times as fast, single answers %s", speedup("batch", median), \
    best < 1.1 ? "no faster" : sprintf("of long chains up to %.1f times", best)) at screen 0.5, screen 0.955 center font ',16' noenhanced
set label 2 "Forward dynamics of chains by the default method; a batch: 512 states, 64 above 128 bodies; request after request" \
    at screen 0.5, screen 0.9 center font ',12' tc rgb '#555555' noenhanced
set label 3 note at screen 0.985, screen 0.022 right font ',10' tc rgb '#666666' noenhanced
# bodies, time with one thread, with two; of a strategy
times(strategy) = sprintf("< awk -F, '/^#/ { next } !head { for (i = 1; i <= NF; i++) c[$i] = i; head = 1; next } " \
    ."$c[\"strategy\"] == \"%s\" && $c[\"status\"] == \"ok\" { t[$c[\"bodies\"], $c[\"threads\"]] = $c[\"time_us\"]; if (!($c[\"bodies\"] in n)) { n[$c[\"bodies\"]] = 1; order[++k] = $c[\"bodies\"] } } " \
    ."END { for (i = 1; i <= k; i++) print order[i], t[order[i], 1], t[order[i], 2] }' %s", strategy, chart)
set logscale x
set xrange [6:6000]
set xtics ("8" 8, "32" 32, "128" 128, "512" 512, "2048" 2048) font ',11'; unset mxtics
set xlabel 'bodies of the chain' offset 0,0.4
set grid xtics ytics lc rgb '#e4e4e4' lt 1 lw 0.6
set border 3 lc rgb '#888888'; set tics nomirror scale 0.4
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
set key top left samplen 1.8 spacing 1.15 font ',12' noenhanced Left reverse
set origin 0.06, 0.17; set size 0.4, 0.64
set yrange [0:2.8]; set ytics 0.5 font ',11'
set label 4 'times as fast with a second thread' at graph 0, graph 1.05 left font ',12' noenhanced
plot 1 with lines dt 2 lc rgb '#999999' notitle, \
     times('batch') using 1:($2/$3) with linespoints pt 7 ps 0.6 lw 2 lc rgb '#0B3C8C' title 'batch', \
     times('single') using 1:($2/$3) with linespoints pt 6 ps 0.8 lw 2 lc rgb '#D55E00' title 'one state a call'
unset label 1; unset label 2; unset label 3
set origin 0.55, 0.17; set size 0.4, 0.64
set logscale y
set yrange [5:500]; set ytics (5, 10, 20, 50, 100, 200) font ',11'
set label 4 'ns of an answer for each body' at graph 0, graph 1.05 left font ',12' noenhanced
set key top right Right noreverse
plot times('single') using 1:(1e3*$2/$1) with linespoints pt 6 ps 0.8 lw 2 lc rgb '#D55E00' title 'one state, 1 thread', \
     times('single') using 1:(1e3*$3/$1) with linespoints pt 6 ps 0.8 lw 2 dt 2 lc rgb '#D55E00' title 'one state, 2 threads', \
     times('batch') using 1:(1e3*$2/$1) with linespoints pt 7 ps 0.6 lw 2 lc rgb '#0B3C8C' title 'batch, 1 thread', \
     times('batch') using 1:(1e3*$3/$1) with linespoints pt 7 ps 0.6 lw 2 dt 2 lc rgb '#0B3C8C' title 'batch, 2 threads'
unset multiplot
