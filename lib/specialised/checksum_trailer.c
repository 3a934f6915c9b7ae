/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checksum trailer of a shared object: the file is complete, and built for this library and this
 * model. It is no signature: a user who can write the file can write its checksum (see
 * ownership_check.c).
 */
#include <sha256.h>
#include <stddef.h>
#include <string.h>

#include "model/hash.h"
#include "model/model.h"
#include "specialised/specialised_internal.h"

static void digest(const void *bytes, size_t length, const struct checksum_trailer *trailer,
                   uint8_t out[32])
{
    SHA2_CTX c;
    SHA256Init(&c);
    SHA256Update(&c, bytes, length);
    SHA256Update(&c, (const uint8_t *)trailer, offsetof(struct checksum_trailer, sha256));
    SHA256Final(out, &c);
}

void checksum_trailer_make(const void *bytes, size_t length, const uint8_t model[32],
                           struct checksum_trailer *trailer)
{
    *trailer = (struct checksum_trailer){
        .magic = TFA_SPECIALISED_MAGIC, .abi = TFA_SPECIALISED_ABI, .length = length};
    memcpy(trailer->model, model, sizeof trailer->model);
    digest(bytes, length, trailer, trailer->sha256);
}

int checksum_trailer_check(const char *path, const void *bytes, size_t size, const tfa_model *model,
                           struct error_text *err)
{
    struct checksum_trailer trailer = {.length = 0};
    uint8_t sha256[32], hash[32];
    if (size > sizeof trailer)
        memcpy(&trailer, (const char *)bytes + size - sizeof trailer, sizeof trailer);
    if (memcmp(trailer.magic, TFA_SPECIALISED_MAGIC, sizeof trailer.magic) != 0 ||
        trailer.length != size - sizeof trailer)
        return refuse(
            err, TFA_E_PARSE,
            "'%s' is truncated or no kernel: its checksum trailer is missing; build it again",
            path);
    digest(bytes, size - sizeof trailer, &trailer, sha256);
    if (memcmp(sha256, trailer.sha256, sizeof sha256) != 0)
        return refuse(err, TFA_E_PARSE, "'%s' was changed after it was built; build it again",
                      path);
    if (trailer.abi != TFA_SPECIALISED_ABI)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "'%s' is of version %u of what kernels export, this library of "
                      "version %u; build it again",
                      path, trailer.abi, TFA_SPECIALISED_ABI);
    tfa_hash_without_gravity(model, hash);
    if (memcmp(trailer.model, hash, sizeof trailer.model) != 0)
        return refuse(err, TFA_E_UNSUPPORTED,
                      "'%s' is for another model, %02x%02x%02x%02x..., not for %.8s...", path,
                      trailer.model[0], trailer.model[1], trailer.model[2], trailer.model[3],
                      model->hash_text);
    return TFA_OK;
}
