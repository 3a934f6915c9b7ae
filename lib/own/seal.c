/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The seal behind a shared object: all of it is there, and it is for this library and this model. It
 * is no signature: who may write the file can seal it (trust.c says who may).
 */
#include <sha256.h>
#include <stddef.h>
#include <string.h>

#include "model/hash.h"
#include "model/model.h"
#include "own/own.h"

static void digest(const void *bytes, size_t length, const struct own_seal *seal, uint8_t out[32])
{
    SHA2_CTX c;
    SHA256Init(&c);
    SHA256Update(&c, bytes, length);
    SHA256Update(&c, (const uint8_t *)seal, offsetof(struct own_seal, sha256));
    SHA256Final(out, &c);
}

void own_seal_make(const void *bytes, size_t length, const uint8_t model[32], struct own_seal *seal)
{
    *seal = (struct own_seal){.magic = TFA_OWN_MAGIC, .abi = TFA_OWN_ABI, .length = length};
    memcpy(seal->model, model, sizeof seal->model);
    digest(bytes, length, seal, seal->sha256);
}

int own_seal_check(const char *path, const void *bytes, size_t size, const tfa_model *model,
                   struct own_reason *why)
{
    struct own_seal seal = {.length = 0};
    uint8_t sha256[32], hash[32];
    if (size > sizeof seal)
        memcpy(&seal, (const char *)bytes + size - sizeof seal, sizeof seal);
    if (memcmp(seal.magic, TFA_OWN_MAGIC, sizeof seal.magic) != 0 ||
        seal.length != size - sizeof seal)
        return own_refuse(
            why, TFA_E_PARSE,
            "'%s' is truncated or no kernel: its seal is not where it belongs; build it "
            "again",
            path);
    digest(bytes, size - sizeof seal, &seal, sha256);
    if (memcmp(sha256, seal.sha256, sizeof sha256) != 0)
        return own_refuse(why, TFA_E_PARSE, "'%s' was changed after it was sealed; build it again",
                          path);
    if (seal.abi != TFA_OWN_ABI)
        return own_refuse(
            why, TFA_E_UNSUPPORTED,
            "'%s' is of version %u of what kernels export, this library of version %u; "
            "build it again",
            path, seal.abi, TFA_OWN_ABI);
    tfa_hash_without_gravity(model, hash);
    if (memcmp(seal.model, hash, sizeof seal.model) != 0)
        return own_refuse(why, TFA_E_UNSUPPORTED,
                          "'%s' is for another model, %02x%02x%02x%02x..., not for %.8s...", path,
                          seal.model[0], seal.model[1], seal.model[2], seal.model[3],
                          model->hash_text);
    return TFA_OK;
}
