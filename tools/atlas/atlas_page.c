/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page of an atlas: for each map, mode and method a picture of cells, coloured by the digits
 * that are lost.
 */
#include "atlas.h"
#include "common/commands.h"
#include "common/html_page.h"
#include "common/results.h"
#include "common/svg.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* User units of one picture */
#define WIDE 150.0
#define HIGH 168.0
#define LEFT 30.0
#define RIGHT 147.0
#define TOP 4.0
#define BOTTOM 142.0

static const char *const mode_names[ATLAS_MODE_COUNT] = {
    [ATLAS_PLAIN] = "Methods alone",
    [ATLAS_REFINED] = "Refined once",
    [ATLAS_SERVICE] = "As the service answers a default request",
    [ATLAS_ESTIMATED] = "The same with estimate always"};

static int is_shown_first(atlas_mode mode)
{
    return mode == ATLAS_PLAIN || mode == ATLAS_SERVICE;
}

enum { SHADES = 8 }; /* classes q0 .. of page.css, two digits each */

static int shade(double error)
{
    const double digits = log10(fmin(fmax(error, 1e-16), 1.0)) + 16.0;
    return (int)fmin(digits / 2.0, SHADES - 1.0);
}

static uint32_t place_of(const uint32_t *list, uint32_t count, uint32_t wanted)
{
    uint32_t k = 0;
    while (k < count && list[k] != wanted)
        k++;
    return k;
}

static void write_cell(FILE *out, const atlas_options *o, const atlas_row *rows, size_t index,
                       int of_floor)
{
    const atlas_row *row = &rows[index];
    const double wide = (RIGHT - LEFT) / o->size_count, high = (BOTTOM - TOP) / o->points;
    const double x = LEFT + wide * place_of(o->sizes, o->size_count, row->bodies),
                 y = BOTTOM - high * (row->point + 1);
    char class[8] = "none", letter[2];
    const int is_empty = atlas_refused(row) && !of_floor;
    const int dark = shade(of_floor ? row->floor : row->error);
    const char *mark = of_floor ? "" : atlas_mark(row, letter);
    if (!is_empty)
        snprintf(class, sizeof class, "q%d", dark);
    fprintf(out,
            "<rect class=\"%s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" "
            "data-r=\"%zu\"",
            class, x, y, wide, high, index);
    if (row->mode < ATLAS_SERVICE)
        fprintf(out, " data-also=\"%zu\"", index + (size_t)(ATLAS_SERVICE - row->mode));
    fputs("/>", out);
    if (*mark)
        svg_text(out, x + wide / 2, y + high / 2 + 3.2,
                 is_empty   ? "empty"
                 : dark > 4 ? "light"
                            : "dark",
                 mark);
    fputc('\n', out);
}

static void write_axes(FILE *out, const atlas_options *o, atlas_map map)
{
    const double wide = (RIGHT - LEFT) / o->size_count, high = (BOTTOM - TOP) / o->points;
    const uint32_t size_step = (o->size_count + 3) / 4, value_step = (o->points + 6) / 7;
    char text[32];
    for (uint32_t k = 0; k < o->size_count; k += size_step) {
        snprintf(text, sizeof text, "%" PRIu32, o->sizes[k]);
        svg_text(out, LEFT + wide * (k + 0.5), BOTTOM + 12.0, "mid", text);
    }
    for (uint32_t k = 0; k < o->points; k += value_step) {
        atlas_short(text, sizeof text, atlas_value(map, k, o->points));
        svg_text(out, LEFT - 3.0, BOTTOM - high * (k + 0.5) + 3.5, "end", text);
    }
    svg_text(out, RIGHT, BOTTOM + 24.0, "end", "moving bodies");
}

/* One picture: of a method and mode, or of the floor of the data */
static void write_panel(FILE *out, const atlas_options *o, const atlas_row *rows, size_t first,
                        size_t count, uint32_t method, atlas_mode mode, int of_floor)
{
    const char *name = of_floor ? "floor of the data" : tfa_method_name(method);
    char label[192];
    snprintf(label, sizeof label, "%s: %s over %s and moving bodies, %s", name,
             of_floor ? "the floor" : "error", atlas_axis(rows[first].map), mode_names[mode]);
    fprintf(out, "<figure class=\"panel\"%s><figcaption><b>%s</b></figcaption>\n",
            is_shown_first(mode) ? "" : " hidden", name);
    svg_begin(out, WIDE, HIGH, "map", label);
    write_axes(out, o, rows[first].map);
    for (size_t i = first; i < first + count; i++)
        if (rows[i].method == method && rows[i].mode == mode)
            write_cell(out, o, rows, i, of_floor);
    fputs("</svg></figure>\n", out);
}

static void write_mode(FILE *out, const atlas_options *o, const atlas_row *rows, size_t first,
                       size_t count, atlas_mode mode)
{
    fprintf(out, "<div class=\"group\"%s><h3>%s</h3>\n<div class=\"panels maps\">\n",
            is_shown_first(mode) ? "" : " hidden", mode_names[mode]);
    for (uint32_t m = 0; m < o->method_count; m++)
        write_panel(out, o, rows, first, count, o->methods[m], mode, 0);
    if (mode == ATLAS_PLAIN)
        write_panel(out, o, rows, first, count, o->methods[0], mode, 1);
    fputs("</div></div>\n", out);
}

/* The sentences of atlas_print_summary as a list */
static void write_sentences(FILE *out, const atlas_row *rows, size_t count)
{
    char *text = NULL;
    size_t size = 0;
    FILE *sentences = open_memstream(&text, &size);
    if (!sentences)
        return;
    atlas_print_summary(sentences, "", rows, count);
    fclose(sentences);
    fputs("<ul class=\"notes\">\n", out);
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        fputs("<li>", out);
        html_text(out, line);
        fputs("</li>\n", out);
    }
    fputs("</ul>\n", out);
    free(text);
}

static void write_map(FILE *out, const atlas_options *o, const atlas_row *rows, size_t first,
                      size_t count)
{
    const atlas_map map = rows[first].map;
    fprintf(out, "<section class=\"group\"><h2>%s: %s</h2>\n<p>Up: %s.</p>\n", atlas_map_words[map],
            atlas_map_text(map), atlas_axis(map));
    for (int mode = 0; mode < ATLAS_MODE_COUNT; mode++)
        write_mode(out, o, rows, first, count, (atlas_mode)mode);
    write_sentences(out, rows + first, count);
    fputs("</section>\n", out);
}

static void write_key(FILE *out)
{
    fputs(
        "<svg class=\"key\" viewBox=\"0 0 330 40\" role=\"img\" aria-label=\"Colours: from light, "
        "exact, to dark, wrong\">",
        out);
    for (int k = 0; k <= SHADES; k++) {
        char text[16];
        svg_power(text, sizeof text, pow(10.0, 2 * k - 16));
        if (k < SHADES)
            fprintf(out, "<rect class=\"q%d\" x=\"%d\" y=\"2\" width=\"38\" height=\"16\"/>", k,
                    12 + 38 * k);
        svg_text(out, 12 + 38 * k, 32, "mid", text);
    }
    fputs("</svg>\n<p class=\"notes\">Colour: relative error, median over seeds and states. No "
          "letter: the method itself answered. A letter: another method answered (a: aba, s: "
          "scan or scan-two-pass, c: crba). × refused by name. ? itself, wrong by more than 1e-4, "
          "no estimate. = as a method before it, to the last bit.</p>\n",
          out);
}

/* A row for each map, size, mode and method, a column for each value along the axis: the error */
static void write_table(FILE *out, const atlas_options *o, const atlas_row *rows, size_t count)
{
    char value[32];
    fprintf(out,
            "<details><summary>Table of the errors: %s</summary>\n<div class=\"scroll\"><table>"
            "<thead><tr><th scope=\"col\">method</th><th scope=\"col\">mode</th><th scope=\"col\" "
            "class=\"n\">bodies</th>",
            atlas_map_words[rows->map]);
    for (uint32_t k = 0; k < o->points; k++) {
        atlas_short(value, sizeof value, atlas_value(rows->map, k, o->points));
        fprintf(out, "<th scope=\"col\" class=\"n\">%s</th>", value);
    }
    fputs("</tr></thead>\n<tbody>\n", out);
    const size_t stride = (size_t)o->method_count * ATLAS_MODE_COUNT;
    for (size_t i = 0; i + stride * o->points <= count; i += stride * o->points)
        for (size_t k = i; k < i + stride; k++) {
            fprintf(out, "<tr><th scope=\"row\">%s</th><td>%s</td><td class=\"n\">%" PRIu32 "</td>",
                    tfa_method_name(rows[k].method), atlas_mode_words[rows[k].mode],
                    rows[k].bodies);
            for (uint32_t p = 0; p < o->points; p++)
                fprintf(out,
                        isfinite(rows[k + p * stride].error) ? "<td class=\"n\">%.1e</td>"
                                                             : "<td class=\"n\">×</td>",
                        rows[k + p * stride].error);
            fputs("</tr>\n", out);
        }
    fputs("</tbody></table></div></details>\n", out);
}

static char *print_rows(const atlas_options *o, const atlas_row *rows, size_t count)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    atlas_print_head(out, o, rows, count);
    for (size_t i = 0; i < count; i++)
        atlas_print_row(out, o, &rows[i]);
    return fclose(out) == 0 ? text : NULL;
}

static void write_page(FILE *out, const atlas_options *o, const atlas_row *rows, size_t count,
                       const char *csv)
{
    const atlas_summary s = atlas_summarise(rows, count);
    const uint64_t *answers = s.answers[ATLAS_SERVICE];
    char title[256];
    snprintf(title, sizeof title,
             "%" PRIu64 " of %" PRIu64 " default requests are wrong by more than 1e-4 without an "
             "estimate: where a method fails, another one answers",
             s.unreported, answers[0] + answers[1] + answers[2]);
    html_begin(out, &(html_page){.title = title,
                                 .lead = "Relative error of forward dynamics against quadruple "
                                         "precision, over the cause of failures and the number of "
                                         "bodies. Light is exact, dark is wrong.",
                                 .filters = "map method mode=plain|service bodies",
                                 .tip = "value bodies error error_high floor "
                                        "estimate answered_by reason own fallback refused about "
                                        "same_as",
                                 .also = "default request"});
    fputs("<noscript><p>Without scripts: methods alone and default requests; the tables have all "
          "modes.</p></noscript>\n<div id=\"filters\"></div>\n",
          out);
    write_key(out);
    for (size_t i = 0, n; i < count; i += n) {
        n = atlas_same_map(rows + i, count - i);
        write_map(out, o, rows, i, n);
    }
    fputs("<h2>Numbers</h2>\n", out);
    for (size_t i = 0, n; i < count; i += n) {
        n = atlas_same_map(rows + i, count - i);
        write_table(out, o, rows + i, n);
    }
    html_end(out, csv);
}

int atlas_page(FILE *out, const atlas_options *options, const atlas_row *rows, size_t count)
{
    char *csv = print_rows(options, rows, count);
    if (csv)
        write_page(out, options, rows, count, csv);
    else
        fprintf(stderr, "totalforce atlas: %s\n", tfa_status_text(TFA_E_MEMORY));
    const int closed = results_close("atlas", out);
    const int result = csv ? closed : EXIT_FAILED;
    free(csv);
    return result;
}
