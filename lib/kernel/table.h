/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a compiled variant of the kernels offers to the rest of the library, and to another variant
 * whose answers it refines.
 */
#ifndef TFA_KERNEL_TABLE_H
#define TFA_KERNEL_TABLE_H

#include <totalforce/dynamics.h>

struct state;
struct tfa_wider;

struct tfa_kernel {
    const char *isa;
    tfa_precision precision;
    int (*supported)(void); /* every CPU feature that the flags allow is present */
    size_t (*size)(const tfa_model *model);
    struct state *(*init)(const tfa_model *model, void *memory);
    /* One state of a checked request; fills answer, and field/index of the reply on failure. */
    int (*answer)(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply,
                  tfa_answer *answer);

    /* From now on refinement in s has its residual from `wider`, which outlives s. */
    void (*widen)(struct state *s, const struct tfa_wider *wider);
    /* And what the kernel does as the wider one of another: reads state k of a checked request; */
    void (*load)(struct state *s, const tfa_request *request, uint32_t k);
    /* x = dx (fresh) or x += dx, as follows for followers; */
    void (*add)(struct state *s, const double *dx, int fresh);
    /* residual = tau - RNEA(x), shaken (rnea_shaken) or not. Returns |x|; */
    double (*residual)(struct state *s, double *residual, int shaken);
    /* writes x to the reply. Returns 1 when all of it is finite. */
    int (*unload)(const struct state *s, uint32_t k, tfa_reply *reply);
};

/* Another kernel with a state of the same model: where refinement has its residual from, in wider
 * arithmetic, and where the solution is summed up. */
struct tfa_wider {
    const struct tfa_kernel *kernel;
    struct state *state;
};

/* Several states at a time: forward dynamics by aba. */
struct tfa_lanes {
    const char *isa;
    uint32_t lanes;
    int (*supported)(void);
    size_t (*size)(const tfa_model *model);
    struct state *(*init)(const tfa_model *model, void *memory);
    /* States k .. k + count - 1 (at most `lanes`) of a checked request, which changes nothing about
     * the robot and has no mimics. Returns whether all answers are finite. */
    int (*answer)(struct state *s, const tfa_request *request, uint32_t k, uint32_t count,
                  tfa_reply *reply);
};

/* Best variant of that precision which this processor supports, or the one that TFA_ISA in the
 * environment names. NULL when there is none. */
const struct tfa_kernel *tfa_kernel_select(tfa_precision precision);
const struct tfa_lanes *tfa_lanes_select(void);

#endif
