/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loading of a kernel: no function of it is called before all of its description is checked.
 */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/dynamics.h>
#include <unistd.h>

#include "interface/kernel_table.h"
#include "model/hash.h"
#include "model/model.h"
#include "model/payload.h"
#include "specialised/specialised_internal.h"

static int check_version(const char *path, const struct tfa_specialised_kernel *k,
                         struct error_text *err)
{
    if (k->abi != TFA_SPECIALISED_ABI)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "'%s' exports version %u, this library wants version %u; build it again",
                      path, k->abi, TFA_SPECIALISED_ABI);
    if (k->request_bytes != sizeof(tfa_request) || k->reply_bytes != sizeof(tfa_reply) ||
        k->model_bytes != sizeof(struct tfa_model))
        return refuse(err, TFA_E_UNSUPPORTED,
                      "'%s' was built from other sources than this library: requests of %u bytes, "
                      "replies of %u, models of %u; build it again",
                      path, k->request_bytes, k->reply_bytes, k->model_bytes);
    return TFA_OK;
}

int specialised_check_table(const char *path, const struct tfa_specialised_kernel *k,
                            const tfa_model *model, struct error_text *err)
{
    const int status = check_version(path, k, err);
    if (status != TFA_OK)
        return status;
    uint8_t hash[32];
    tfa_hash_without_gravity(model, hash);
    if (memcmp(k->model, hash, sizeof k->model) != 0 || k->bodies != model->bodies)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "'%s' has another model in it than its checksum trailer says", path);
    if (!k->isa || strcmp(k->isa, tfa_isa_name()) != 0)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "'%s' is for the instruction set %s, the kernels here run on %s", path,
                      k->isa ? k->isa : "(none)", tfa_isa_name());
    if (!k->compiler || !k->algorithms || !k->supports || !k->solve ||
        !k->lanes != !k->solve_batch || k->lanes > TFA_BATCH_LANES_MAX ||
        !k->lanes_f32 != !k->solve_batch_f32 || !k->lanes_f32 != !k->supports_f32 ||
        k->lanes_f32 > TFA_BATCH_LANES_MAX)
        return refuse(err, TFA_E_UNSUPPORTED, "'%s' is incomplete: a function is missing", path);
    return TFA_OK;
}

static int open_shared_object(const char *path, const tfa_model *model, tfa_specialised *s,
                              struct error_text *err)
{
    char copied[32];
    snprintf(copied, sizeof copied, "/proc/self/fd/%d", s->file);
    s->object = dlopen(copied, RTLD_NOW | RTLD_LOCAL);
    if (!s->object)
        return refuse(err, TFA_E_FILE, "'%s' cannot be loaded: %s", path, dlerror());
    s->kernel = dlsym(s->object, TFA_SPECIALISED_SYMBOL);
    if (!s->kernel)
        return refuse(err, TFA_E_UNSUPPORTED, "'%s' exports no %s", path, TFA_SPECIALISED_SYMBOL);
    const int status = specialised_check_table(path, s->kernel, model, err);
    return status == TFA_OK ? specialised_self_test(path, model, s, err) : status;
}

int tfa_specialised_load(const char *path, const tfa_model *model, tfa_specialised **specialised,
                         char *error_text, size_t size)
{
    struct error_text err = begin_error_text(error_text, size);
    int status = TFA_OK;
    if (!path || !model || !specialised)
        return TFA_E_ARGUMENT;
    *specialised = NULL;
    tfa_specialised *s = calloc(1, sizeof *s);
    if (s)
        s->path = strdup(path);
    if (!s || !s->path) {
        free(s);
        return TFA_E_MEMORY;
    }
    s->file = open_checked_copy(path, model, s->digest, &status, &err);
    if (status == TFA_OK)
        status = open_shared_object(path, model, s, &err);
    if (status == TFA_OK)
        *specialised = s;
    else
        tfa_specialised_free(s);
    return status;
}

struct tfa_host_api specialised_host_api(const tfa_model *model)
{
    return (struct tfa_host_api){model, tfa_body_add_payload_inertia, tfa_payload_size};
}

void tfa_specialised_name(const tfa_model *model, char name[TFA_SPECIALISED_NAME_SIZE])
{
    uint8_t hash[32];
    char text[65];
    tfa_hash_without_gravity(model, hash);
    for (int k = 0; k < 32; k++)
        snprintf(text + 2 * k, 3, "%02x", hash[k]);
    snprintf(name, TFA_SPECIALISED_NAME_SIZE, "%s-%s.so", text, tfa_isa_name());
}

int tfa_specialised_find(const char *directory, const tfa_model *model,
                         tfa_specialised **specialised, char *error_text, size_t size)
{
    char path[4096], name[TFA_SPECIALISED_NAME_SIZE];
    if (size)
        error_text[0] = '\0';
    if (!directory || !model || !specialised)
        return TFA_E_ARGUMENT;
    *specialised = NULL;
    tfa_specialised_name(model, name);
    if (snprintf(path, sizeof path, "%s/%s", directory, name) >= (int)sizeof path)
        return TFA_E_FILE;
    return tfa_specialised_load(path, model, specialised, error_text, size);
}

tfa_specialised_info tfa_specialised_describe(const tfa_specialised *s)
{
    return (tfa_specialised_info){.path = s->path,
                                  .isa = s->kernel->isa,
                                  .compiler = s->kernel->compiler,
                                  .algorithms = s->kernel->algorithms,
                                  .bodies = s->kernel->bodies,
                                  .lanes = s->kernel->lanes,
                                  .lanes_f32 = s->kernel->lanes_f32,
                                  .digest = s->digest,
                                  .error = s->error,
                                  .error_f32 = s->error_f32};
}

void tfa_specialised_free(tfa_specialised *s)
{
    if (!s)
        return;
    if (s->object)
        dlclose(s->object);
    if (s->file >= 0)
        close(s->file);
    free(s->path);
    free(s);
}
