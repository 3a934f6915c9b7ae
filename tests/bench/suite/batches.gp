# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: folder. Forward dynamics of batches: time of a state for each joint.
set terminal svg size 830,480 font 'sans,13' background '#ffffff'
set output folder.'/batches.svg'
set datafile missing '-'
set logscale y # marks and not bars: a logarithmic axis has no zero
set ylabel 'ns a joint and state'
set ytics (2, 5, 10, 20, 50, 100) nomirror tc rgb '#333333'
set yrange [2:150]
set xrange [0.5:*]
set grid xtics ytics lc '#e4e4e4' lt 1 lw 0.6
set border 3 lc '#888888'
set xtics rotate by -40 nomirror noenhanced font ',11' tc rgb '#333333'
set key outside top center horizontal
set title 'Forward dynamics of 512 states'
table = "< awk -F, '/^#/ || $1 == \"robot\" || $5 != \"now\" { next } { key = $2 == \"floating\" ? $1 \"-floating\" : $1 } $4 == \"batch-f64\" && !(key in seen) { seen[key] = 1; name[++n] = key } { x[key, $4] = $14 } END { for (k = 1; k <= n; k++) { printf \"%s\", name[k]; split(\"fd batch-f64 batch-f64-2 batch-f32 batch-f32-2\", task, \" \"); for (t = 1; t <= 5; t++) printf \" %s\", (name[k], task[t]) in x ? x[name[k], task[t]] : \"-\"; print \"\" } }' ".folder.'/suite.csv'
plot table using ($0 + 1):2:xtic(1) with points pt 5 ps 0.7 lc '#888888' title 'one state', \
     '' using ($0 + 1):3 with points pt 7 ps 0.8 lc '#08306B' title 'double', \
     '' using ($0 + 1):4 with points pt 6 ps 0.8 lw 1.5 lc '#56B4E9' title '2 threads', \
     '' using ($0 + 1):5 with points pt 9 ps 0.9 lc '#00441B' title 'float', \
     '' using ($0 + 1):6 with points pt 8 ps 0.9 lw 1.5 lc '#3FAE86' title '2 threads'
