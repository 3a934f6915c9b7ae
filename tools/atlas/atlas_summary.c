/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Summary of the rows of an atlas: counted and not asserted.
 */
#include "atlas.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

static int is_estimated(const atlas_row *row)
{
    return row->mode == ATLAS_SERVICE || row->mode == ATLAS_ESTIMATED;
}

static double over_floor(const atlas_row *row)
{
    return row->worst > ATLAS_ROUNDING ? row->worst / row->floor : 0.0;
}

/* How many times the worst seed is the least */
static double seed_spread(const atlas_row *row)
{
    const int counts = row->mode == ATLAS_PLAIN && !row->refused && row->error_high > ATLAS_FAILED;
    return counts && row->error_low > 0.0 ? row->error_high / row->error_low : 0.0;
}

static void keep_extremes(atlas_summary *s, const atlas_row *row)
{
    s->broken += row->mode == ATLAS_ESTIMATED && row->over > ATLAS_UNDERESTIMATE_MAX;
    if (is_estimated(row) && row->over > (s->over ? s->over->over : 0.0))
        s->over = row;
    if (seed_spread(row) > (s->spread ? seed_spread(s->spread) : 0.0))
        s->spread = row;
    if (row->mode != ATLAS_SERVICE || row->by_method + row->fallback == 0)
        return;
    if (!s->worst || row->worst > s->worst->worst)
        s->worst = row;
    if (over_floor(row) > (s->far ? over_floor(s->far) : 0.0))
        s->far = row;
}

atlas_summary atlas_summarise(const atlas_row *rows, size_t count)
{
    atlas_summary s = {0};
    for (size_t i = 0; i < count; i++) {
        const atlas_row *row = &rows[i];
        s.answers[row->mode][0] += row->by_method;
        s.answers[row->mode][1] += row->fallback;
        s.answers[row->mode][2] += row->refused;
        s.silent += row->silent;
        s.unreported += row->mode == ATLAS_SERVICE ? row->unreported : 0;
        s.estimates += row->mode == ATLAS_ESTIMATED ? row->estimated : 0;
        keep_extremes(&s, row);
    }
    return s;
}

static void print_broken(const atlas_row *row)
{
    char value[32];
    atlas_short(value, sizeof value, row->value);
    fprintf(stderr,
            "totalforce atlas: %s %s, %" PRIu32 " bodies, %s, %s: ", atlas_map_words[row->map],
            value, row->bodies, tfa_method_name(row->method), atlas_mode_words[row->mode]);
    if (row->silent)
        fprintf(stderr, "%" PRIu32 " errors above 1e-6 are estimated below 1e-7\n", row->silent);
    else
        fprintf(stderr, "an estimate is 1/%.2g of the error\n", row->over);
}

int atlas_promises_kept(const atlas_summary *summary, const atlas_row *rows, size_t count)
{
    if (summary->silent == 0 && (!summary->over || summary->over->over <= ATLAS_UNDERESTIMATE_MAX))
        return 1;
    fprintf(stderr, "totalforce atlas: a promise about estimates is broken\n");
    for (size_t i = 0; i < count; i++)
        if (rows[i].silent || rows[i].over > ATLAS_UNDERESTIMATE_MAX)
            print_broken(&rows[i]);
    return 0;
}

/* The first value along the axis at which the method fails at any size; UINT32_MAX: nowhere. */
static uint32_t fails_from(const atlas_row *rows, size_t count, uint32_t method, atlas_mode mode)
{
    uint32_t first = UINT32_MAX;
    for (size_t i = 0; i < count; i++)
        if (rows[i].method == method && rows[i].mode == mode && rows[i].point < first &&
            atlas_failed(&rows[i]))
            first = rows[i].point;
    return first;
}

static double value_at(const atlas_row *rows, size_t count, uint32_t point)
{
    for (size_t i = 0; i < count; i++)
        if (rows[i].point == point)
            return rows[i].value;
    return NAN;
}

/* "; from 1e6: tfa, dca", or ": aba" with those that fail nowhere. */
static int list_methods(FILE *out, const char *lead, const atlas_row *rows, size_t count,
                        atlas_mode mode, uint32_t point)
{
    int listed = 0;
    for (size_t i = 0; i < count && rows[i].bodies == rows[0].bodies && rows[i].point == 0; i++) {
        if (rows[i].mode != mode || fails_from(rows, count, rows[i].method, mode) != point)
            continue;
        fprintf(out, "%s%s", listed++ ? ", " : lead, tfa_method_name(rows[i].method));
    }
    return listed;
}

static void print_failures(FILE *out, const char *lead_in, const atlas_row *rows, size_t count,
                           atlas_mode mode)
{
    char lead[64], value[32];
    int listed = 0;
    fputs(lead_in, out);
    for (uint32_t point = 0; point < ATLAS_POINTS; point++) {
        atlas_short(value, sizeof value, value_at(rows, count, point));
        snprintf(lead, sizeof lead, "%sfrom %s on ", listed ? "; " : "", value);
        listed += list_methods(out, lead, rows, count, mode, point);
    }
    fputs(listed ? "." : "none.", out);
    if (listed && list_methods(out, " Never: ", rows, count, mode, UINT32_MAX))
        fputc('.', out);
    fputc('\n', out);
}

static void print_row_name(FILE *out, const atlas_row *row)
{
    char value[32];
    atlas_short(value, sizeof value, row->value);
    fprintf(out, " (%s at %s %s, %" PRIu32 " bodies", tfa_method_name(row->method),
            atlas_map_words[row->map], value, row->bodies);
    if (row->worst_by != row->method)
        fprintf(out, ", answered by %s", tfa_method_name(row->worst_by));
    fputc(')', out);
}

/* From where on the data themselves allow no better than a failure. */
static void print_floor(FILE *out, const char *prefix, const atlas_row *rows, size_t count)
{
    char value[32];
    uint32_t first = UINT32_MAX;
    for (size_t i = 0; i < count; i++)
        if (rows[i].floor > ATLAS_FAILED && rows[i].point < first)
            first = rows[i].point;
    if (first == UINT32_MAX)
        return;
    atlas_short(value, sizeof value, value_at(rows, count, first));
    fprintf(
        out,
        "%sFrom %s on, at some size, the floor is above 1e-4: the last bits of the robot's numbers "
        "and the request's change the exact answer by more, and no method can help.\n",
        prefix, value);
}

static void print_spread(FILE *out, const char *prefix, const atlas_summary *s)
{
    if (!s->spread)
        return;
    fprintf(out, "%sLargest error of a seed / least, of a method alone that fails: %.0f", prefix,
            seed_spread(s->spread));
    print_row_name(out, s->spread);
    fputs(".\n", out);
}

static void print_service(FILE *out, const char *prefix, const atlas_summary *s)
{
    const uint64_t *answers = s->answers[ATLAS_SERVICE];
    fprintf(out,
            "%sThe service: %" PRIu64 " answers by the method asked for, %" PRIu64
            " by another one that the reply names, %" PRIu64 " refused by name; %" PRIu64
            " are wrong by more than 1e-4 and have no estimate.\n",
            prefix, answers[0], answers[1], answers[2], s->unreported);
    if (!s->worst)
        return;
    fprintf(out, "%sIts largest error is %.1e", prefix, s->worst->worst);
    print_row_name(out, s->worst);
    if (s->far) {
        fprintf(out, "; the farthest from the floor is %.1e times that", over_floor(s->far));
        print_row_name(out, s->far);
    }
    fputs(".\n", out);
}

void atlas_print_estimates(FILE *out, const char *prefix, const atlas_summary *s)
{
    fprintf(out, "%sOf %" PRIu64 " estimates ", prefix, s->estimates);
    if (s->over) {
        if (s->over->over > 1.0)
            fprintf(out, "the least is 1/%.2g of the true error", s->over->over);
        else
            fprintf(out, "the least is %.2g times the true error", 1.0 / s->over->over);
        print_row_name(out, s->over);
    } else {
        fputs("none is below the true error", out);
    }
    fprintf(out,
            ", promised 1/%g, broken in %" PRIu64
            " cells; errors above 1e-6 estimated below 1e-7: %" PRIu64 ".\n",
            ATLAS_UNDERESTIMATE_MAX, s->broken, s->silent);
}

void atlas_print_summary(FILE *out, const char *prefix, const atlas_row *rows, size_t count)
{
    const atlas_summary s = atlas_summarise(rows, count);
    fputs(prefix, out);
    print_failures(out,
                   "Alone, wrong by more than 1e-4 and 100 times the floor, at some size: ", rows,
                   count, ATLAS_PLAIN);
    fputs(prefix, out);
    print_failures(out, "Refined once, still: ", rows, count, ATLAS_REFINED);
    print_floor(out, prefix, rows, count);
    print_spread(out, prefix, &s);
    print_service(out, prefix, &s);
    atlas_print_estimates(out, prefix, &s);
}
