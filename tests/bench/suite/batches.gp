# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: folder. Forward dynamics of batches: time of a state for each joint.
set terminal svg size 900,480 font 'sans,13' background '#ffffff'
set output folder.'/batches.svg'
set datafile missing '-'
set style data histograms
set style histogram clustered gap 1
set style fill solid 0.9 noborder
set logscale y
set ylabel 'ns a joint and state'
set ytics (2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100)
set yrange [2:150]
set grid ytics lc '#dddddd'
set xtics rotate by -35 nomirror noenhanced
set key outside bottom center horizontal
set title 'Forward dynamics of 512 states'
table = "< awk -F, '/^#/ || $1 == \"robot\" || $5 != \"now\" { next } { key = $2 == \"floating\" ? $1 \"-floating\" : $1 } $4 == \"batch-f64\" && !(key in seen) { seen[key] = 1; name[++n] = key } { x[key, $4] = $14 } END { for (k = 1; k <= n; k++) { printf \"%s\", name[k]; split(\"fd batch-f64 batch-f64-2 batch-f32 batch-f32-2\", task, \" \"); for (t = 1; t <= 5; t++) printf \" %s\", (name[k], task[t]) in x ? x[name[k], task[t]] : \"-\"; print \"\" } }' ".folder.'/suite.csv'
plot table using 2:xtic(1) title 'one state' lc '#999999', \
     '' using 3 title 'double' lc '#08306B', \
     '' using 4 title '2 threads' lc '#56B4E9', \
     '' using 5 title 'float' lc '#00441B', \
     '' using 6 title '2 threads' lc '#66C2A4'
