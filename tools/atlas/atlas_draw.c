/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Draws the atlas, a page for each map: feeds cells and captions to gnuplot, whose script in atlas/
 * says how they look.
 */
#include "atlas.h"
#include "common/commands.h"
#include "common/results.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

static uint32_t place_of(const uint32_t *list, uint32_t count, uint32_t wanted)
{
    uint32_t k = 0;
    while (k < count && list[k] != wanted)
        k++;
    return k;
}

static double decades(double error)
{
    return log10(fmin(fmax(error, 1e-16), 1.0));
}

const char *atlas_mark(const atlas_row *row, char letter[2])
{
    if (atlas_refused(row))
        return "×";
    if (row->mode == ATLAS_SERVICE && !atlas_fell_back(row) &&
        2 * row->unreported >= row->by_method)
        return "?";
    if (row->mode == ATLAS_PLAIN && row->same_as)
        return "=";
    letter[0] = atlas_fell_back(row) ? tfa_method_name(row->answered_by)[0] : '\0';
    letter[1] = '\0';
    return letter;
}

/* Block $cells: size point method mode log10(error); and $marks: size point method mode text. */
static void write_cells(FILE *out, const atlas_options *o, const atlas_row *rows, size_t count)
{
    for (int marks = 0; marks < 2; marks++) {
        fputs(marks ? "$marks << EOD\n" : "$cells << EOD\n", out);
        for (size_t i = 0; i < count; i++) {
            const atlas_row *row = &rows[i];
            char letter[2];
            const char *mark = atlas_mark(row, letter);
            if (row->mode == ATLAS_ESTIMATED || (marks ? !*mark : atlas_refused(row)))
                continue;
            fprintf(out, "%" PRIu32 " %" PRIu32 " %" PRIu32 " %d ",
                    place_of(o->sizes, o->size_count, row->bodies), row->point,
                    place_of(o->methods, o->method_count, row->method), (int)row->mode);
            if (marks)
                fprintf(out, "%s %d\n", mark, decades(row->error) > -7.0 && !atlas_refused(row));
            else
                fprintf(out, "%.3f\n", decades(row->error));
        }
        /* a block may not be empty: this one lies outside */
        fputs("-9 -9 -9 -9 0 0\nEOD\n", out);
    }
}

static void write_floor(FILE *out, const atlas_options *o, const atlas_row *rows, size_t count)
{
    fputs("$floor << EOD\n", out);
    for (size_t i = 0; i < count; i++)
        if (rows[i].method == o->methods[0] && rows[i].mode == ATLAS_PLAIN)
            fprintf(out, "%" PRIu32 " %" PRIu32 " %.3f\n",
                    place_of(o->sizes, o->size_count, rows[i].bodies), rows[i].point,
                    decades(rows[i].floor));
    fputs("EOD\n", out);
}

/* An array is declared before it is filled. */
static void write_array(FILE *out, const char *name, uint32_t count)
{
    fprintf(out, "array %s[%" PRIu32 "]\n", name, count);
}

static void write_names(FILE *out, const atlas_options *o, atlas_map map)
{
    char value[32];
    write_array(out, "method_name", o->method_count);
    for (uint32_t m = 0; m < o->method_count; m++)
        fprintf(out, "method_name[%" PRIu32 "] = '%s'\n", m + 1, tfa_method_name(o->methods[m]));
    write_array(out, "size_name", o->size_count);
    for (uint32_t k = 0; k < o->size_count; k++)
        fprintf(out, "size_name[%" PRIu32 "] = '%" PRIu32 "'\n", k + 1, o->sizes[k]);
    write_array(out, "value_name", o->points);
    for (uint32_t k = 0; k < o->points; k++) {
        atlas_short(value, sizeof value, atlas_value(map, k, o->points));
        fprintf(out, "value_name[%" PRIu32 "] = '%s'\n", k + 1, value);
    }
}

/* "s  scan", for each method that answered in another's place. */
static void write_key(FILE *out, const atlas_row *rows, size_t count)
{
    uint32_t seen = 0;
    fputs("$key << EOD\n", out);
    for (size_t i = 0; i < count; i++) {
        const uint32_t bit = 1u << (rows[i].answered_by % 32);
        if (rows[i].mode != ATLAS_SERVICE || !atlas_fell_back(&rows[i]) || seen & bit)
            continue;
        seen |= bit;
        const char *name = tfa_method_name(rows[i].answered_by);
        fprintf(out, "%c  %s\n", name[0], name);
    }
    fputs("?  itself, wrong by more\n   than 1e-4, no estimate\n×  none: refused by name\n"
          "=  as a method to the left,\n   to the last bit\nEOD\n",
          out);
}

static void draw_page(FILE *out, const atlas_options *o, const atlas_row *rows, size_t count)
{
    char title[256];
    snprintf(title, sizeof title, "Where methods fail: %s (%s)", atlas_map_text(rows->map),
             atlas_map_words[rows->map]);
    gnuplot_string(out, "page_title", title);
    gnuplot_string(out, "axis", atlas_axis(rows->map));
    gnuplot_string(out, "file", atlas_map_words[rows->map]);
    write_cells(out, o, rows, count);
    write_floor(out, o, rows, count);
    write_names(out, o, rows->map);
    write_key(out, rows, count);
    fputs("$words << EOD\n", out);
    atlas_print_summary(out, "", rows, count);
    fputs("EOD\nload scripts.'/page.gp'\n", out);
}

int atlas_draw(const atlas_options *options, const atlas_row *rows, size_t count)
{
    gnuplot_pipe g;
    if (gnuplot_start(&g, "atlas", options->scripts, options->folder) == 0) {
        fprintf(g.in, "rhs_word = '%s'\n", chart_rhs_words[options->rhs]);
        for (size_t i = 0, n; i < count; i += n) {
            n = atlas_same_map(rows + i, count - i);
            draw_page(g.in, options, rows + i, n);
        }
    }
    return gnuplot_finish(&g);
}
