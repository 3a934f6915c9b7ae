/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Building and loading of kernels, see own_kernel.h.
 */
#include "own_kernel.h"

#include <elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "timing.h"

enum { LOADS = 5 };

/* Of children that have ended */
static double children_seconds(void)
{
    struct rusage u;
    getrusage(RUSAGE_CHILDREN, &u);
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
           1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

int kernel_build(struct kernel *k, const tfa_model *model, const char *folder, const char *compiler)
{
    char name[TFA_SPECIALISED_NAME_SIZE], reason[1024];
    const tfa_specialise_options options = {.compiler = compiler};
    tfa_specialise_result result;
    tfa_specialised_name(model, name);
    snprintf(k->path, sizeof k->path, "%s/%s", folder, name);
    if (access(k->path, R_OK) == 0)
        return 0;
    const double before = children_seconds();
    const int status =
        tfa_specialised_build(model, &options, k->path, &result, reason, sizeof reason);
    if (status != TFA_OK) {
        fprintf(stderr, "bench_own: %s: %s\n", tfa_model_name(model),
                reason[0] ? reason : tfa_status_text(status));
        return -1;
    }
    k->compile_s = result.compile_s;
    k->compilers_s = children_seconds() - before;
    snprintf(k->compiler, sizeof k->compiler, "%s", result.compiler);
    return 0;
}

static double milliseconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
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

int kernel_load(struct kernel *k, const tfa_model *model)
{
    double ms[LOADS];
    char reason[512];
    for (int load = 0; load < LOADS; load++) {
        tfa_specialised_free(k->loaded);
        const double start = milliseconds_now();
        const int status = tfa_specialised_load(k->path, model, &k->loaded, reason, sizeof reason);
        ms[load] = milliseconds_now() - start;
        if (status != TFA_OK) {
            fprintf(stderr, "bench_own: %s\n", reason[0] ? reason : tfa_status_text(status));
            return -1;
        }
    }
    qsort(ms, LOADS, sizeof *ms, by_value);
    k->load_ms = ms[LOADS / 2];
    k->text = text_bytes(k->path);
    if (!k->compiler[0])
        snprintf(k->compiler, sizeof k->compiler, "%s",
                 tfa_specialised_describe(k->loaded).compiler);
    return 0;
}

void kernel_close(struct kernel *k)
{
    tfa_specialised_free(k->loaded);
    k->loaded = NULL;
}
