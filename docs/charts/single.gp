# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Error against time of aba in double, single and mixed precision: four robots.
# Given: chart, a chart.csv with --precision f64,f32,f32+f64 --strategies single,batch; output; note.
set terminal svg size 830,520 font 'sans,13' background rgb 'white'
set output output
set multiplot
set label 1 "Single precision saves a third of a batch's time and costs nine digits" \
    at screen 0.5, screen 0.96 center font ',17' noenhanced
set label 2 "Forward dynamics by aba: relative error against time of one answer; mixed: float, refined once in double" \
    at screen 0.5, screen 0.915 center font ',12' tc rgb '#555555' noenhanced
set label 3 note at screen 0.985, screen 0.02 right font ',10' tc rgb '#666666' noenhanced
robots = 'arm7,7 humanoid,47 random,32 random,128'
names = "'7-joint arm' '47-joint humanoid' 'chain of 32' 'chain of 128'"
# time, error; robot is "NAME,BODIES"
point(robot, precision, refine, strategy) = sprintf("< awk -F, '/^#/ { next } !head { for (i = 1; i <= NF; i++) c[$i] = i; head = 1; next } " \
    ."$c[\"mechanism\"] \",\" $c[\"bodies\"] == \"%s\" && $c[\"precision\"] == \"%s\" && $c[\"refine\"] == %d && $c[\"strategy\"] == \"%s\" && $c[\"status\"] == \"ok\" " \
    ."{ print $c[\"time_us\"], $c[\"error\"] }' %s", robot, precision, refine, strategy, chart)
set logscale xy
set yrange [1e-17:1e3]
set ytics ("10^{-15}" 1e-15, "10^{-10}" 1e-10, "10^{-5}" 1e-5, "1" 1) font ',11'; unset mytics
set xrange [0.03:100]
set xtics ("0.05" 0.05, "0.1" 0.1, "0.2" 0.2, "0.5" 0.5, "1 µs" 1, "2" 2, "5" 5, "10 µs" 10, "20" 20, "50" 50) font ',11'
set grid xtics ytics lc rgb '#e4e4e4' lt 1 lw 0.6
set border 3 lc rgb '#888888'; set tics nomirror scale 0.4
set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
unset key
precisions = 'f64 f64 f32 f32 f32+f64'
refines = '0 0 0 0 1'
strategies = 'batch single batch single single'
texts = "'double, batch' 'double, call' 'single, batch' 'single, call' 'mixed, call'"
colours = '#0B3C8C #0B3C8C #D55E00 #D55E00 #7B3294'
do for [p=1:4] {
    set origin 0.07 + 0.48 * ((p - 1) % 2), (p <= 2 ? 0.52 : 0.11)
    set size 0.44, 0.345
    set label 4 word(names, p) at graph 0.02, graph 0.93 left font ',13' noenhanced
    plot for [k=1:5] point(word(robots, p), word(precisions, k), word(refines, k) + 0, word(strategies, k)) using 1:2 \
             with points pt (word(strategies, k) eq 'batch' ? 7 : 6) ps 0.9 lw 1.6 lc rgb word(colours, k), \
         for [k=1:5] point(word(robots, p), word(precisions, k), word(refines, k) + 0, word(strategies, k)) using 1:2:(word(texts, k)) \
             with labels center offset 0,(k == 1 ? -0.9 : 0.9) font ',11' tc rgb word(colours, k) noenhanced
    unset label 1; unset label 2; unset label 3
}
unset multiplot
