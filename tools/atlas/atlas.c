/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce atlas`: failures of methods, and the answers of the service there.
 */
#include "atlas.h"
#include "common/commands.h"
#include "common/html_page.h"
#include "common/progress.h"
#include "common/results.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* All rows of a run: head and pictures need them together. */
typedef struct rows {
    atlas_row *all;
    size_t count;
    int failed;
} rows;

static size_t count_bits(uint32_t bits)
{
    size_t count = 0;
    for (; bits; bits &= bits - 1)
        count++;
    return count;
}

static void measure_cell(rows *r, const atlas_options *o, chart_case *c, const chart_data *d,
                         atlas_row row)
{
    for (uint32_t m = 0; m < o->method_count; m++)
        for (int mode = 0; mode < ATLAS_MODE_COUNT; mode++) {
            row.method = o->methods[m];
            row.mode = (atlas_mode)mode;
            r->all[r->count] = row;
            atlas_measure(&r->all[r->count++], c, d);
        }
}

/* All methods and modes of a cell, for one seed */
static int measure_seed(rows *r, const atlas_options *o, atlas_row cell, uint64_t seed)
{
    const mechanism_options mechanism = atlas_mechanism(cell.map, cell.value, cell.bodies, seed);
    chart_case c;
    chart_data d;
    int status = chart_case_open_mechanism(&c, &mechanism, atlas_map_words[cell.map]);
    if (status != TFA_OK)
        return status;
    status = chart_data_make(&d, &c, o->rhs, o->states);
    if (status == TFA_OK) {
        measure_cell(r, o, &c, &d, cell);
        chart_data_free(&d);
    } else {
        fprintf(stderr, "totalforce atlas: %s %g, %" PRIu32 " bodies: exact answer: %s\n",
                atlas_map_words[cell.map], cell.value, cell.bodies, tfa_status_text(status));
    }
    chart_case_close(&c);
    return status;
}

static int measure_at(rows *r, const atlas_options *o, atlas_map map, uint32_t point,
                      uint32_t bodies)
{
    const size_t first = r->count, count = (size_t)o->method_count * ATLAS_MODE_COUNT;
    const double value = atlas_value(map, point, o->points);
    const atlas_row cell = {.map = map, .point = point, .value = value, .bodies = bodies};
    int status = TFA_OK;
    for (uint32_t k = 0; status == TFA_OK && k < o->seeds; k++)
        status = measure_seed(r, o, cell, o->seed + k);
    r->count = status == TFA_OK ? first + count : first;
    for (size_t i = first; i < r->count; i++)
        atlas_combine_seeds(&r->all[i], count, o->seeds);
    atlas_find_same(r->all + first, r->count - first);
    return status;
}

/* Methods that cannot be mapped are told and left out; the rest is mapped. */
static int measure_all(rows *r, const atlas_options *o)
{
    const size_t cells = count_bits(o->maps) * o->points * o->size_count;
    /* the last cell has the rows of all its seeds */
    r->all = calloc((cells + o->seeds) * o->method_count * ATLAS_MODE_COUNT, sizeof *r->all);
    if (!r->all) {
        fprintf(stderr, "totalforce atlas: %s\n", tfa_status_text(TFA_E_MEMORY));
        return -1;
    }
    for (int map = 0; map < ATLAS_MAP_COUNT; map++)
        for (uint32_t k = 0; o->maps >> map & 1u && k < o->size_count; k++)
            for (uint32_t point = 0; point < o->points; point++) {
                progress_step(atlas_map_words[map], cells, "cells");
                r->failed |= measure_at(r, o, (atlas_map)map, point, o->sizes[k]) != TFA_OK;
            }
    progress_show(NULL, 0, 0, "");
    return 0;
}

static void print_all(FILE *out, const atlas_options *o, const rows *r)
{
    if (!o->json)
        atlas_print_head(out, o, r->all, r->count);
    for (size_t i = 0; i < r->count; i++)
        (o->json ? atlas_print_row_json : atlas_print_row)(out, o, &r->all[i]);
}

static int run(const atlas_options *o, rows *r)
{
    FILE *page = NULL;
    if (o->html && !(page = html_open("atlas", o->html)))
        return EXIT_FAILED;
    FILE *out = results_open("atlas", o->folder, o->json);
    if (!out) {
        if (page)
            fclose(page);
        return EXIT_FAILED;
    }
    const int measured = measure_all(r, o);
    if (measured == 0)
        print_all(out, o, r);
    int result = results_close("atlas", out);
    if (result == EXIT_GOOD && o->folder && r->count)
        result = atlas_draw(o, r->all, r->count);
    if (page && atlas_page(page, o, r->all, r->count) != EXIT_GOOD)
        result = EXIT_FAILED;
    if (result != EXIT_GOOD || measured != 0 || r->failed)
        return EXIT_FAILED;
    const atlas_summary summary = atlas_summarise(r->all, r->count);
    return atlas_promises_kept(&summary, r->all, r->count) ? EXIT_GOOD : EXIT_UNMET;
}

int command_atlas(int argc, char **argv)
{
    atlas_options options;
    rows r = {0};
    int result = EXIT_USAGE;
    const int error = atlas_parse(argc, argv, &options);
    if (error)
        fprintf(stderr, "totalforce atlas: %s\n", strerror(error));
    else
        result = run(&options, &r);
    free(r.all);
    free(options.command);
    return result;
}
