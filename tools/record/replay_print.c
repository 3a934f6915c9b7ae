/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The report of a replay, for people and as JSON.
 */
#include "replay.h"

#include "common/commands.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct {
    double quantile;
    const char *name;
} quantiles[] = {{0.5, "p50"}, {0.9, "p90"}, {0.99, "p99"}, {0.999, "p99.9"}};
#define QUANTILES (sizeof quantiles / sizeof *quantiles)

/* Kernels of the recording and of the replay, where they are known. */
static int same_kernels(const replay *r)
{
    if (r->daemon)
        return 1; /* a daemon does not tell */
    return strcmp(r->robot.isa, tfa_isa_name()) == 0 && !r->robot.specialised == !r->specialised;
}

static const char *where(const replay *r)
{
    return r->daemon ? "by a daemon" : "in process";
}

/* ---- text ---- */

static void print_kernels(const replay *r)
{
    printf("recorded by totalforce %s, %s, %s\n", r->robot.version, r->robot.isa,
           r->robot.specialised ? "specialised kernel" : "generic kernel");
    if (r->daemon)
        printf("replayed by a daemon, robot '%s'\n", r->options->robot);
    else
        printf("replayed in process, %s, %s\n", tfa_isa_name(),
               r->specialised ? "specialised kernel" : "generic kernel");
    if (!same_kernels(r))
        printf("the kernels differ: so may the last digits\n");
    if (strcmp(r->hash, r->robot.model_hash) != 0)
        printf("the models differ: recorded %.16s, replayed %.16s\n", r->robot.model_hash, r->hash);
}

static void print_value(const char *field, double value, uint64_t bits)
{
    if (strcmp(field, "status") == 0 || strcmp(field, "answers.status") == 0)
        printf("%s", tfa_status_name((tfa_status)value));
    else if (bits)
        printf("%.17g (%016" PRIx64 ")", value, bits);
    else
        printf("%.17g", value);
}

static void print_difference(const char *title, const replay_difference *d)
{
    const difference *at = &d->at;
    printf("%s: record %" PRIu64 ", state %u, %s[%u]: recorded ", title, d->record, at->state,
           at->field, at->index);
    print_value(at->field, at->recorded, at->bits[0]);
    printf(", replayed ");
    print_value(at->field, at->other, at->bits[1]);
    printf("\n");
}

static void print_times(const char *name, const tfa_histogram *h)
{
    printf("  %-9s", name);
    for (size_t i = 0; i < QUANTILES; i++)
        if (tfa_histogram_supports(h, quantiles[i].quantile))
            printf(" %10.3f", 1e-3 * (double)tfa_histogram_quantile(h, quantiles[i].quantile));
        else
            printf(" %10s", "-");
    printf(" %10.3f\n", 1e-3 * (double)h->highest);
}

void replay_print(const replay *r)
{
    printf("%s: %" PRIu64 " requests of robot '%s', model %.16s\n", r->options->file, r->count,
           r->robot.robot, r->robot.model_hash);
    if (*r->cut_off)
        printf("%s\n", r->cut_off);
    print_kernels(r);
    printf("same bits %" PRIu64, r->same);
    if (r->options->tolerance > 0)
        printf(", within %g %" PRIu64, r->options->tolerance, r->within);
    printf(", differ %" PRIu64 "\n", r->differing);
    if (r->of_time + r->refused)
        printf("not played: %" PRIu64 " late, without room or sampled, %" PRIu64
               " refused by the daemon's configuration\n",
               r->of_time, r->refused);
    if (r->differing)
        print_difference("first difference", &r->first);
    if (r->largest.at.field) {
        printf("largest relative difference %.3g\n", r->largest.at.relative);
        print_difference("  there", &r->largest);
    }
    printf("\ncompute, us");
    for (size_t i = 0; i < QUANTILES; i++)
        printf(" %10s", quantiles[i].name);
    printf(" %10s\n", "max");
    print_times("recorded", &r->recorded);
    print_times("replayed", &r->replayed);
}

/* ---- JSON ---- */

static json_t *json_number(double x)
{
    return isfinite(x) ? json_real(x) : json_null();
}

static json_t *json_difference(const replay_difference *d, int there)
{
    char bits[2][17];
    if (!there)
        return json_null();
    for (int i = 0; i < 2; i++)
        snprintf(bits[i], sizeof bits[i], "%016" PRIx64, d->at.bits[i]);
    return json_pack("{s:I,s:I,s:s,s:I,s:o,s:o,s:s,s:s,s:o}", "record", (json_int_t)d->record,
                     "state", (json_int_t)d->at.state, "field", d->at.field, "index",
                     (json_int_t)d->at.index, "recorded", json_number(d->at.recorded), "replayed",
                     json_number(d->at.other), "recorded_bits", bits[0], "replayed_bits", bits[1],
                     "relative", json_number(d->at.relative));
}

static json_t *json_times(const tfa_histogram *h)
{
    json_t *times = json_pack("{s:I,s:f,s:I}", "count", (json_int_t)h->count, "mean",
                              tfa_histogram_mean(h), "max", (json_int_t)h->highest);
    for (size_t i = 0; i < QUANTILES; i++)
        json_object_set_new(
            times, quantiles[i].name,
            json_integer((json_int_t)tfa_histogram_quantile(h, quantiles[i].quantile)));
    return times;
}

int replay_print_json(const replay *r)
{
    json_t *json = json_pack(
        "{s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:b,s:I,s:I,s:I,s:I,s:I,s:I,s:o,s:o,s:o,s:o,s:b}", "file",
        r->options->file, "robot", r->robot.robot, "model", r->robot.model_hash, "replayed_model",
        r->hash, "replayed", where(r), "isa", r->robot.isa, "replayed_isa",
        r->daemon ? "" : tfa_isa_name(), "same_kernels", same_kernels(r), "requests",
        (json_int_t)r->count, "same", (json_int_t)r->same, "within", (json_int_t)r->within,
        "differ", (json_int_t)r->differing, "of_time", (json_int_t)r->of_time, "refused",
        (json_int_t)r->refused, "first", json_difference(&r->first, r->differing > 0), "largest",
        json_difference(&r->largest, r->largest.at.field != NULL), "recorded_ns",
        json_times(&r->recorded), "replayed_ns", json_times(&r->replayed), "cut_off",
        *r->cut_off != 0);
    const int failed = !json || json_dumpf(json, stdout, JSON_INDENT(2)) != 0;
    json_decref(json);
    printf("\n");
    return failed ? EXIT_FAILED : EXIT_GOOD;
}
