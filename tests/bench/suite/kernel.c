/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Building and loading of robots' own kernels.
 */
#include "suite.h"

#include <elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "../timing.h"

enum { LOADS = 5 };

/* Of children that have ended */
static double children_seconds(void)
{
    struct rusage u;
    getrusage(RUSAGE_CHILDREN, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

static int fail(const struct library *l, const char *reason, int status)
{
    fprintf(stderr, "bench_suite: %s\n", reason[0] ? reason : l->tfa_status_text(status));
    return -1;
}

static int build(struct kernel *k, const struct library *l, const tfa_model *model,
                 const char *folder, const char *compiler)
{
    char name[TFA_SPECIALISED_NAME_SIZE], reason[1024];
    const tfa_specialise_options options = {.compiler = compiler};
    tfa_specialise_result result;
    l->tfa_specialised_name(model, name);
    snprintf(k->path, sizeof k->path, "%s/%s", folder, name);
    if (access(k->path, R_OK) == 0)
        return 0;
    const double before = children_seconds();
    const int status =
        l->tfa_specialised_build(model, &options, k->path, &result, reason, sizeof reason);
    if (status != TFA_OK)
        return fail(l, reason, status);
    k->compile_s = result.compile_s;
    k->compilers_s = children_seconds() - before;
    snprintf(k->compiler, sizeof k->compiler, "%s", result.compiler);
    return 0;
}

/* Of its segments that are executed; 0 where it cannot be read */
static size_t text_bytes(const char *path)
{
    Elf64_Ehdr head;
    Elf64_Phdr segment;
    size_t sum = 0;
    FILE *f = fopen(path, "re");
    int good = f && fread(&head, sizeof head, 1, f) == 1 &&
               memcmp(head.e_ident, ELFMAG, SELFMAG) == 0 &&
               fseek(f, (long)head.e_phoff, SEEK_SET) == 0;
    for (int k = 0; good && k < head.e_phnum; k++) {
        good = fread(&segment, sizeof segment, 1, f) == 1;
        if (good && segment.p_type == PT_LOAD && segment.p_flags & PF_X)
            sum += segment.p_filesz;
    }
    if (f)
        fclose(f);
    return good ? sum : 0;
}

static int load(struct kernel *k, const struct library *l, const tfa_model *model)
{
    double ms[LOADS];
    char reason[512];
    for (int round = 0; round < LOADS; round++) {
        l->tfa_specialised_free(k->loaded);
        const double start = wall_ns();
        const int status =
            l->tfa_specialised_load(k->path, model, &k->loaded, reason, sizeof reason);
        ms[round] = 1e-6 * (wall_ns() - start);
        if (status != TFA_OK)
            return fail(l, reason, status);
    }
    qsort(ms, LOADS, sizeof *ms, by_value);
    k->load_ms = ms[LOADS / 2];
    k->text = text_bytes(k->path);
    const tfa_specialised_info info = l->tfa_specialised_describe(k->loaded);
    k->error = info.error;
    if (!k->compiler[0])
        snprintf(k->compiler, sizeof k->compiler, "%s", info.compiler);
    return 0;
}

int kernel_open(struct kernel *k, const struct library *l, const struct robot *r,
                const char *folder, const char *compiler)
{
    const tfa_model_options options = {.base = r->base, .lock_massless_leaves = 1, .snap = r->snap};
    tfa_model *model = NULL;
    *k = (struct kernel){0};
    if (!l->tfa_specialised_load ||
        l->tfa_model_create(r->description, &options, NULL, &model) != TFA_OK)
        return -1;
    const int bad = build(k, l, model, folder, compiler) != 0 || load(k, l, model) != 0;
    l->tfa_model_free(model);
    return bad ? -1 : 0;
}

void kernel_close(struct kernel *k, const struct library *l)
{
    if (k->loaded)
        l->tfa_specialised_free(k->loaded);
    k->loaded = NULL;
}
