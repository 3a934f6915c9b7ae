# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: folder. One state of forward dynamics, robot by robot: the library and its peers.
set terminal svg size 830,460 font 'sans,13' background '#ffffff'
set output folder.'/robots.svg'
set datafile missing '-'
set logscale y # marks and not bars: a logarithmic axis has no zero
set ylabel 'ns a joint'
set ytics (10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000)
set yrange [10:*]
set xrange [0.5:*]
set grid xtics ytics lc '#e4e4e4' lt 1 lw 0.6
set border 3 lc '#888888'
set xtics rotate by -35 nomirror noenhanced font ',11' tc rgb '#333333'
set ytics nomirror tc rgb '#333333'
set key outside top center horizontal
set title 'Forward dynamics of one state, fixed base'
table = "< awk -F, '/^#/ || $1 == \"robot\" { next } $2 == \"fixed\" && $4 == \"fd\" { if (!($1 in seen)) { seen[$1] = 1; name[++n] = $1 } x[$1, $5] = $14 } END { for (k = 1; k <= n; k++) { printf \"%s\", name[k]; split(\"now mujoco kdl\", who, \" \"); for (w = 1; w <= 3; w++) printf \" %s\", (name[k], who[w]) in x ? x[name[k], who[w]] : \"-\"; print \"\" } }' ".folder.'/suite.csv'
plot table using ($0 + 1):2:xtic(1) with points pt 7 ps 0.9 lc '#00441B' title 'totalforce', \
     '' using ($0 + 1):3 with points pt 13 ps 1.1 lc '#E69F00' title 'MuJoCo 2.2.2', \
     '' using ($0 + 1):4 with points pt 9 ps 1.0 lc '#CC3311' title 'Orocos KDL 1.5.1'
