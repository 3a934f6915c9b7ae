/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce sweep`: one operation for many states.
 */
#include "sweep.h"
#include "common/commands.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MPI_PROGRAM "totalforce-sweep"

/* --expect-error against the true errors, where there are some, else against the estimates */
static int meets_expectation(const sweep_plan *plan, const statistics *s)
{
    const double limit = plan->options->expect_error;
    const series *errors = plan->options->reference ? &s->error : &s->estimate;
    const uint64_t failed = s->states - s->status[0];
    if (limit > 0 && failed)
        fprintf(stderr, "totalforce sweep: %" PRIu64 " states failed, --expect-error %g\n", failed,
                limit);
    if (limit > 0 && errors->max > limit)
        fprintf(stderr, "totalforce sweep: state %" PRIu64 ": error %g, --expect-error %g\n",
                errors->max_at, errors->max, limit);
    return !(limit > 0) || (failed == 0 && !(errors->max > limit));
}

/* A part prints nothing: its blocks are no statistics yet. */
static int part_result(const sweep_plan *plan, const sweep_results *r)
{
    const sweep_options *o = plan->options;
    uint64_t missing = 0;
    for (uint64_t block = o->part - 1; block < plan->blocks; block += o->parts)
        missing += !sweep_is_done(r->done, block);
    if (missing) {
        sweep_print_missing(plan, r);
        return EXIT_UNMET;
    }
    if (!o->quiet)
        fprintf(stderr,
                "totalforce sweep: part %u/%u is complete; after all parts: the same with --merge "
                "in place of --part\n",
                o->part, o->parts);
    return EXIT_GOOD;
}

static int report(const sweep_plan *plan, const sweep_results *r, int ranks)
{
    if (!plan->options->quiet)
        sweep_print_rate(r, ranks);
    if (plan->options->parts)
        return part_result(plan, r);
    if (r->found + r->finished < plan->blocks) {
        sweep_print_missing(plan, r);
        return EXIT_UNMET;
    }
    const int result = sweep_print(plan, r, ranks);
    return result != EXIT_GOOD                       ? result
           : meets_expectation(plan, &r->statistics) ? EXIT_GOOD
                                                     : EXIT_UNMET;
}

static int sweep(sweep_options *options, sweep_ranks *ranks)
{
    sweep_plan plan;
    sweep_results results = {0};
    int result = sweep_plan_make(&plan, options, ranks);
    if (result == EXIT_GOOD) {
        result = sweep_run(&plan, ranks, &results);
        if (ranks->rank == 0 && results.done) {
            const int reported = report(&plan, &results, ranks->size);
            result = result == EXIT_GOOD ? reported : result;
        }
        sweep_results_free(&results);
    }
    sweep_plan_free(&plan);
    scene_options_free(&options->scene);
    return result;
}

/* A wrong command line is wrong on every rank: one of them says so. */
static int parse_quietly(int argc, char **argv, sweep_options *options, int rank)
{
    const int kept = rank ? dup(STDERR_FILENO) : -1;
    const int nowhere = rank ? open("/dev/null", O_WRONLY | O_CLOEXEC) : -1;
    if (nowhere >= 0)
        dup2(nowhere, STDERR_FILENO);
    const int error = sweep_parse(argc, argv, options);
    if (kept >= 0)
        dup2(kept, STDERR_FILENO);
    close(kept);
    close(nowhere);
    return error;
}

int sweep_main(int argc, char **argv, sweep_ranks *ranks)
{
    sweep_options options;
    const int error = parse_quietly(argc, argv, &options, ranks->rank);
    if (error) {
        fprintf(stderr, "totalforce sweep: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    ranks->start(ranks);
    const int result = sweep(&options, ranks);
    ranks->finish();
    return result;
}

/* Becomes the program beside this one that is linked with MPI. */
static int run_with_mpi(char **argv)
{
    char path[PATH_MAX + sizeof "/" MPI_PROGRAM];
    const ssize_t length = readlink("/proc/self/exe", path, PATH_MAX);
    char *slash = length > 0 ? memrchr(path, '/', (size_t)length) : NULL;
    if (slash) {
        strcpy(slash + 1, MPI_PROGRAM);
        execv(path, argv);
    }
    fprintf(stderr,
            "totalforce sweep: %d ranks were started, and %s is not there: %s; build it with "
            "-DTFA_MPI=ON, or use --part I/N without MPI\n",
            sweep_launched_ranks(), slash ? path : MPI_PROGRAM, strerror(errno));
    return EXIT_FAILED;
}

int command_sweep(int argc, char **argv)
{
    return sweep_launched_ranks() > 1 ? run_with_mpi(argv)
                                      : sweep_main(argc, argv, &sweep_ranks_single);
}
