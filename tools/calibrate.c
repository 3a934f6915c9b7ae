/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The crossovers of this machine: contest after contest, and the table they make.
 */
#include "calibrate.h"
#include "commands.h"
#include "results.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define AT(name) #name, offsetof(tfa_crossovers, name)
#define LENGTHS                                                                                    \
    {                                                                                              \
        24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 1024, 2048                                    \
    }
#define LANES                                                                                      \
    {                                                                                              \
        2, 3, 4, 6, 8                                                                              \
    }
#define WORKS                                                                                      \
    {                                                                                              \
        14, 28, 56, 112, 224, 448, 896, 1792, 3584                                                 \
    }
#define TIPS                                                                                       \
    {                                                                                              \
        2, 3, 4, 6, 8                                                                              \
    }

/* By number of threads, rising: what is not measured goes by the row above it. */
static const calibrate_contest contests[] = {
    {AT(lanes_from), CALIBRATE_STATES, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, TFA_METHOD_ABA, 1,
     LANES},
    {AT(pool_from), CALIBRATE_WORK, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, TFA_METHOD_ABA, 2,
     WORKS},
    {AT(scan_from_1), CALIBRATE_CHAIN, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, TFA_METHOD_SCAN, 1,
     LENGTHS},
    {AT(scan_from_2), CALIBRATE_CHAIN, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, TFA_METHOD_SCAN, 2,
     LENGTHS},
    {AT(scan_from_4), CALIBRATE_CHAIN, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_ABA, TFA_METHOD_SCAN, 4,
     LENGTHS},
    {AT(lambda_scan_from_1), CALIBRATE_CHAIN, TFA_OP_OPERATIONAL_INERTIA, TFA_METHOD_PROPAGATION,
     TFA_METHOD_SCAN, 1, LENGTHS},
    {AT(lambda_scan_from_2), CALIBRATE_CHAIN, TFA_OP_OPERATIONAL_INERTIA, TFA_METHOD_PROPAGATION,
     TFA_METHOD_SCAN, 2, LENGTHS},
    {AT(lambda_scan_from_4), CALIBRATE_CHAIN, TFA_OP_OPERATIONAL_INERTIA, TFA_METHOD_PROPAGATION,
     TFA_METHOD_SCAN, 4, LENGTHS},
    {AT(pv_from), CALIBRATE_TIPS, TFA_OP_OPERATIONAL_INERTIA, TFA_METHOD_PROPAGATION,
     TFA_METHOD_PV_OSIMR, 1, TIPS},
};
enum { CONTESTS = sizeof contests / sizeof *contests };

uint32_t calibrate_crossing(const uint32_t *sizes, const double *ratios, uint32_t count)
{
    uint32_t k = count;
    while (k > 0 && ratios[k - 1] < 1)
        k--;
    if (k == count)
        return TFA_NEVER;
    if (k == 0)
        return sizes[0];
    const double below = log(sizes[k - 1]), above = log(sizes[k]);
    const double part = (ratios[k - 1] - 1) / (ratios[k - 1] - ratios[k]);
    const uint32_t from = (uint32_t)ceil(exp(below + part * (above - below)) - 1e-9);
    return from > sizes[k] ? sizes[k] : from;
}

static uint32_t *number_of(tfa_crossovers *c, const calibrate_contest *contest)
{
    return (uint32_t *)(void *)((char *)c + contest->at);
}

/* All sizes of one contest; what it found stands on standard error. */
static int run(const calibrate_contest *contest, uint32_t budget_ms, uint32_t *from)
{
    double ratios[CALIBRATE_SIZES];
    uint32_t count = 0;
    fprintf(stderr, "%s:", contest->name);
    for (; count < CALIBRATE_SIZES && contest->sizes[count]; count++) {
        const uint32_t size = contest->sizes[count];
        const int status = calibrate_measure(contest, size, budget_ms, &ratios[count]);
        if (status != TFA_OK) {
            fprintf(stderr, " %" PRIu32 ": %s\n", size, tfa_status_text(status));
            return status;
        }
        fprintf(stderr, " %" PRIu32 ": %.2f", size, ratios[count]);
    }
    *from = calibrate_crossing(contest->sizes, ratios, count);
    if (*from == TFA_NEVER)
        fputs(" -> never\n", stderr);
    else
        fprintf(stderr, " -> %" PRIu32 "\n", *from);
    return TFA_OK;
}

static int measure_all(uint32_t budget_ms, tfa_crossovers *c)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    *c = *tfa_crossovers_default();
    fputs("time of the later way over that of the earlier one, by size:\n", stderr);
    for (uint32_t k = 0; k < CONTESTS; k++) {
        uint32_t *from = number_of(c, &contests[k]);
        if ((long)contests[k].threads > processors) {
            if (contests[k].axis == CALIBRATE_CHAIN)
                *from = *number_of(c, &contests[k - 1]);
            fprintf(stderr, "%s: not measured, %ld processors\n", contests[k].name, processors);
            continue;
        }
        const int status = run(&contests[k], budget_ms, from);
        if (status != TFA_OK)
            return status;
    }
    return TFA_OK;
}

/* Machine, date, command: the head of a chart without its signs for comments */
static char *remark(const char *command)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    results_print_head(out, command);
    if (fclose(out) != 0 || !text)
        return NULL;
    char *to = text;
    for (const char *from = text; *from;) {
        from += strncmp(from, "# ", 2) == 0 ? 2 : 0;
        while (*from && *from != '\n')
            *to++ = *from++;
        if (*from)
            *to++ = *from++;
    }
    *to = '\0';
    return text;
}

static int write_table(const tfa_crossovers *c, const char *command, const char *folder)
{
    char text[8192];
    FILE *out = results_create("chart", folder, "crossovers.conf");
    if (!out)
        return EXIT_FAILED;
    char *head = remark(command);
    (void)tfa_crossovers_text(c, head, text, sizeof text);
    free(head);
    fputs(text, out);
    return results_close("chart", out);
}

int calibrate(const char *command, const char *folder, uint32_t budget_ms)
{
    tfa_crossovers c;
    const int status = measure_all(budget_ms, &c);
    if (status != TFA_OK) {
        fprintf(stderr, "totalforce chart: calibration: %s\n", tfa_status_text(status));
        return EXIT_FAILED;
    }
    return write_table(&c, command, folder);
}
