# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: folder. One state of forward dynamics, robot by robot: the library and its peers.
set terminal svg size 900,480 font 'sans,13' background '#ffffff'
set output folder.'/robots.svg'
set datafile missing '-'
set style data histograms
set style histogram clustered gap 1
set style fill solid 0.9 noborder
set logscale y
set ylabel 'ns a joint'
set ytics (20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1000)
set yrange [15:1000]
set grid ytics lc '#dddddd'
set xtics rotate by -35 nomirror noenhanced
set key top right
set title 'Forward dynamics of one state, fixed base'
table = "< awk -F, '/^#/ || $1 == \"robot\" { next } $2 == \"fixed\" && $4 == \"fd\" { if (!($1 in seen)) { seen[$1] = 1; name[++n] = $1 } x[$1, $5] = $14 } END { for (k = 1; k <= n; k++) { printf \"%s\", name[k]; split(\"now mujoco kdl\", who, \" \"); for (w = 1; w <= 3; w++) printf \" %s\", (name[k], who[w]) in x ? x[name[k], who[w]] : \"-\"; print \"\" } }' ".folder.'/suite.csv'
plot table using 2:xtic(1) title 'totalforce' lc '#00441B', \
     '' using 3 title 'MuJoCo 2.2.2' lc '#E69F00', \
     '' using 4 title 'Orocos KDL 1.5.1' lc '#CC3311'
