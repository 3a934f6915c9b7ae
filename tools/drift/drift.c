/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce drift`: energy over simulated time, a line for each method, precision and step.
 */
#include "drift.h"
#include "common/commands.h"
#include "common/results.h"

#include <stdlib.h>
#include <string.h>

/* Lines of a run: the floor of each step, then all methods and precisions with it. */
static size_t plan(drift_line *lines, const drift_options *o)
{
    size_t count = 0;
    for (uint32_t s = 0; s < o->step_count; s++) {
        lines[count++] = (drift_line){.choice = {.method = TFA_METHOD_ABA, .precision = CHART_F128},
                                      .step = o->steps[s],
                                      .floor = 1};
        for (uint32_t p = 0; p < o->precision_count; p++)
            for (uint32_t m = 0; m < o->method_count; m++) {
                const uint32_t precision = o->precisions[p];
                const int mixed = chart_precisions[precision].residual != TFA_RESIDUAL_SAME;
                lines[count++] =
                    (drift_line){.choice = {.method = o->methods[m],
                                            .precision = precision,
                                            .refine = mixed && o->refine == 0 ? 1 : o->refine},
                                 .step = o->steps[s]};
            }
    }
    return count;
}

/* @return an exit status */
static int run_all(drift_line *lines, size_t count, drift_case *c, const drift_options *o,
                   FILE *out)
{
    drift_print_head(out, o);
    for (size_t i = 0; i < count; i++) {
        if (drift_run(&lines[i], c, o, NULL, NULL) != TFA_OK) {
            fprintf(stderr, "totalforce drift: %s\n", tfa_status_text(TFA_E_MEMORY));
            return EXIT_FAILED;
        }
        drift_print(out, c, o, &lines[i]);
        if (results_flush(out) != 0)
            return EXIT_FAILED; /* the reason is printed where the results are closed */
    }
    drift_print_summary(out, "# ", o, lines, count);
    if (out != stdout)
        drift_print_summary(stdout, "", o, lines, count);
    return EXIT_GOOD;
}

static int drift(const drift_options *o, drift_case *c, FILE *out)
{
    const size_t most = (size_t)o->step_count * (1 + (size_t)o->method_count * o->precision_count);
    drift_line *lines = calloc(most, sizeof *lines);
    const size_t count = lines ? plan(lines, o) : 0;
    int result = lines ? run_all(lines, count, c, o, out) : EXIT_FAILED;
    const int closed = results_close("drift", out);
    result = result == EXIT_GOOD ? closed : result;
    if (result == EXIT_GOOD && o->folder)
        result = drift_draw(o, c, lines, count);
    for (size_t i = 0; i < count; i++)
        drift_line_free(&lines[i]);
    free(lines);
    return result;
}

int command_drift(int argc, char **argv)
{
    drift_options options;
    drift_case c;
    const int error = drift_parse(argc, argv, &options);
    int result = EXIT_FAILED;
    if (error)
        fprintf(stderr, "totalforce drift: %s\n", strerror(error));
    else if (drift_case_open(&c, &options) == TFA_OK) {
        FILE *out = results_open("drift", options.folder, 0);
        result = out ? drift(&options, &c, out) : EXIT_FAILED;
        drift_case_close(&c);
    }
    free(options.command);
    return error ? EXIT_USAGE : result;
}
