# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Files drift.csv of `totalforce drift` as the lines of drift.gp: panel, floor, time, largest error, colour;
# a panel for each file and step. The labels go into the file `labels`: panel, place, colour, text.
BEGIN {
    FS = ","
    LOW = -16; HIGH = 4 # decades of the axis
    STEP = 0.055 * (HIGH - LOW) # between labels
    colours = "aba f64=0x000000 aba f32=0xD55E00 aba f32+f64=0x009E73 crba f64=0x888888 tfa f64=0x08306B cfa f64=0x8C2D04 dca f64=0x7B3294"
    colours = colours " tfa f32=0x6BAED6 cfa f32=0xE08A5A dca f32=0xB391C4"
    while (match(colours, /[a-z]+ [a-z0-9+]+=0x[0-9A-F]+/)) {
        split(substr(colours, RSTART, RLENGTH), pair, "=")
        colour[pair[1]] = pair[2]
        colours = substr(colours, RSTART + RLENGTH)
    }
}
FNR == 1 { file++ }
/^#/ || $1 == "mechanism" { next }
{
    place = file SUBSEP $4
    if (!(place in panel)) panel[place] = panels++
    floor = $8
    name = floor ? "integrator alone" : $5 " " $6
    series = panel[place] SUBSEP name
    if (series != last) { if (last != "") print ""; order[++count] = series; last = series; names[series] = name; at[series] = panel[place] }
    if ($12 != "ok") { fails[series] = 1; next }
    error = $11 + 0 > 1e-17 ? $11 : 1e-17
    printf "%d %d %g %g %d\n", panel[place], floor, $9, error, number_of(floor ? "0xBBBBBB" : colour[name])
    value[series] = log(error) / log(10)
}
function number_of(text,    i, n) { # 0x and digits
    n = 0
    for (i = 3; i <= length(text); i++) n = 16 * n + index("0123456789ABCDEF", substr(text, i, 1)) - 1
    return n
}
# From the lowest label up, each at its line or a step above the label below it
END {
    for (p = 0; p < panels; p++) {
        below = LOW - STEP
        for (;;) {
            next_one = 0
            for (i = 1; i <= count; i++)
                if (!done[i] && at[order[i]] == p && (!next_one || value[order[i]] < value[order[next_one]])) next_one = i
            if (!next_one) break
            done[next_one] = 1
            series = order[next_one]
            y = value[series] > below + STEP ? value[series] : below + STEP
            below = y
            name = names[series]
            shade = number_of(name == "integrator alone" ? "0x777777" : colour[name])
            printf "%d %g %d \"%s%s\"\n", p, 10 ^ y, shade, name, (fails[series] || value[series] > 0 ? ": fails" : "") > labels
        }
    }
}
