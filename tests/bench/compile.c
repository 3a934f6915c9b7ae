/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a model costs before the first request: the time from URDF text to a model, and of its
 * parts; the bytes of the model and of a workspace.
 *
 *     bench_compile [--rounds N] [FILE.urdf ...]
 *
 * Without files: random chains of 64 to 4096 bodies. CPU time, medians.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "bench.h"
#include "timing.h"

#define ROUNDS_MAX 101

/* One round: ms of each part, and sizes. */
struct figures {
    double parse, create, workspace;
    size_t model_bytes, workspace_bytes, one_bytes;
    uint32_t bodies;
};

static int fail(const char *path, const char *what, int status)
{
    fprintf(stderr, "%s: %s: %s\n", path, what, tfa_status_text(status));
    return -1;
}

static int measure(const char *path, struct figures *f)
{
    static const tfa_workspace_options one = {.states = TFA_STATES_ONE};
    tfa_report report = {0};
    tfa_description *description = NULL;
    tfa_model *model = NULL;
    tfa_workspace *workspace = NULL;
    const double start = cpu_ns();
    int status = tfa_urdf_load(path, &description, &report);
    const double parsed = cpu_ns();
    if (status == TFA_OK)
        status = tfa_model_create(description, NULL, &report, &model);
    const double created = cpu_ns();
    if (status == TFA_OK)
        status = tfa_workspace_create(model, NULL, &workspace);
    const double ready = cpu_ns();
    f->parse = 1e-6 * (parsed - start);
    f->create = 1e-6 * (created - parsed);
    f->workspace = 1e-6 * (ready - created);
    if (status == TFA_OK) {
        f->bodies = tfa_model_summarise(model).bodies;
        f->model_bytes = tfa_model_size(description, NULL);
        f->workspace_bytes = tfa_workspace_size(model, NULL);
        f->one_bytes = tfa_workspace_size(model, &one);
    }
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    tfa_description_free(description);
    tfa_report_free(&report);
    return status == TFA_OK ? 0 : fail(path, "cannot be measured", status);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return values[count / 2];
}

static int contest(const char *name, const char *path, int rounds)
{
    static double parse[ROUNDS_MAX], create[ROUNDS_MAX], workspace[ROUNDS_MAX], all[ROUNDS_MAX];
    struct figures f = {0};
    for (int k = 0; k < rounds; k++) {
        if (measure(path, &f))
            return -1;
        parse[k] = f.parse;
        create[k] = f.create;
        workspace[k] = f.workspace;
        all[k] = f.parse + f.create;
    }
    printf("%-14s %6u %9.3f %9.3f %9.3f %9.3f %10zu %10zu %10zu\n", name, f.bodies,
           median(parse, rounds), median(create, rounds), median(all, rounds),
           median(workspace, rounds), f.model_bytes / f.bodies, f.workspace_bytes / 1024,
           f.one_bytes / 1024);
    return 0;
}

static int contest_chain(int links, int rounds)
{
    char name[32], path[] = "/tmp/tfa-bench-XXXXXX";
    const int file = mkstemp(path);
    if (file < 0 || chain_urdf(path, links, 1))
        return fail(path, "cannot be written", TFA_E_FILE);
    snprintf(name, sizeof name, "chain%d", links);
    const int result = contest(name, path, rounds);
    remove(path);
    return result;
}

int main(int argc, char **argv)
{
    static const int chains[] = {64, 256, 1000, 1024, 2048, 4096};
    int rounds = 15, at = 1, bad = 0;
    if (argc > 2 && strcmp(argv[1], "--rounds") == 0) {
        rounds = atoi(argv[2]);
        at = 3;
    }
    if (rounds < 1 || rounds > ROUNDS_MAX) {
        fprintf(stderr, "--rounds: 1 to %d\n", ROUNDS_MAX);
        return 3;
    }
    printf("%-14s %6s %9s %9s %9s %9s %10s %10s %10s\n", "robot", "bodies", "parse ms", "model ms",
           "both ms", "wspace ms", "model B/bd", "wspace KiB", "one KiB");
    for (int k = at; k < argc; k++) {
        const char *slash = strrchr(argv[k], '/');
        bad |= contest(slash ? slash + 1 : argv[k], argv[k], rounds);
    }
    for (size_t k = 0; at == argc && k < sizeof chains / sizeof *chains; k++)
        bad |= contest_chain(chains[k], rounds);
    return bad ? 2 : 0;
}
