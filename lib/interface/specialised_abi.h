/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exports of a kernel specialised for one robot: the sources of the kernels, compiled once more
 * with that robot's tables as constants (specialised.c). The shared object that holds it is made by
 * another compiler at another time, perhaps from other sources: everything that both sides must
 * agree on is said here and checked before anything is called.
 */
#ifndef TFA_INTERFACE_SPECIALISED_ABI_H
#define TFA_INTERFACE_SPECIALISED_ABI_H

#include <totalforce/dynamics.h>

/* Grows whenever the meaning of anything here changes, or of struct tfa_body in the generated
 * tables. */
#define TFA_SPECIALISED_ABI 13u

/* The symbol */
#define TFA_SPECIALISED_SYMBOL "tfa_specialised_kernel"

/* Freedoms of robots on a fixed base whose kernels have code for derivatives: one state takes 0.72
 * to 0.86 of the time, batches 0.81 to 0.93 (bench_suite --kernels, ur5, arm7, Allegro hand; EPYC
 * VM, AVX2, clang 14, 2026-11-28). Of other robots pairs of freedoms and the columns of M^-1 take
 * most of it, which are in lanes anyway. */
#define TFA_SPECIALISED_DERIVATIVES_MAX 18

struct tfa_body;
struct tfa_frame;

/* Functions of the library that a kernel calls */
struct tfa_host_api {
    const tfa_model *model;
    /* As tfa_body_add_payload_inertia */
    void (*add_payload)(struct tfa_body *body, const struct tfa_frame *frame,
                        const double numbers[10]);
    /* As tfa_payload_size */
    void (*payload_size)(const struct tfa_model *model, uint32_t count, const double *numbers,
                         double size[2]);
};

/* For a request that a kernel has no code for, in place of states that have an answer */
#define TFA_SPECIALISED_NO_CODE (UINT32_C(1) << 31)

struct tfa_specialised_kernel {
    uint32_t abi; /* TFA_SPECIALISED_ABI; the fields up to `model` never move */
    uint32_t request_bytes, reply_bytes,
        model_bytes;        /* of struct tfa_request, tfa_reply, tfa_model */
    uint8_t model[32];      /* tfa_hash_without_gravity of the model whose tables are in it */
    const char *isa;        /* as in tfa_kernel.isa */
    const char *compiler;   /* with its version */
    const char *algorithms; /* by which requests are answered: "forward crba, ..." */
    uint32_t bodies;
    uint32_t lanes, lanes_f32; /* states that a batch takes at a time; 0: there is none */
    /* Is this checked request, by aba, rnea, propagation or crba, one that the kernel answers? All
     * states of it are, or none. */
    int (*supports)(const struct tfa_host_api *host, const tfa_request *request);
    /* State k of such a request into the reply's arrays. Returns 1, or 0 where the answer is not
     * finite or the sentinel trips: nothing that was written counts then. No allocation, no lock,
     * no system call. */
    uint32_t (*solve)(const struct tfa_host_api *host, const tfa_request *request, uint32_t k,
                      tfa_reply *reply);
    /* States k .. k + count - 1, at most `lanes`: the same bits as `solve`. Returns a bit for each
     * state, the lowest for k; bits from `count` on mean nothing. */
    uint32_t (*solve_batch)(const struct tfa_host_api *host, const tfa_request *request, uint32_t k,
                            uint32_t count, tfa_reply *reply);
    /* The same in single precision, at most `lanes_f32`: also for one state. */
    int (*supports_f32)(const struct tfa_host_api *host, const tfa_request *request);
    uint32_t (*solve_batch_f32)(const struct tfa_host_api *host, const tfa_request *request,
                                uint32_t k, uint32_t count, tfa_reply *reply);
};

#endif
