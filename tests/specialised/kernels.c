/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Each kernel is seen through a table of ours, which counts. See kernels.h.
 */
#include "kernels.h"

#include "model/model.h"
#include "specialised/specialised_internal.h"
#include "test.h"

#include <unistd.h>

#define MOST 64 /* kernels of a program */
#define SKIPPED 77

struct served {
    uint8_t model[32]; /* hash */
    char name[96];
    tfa_specialised *loaded;
    struct tfa_specialised_kernel table; /* what workspaces see */
    tfa_specialised shown;
    _Atomic uint64_t states; /* threads of a pool count, too */
};

static struct served served[MOST];
static uint32_t count;

static struct served *of(const tfa_model *model)
{
    for (uint32_t k = 0; k < count; k++)
        if (memcmp(served[k].model, model->hash, sizeof served[k].model) == 0)
            return &served[k];
    return NULL;
}

/* ---- what counts ---- */

static void count_states(struct served *s, uint32_t done, uint32_t some)
{
    for (uint32_t l = 0; l < some; l++)
        s->states += done >> l & 1;
}

static uint32_t solve(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                      tfa_reply *reply)
{
    struct served *s = of(host->model);
    const uint32_t done = s->loaded->kernel->solve(host, r, k, reply);
    count_states(s, done, 1);
    return done;
}

static uint32_t solve_batch(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                            uint32_t some, tfa_reply *reply)
{
    struct served *s = of(host->model);
    const uint32_t done = s->loaded->kernel->solve_batch(host, r, k, some, reply);
    count_states(s, done, some);
    return done;
}

static uint32_t solve_batch_f32(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                                uint32_t some, tfa_reply *reply)
{
    struct served *s = of(host->model);
    const uint32_t done = s->loaded->kernel->solve_batch_f32(host, r, k, some, reply);
    count_states(s, done, some);
    return done;
}

uint64_t kernels_answered(void)
{
    uint64_t states = 0;
    for (uint32_t k = 0; k < count; k++)
        states += served[k].states;
    return states;
}

/* ---- the folder ---- */

const tfa_specialised *kernels_find(const tfa_model *model)
{
    const char *folder = getenv("TFA_TEST_KERNELS");
    char error_text[1024];
    struct served *s = of(model);
    if (s || !folder)
        return s ? &s->shown : NULL;
    assert_true(count < MOST);
    s = &served[count];
    const int status =
        tfa_specialised_find(folder, model, &s->loaded, error_text, sizeof error_text);
    if (status == TFA_E_FILE)
        return NULL;
    if (status != TFA_OK)
        fail_msg("%s: %s", tfa_model_name(model), error_text);
    snprintf(s->name, sizeof s->name, "%.60s, %s base", tfa_model_name(model),
             tfa_model_base_freedoms(model) ? "floating" : "fixed");
    memcpy(s->model, model->hash, sizeof s->model);
    s->table = *s->loaded->kernel;
    s->table.solve = solve;
    s->table.solve_batch = s->table.solve_batch ? solve_batch : NULL;
    s->table.solve_batch_f32 = s->table.solve_batch_f32 ? solve_batch_f32 : NULL;
    s->shown = *s->loaded;
    s->shown.kernel = &s->table;
    count++;
    return &s->shown;
}

int kernels_skip(const tfa_model *model)
{
    return getenv("TFA_TEST_KERNELS") && !kernels_find(model);
}

/* ---- the program's end ---- */

static void finish(int status, void *unused)
{
    (void)unused;
    if (status == SKIPPED)
        return; /* it asked nothing at all, and says why */
    const uint64_t states = kernels_answered();
    for (uint32_t k = 0; k < count; k++) {
        printf("kernel of %s: %llu states\n", served[k].name, (unsigned long long)served[k].states);
        tfa_specialised_free(served[k].loaded);
    }
    if (!states)
        printf("FAILED: no state was answered by a kernel in TFA_TEST_KERNELS\n");
    fflush(stdout);
    if (!states)
        _exit(EXIT_FAILURE);
}

static __attribute__((constructor)) void begin(void)
{
    const char *folder = getenv("TFA_TEST_KERNELS");
    if (!folder)
        return;
    if (access(folder, F_OK) != 0) {
        printf("SKIP: there are no kernels at %s: test_make_kernels says why\n", folder);
        fflush(stdout);
        _exit(SKIPPED);
    }
    if (on_exit(finish, NULL) != 0)
        abort();
}
