/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot with inputs at a fixed seed, buffers for replies, and workspaces of each precision.
 */
#ifndef TFA_TOOLS_ANSWER_ROBOT_H
#define TFA_TOOLS_ANSWER_ROBOT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/totalforce.h>

enum { BATCH_MAX = 19, TIPS_MAX = 4, WRENCHES = 2, LOCKED = 2, PRECISIONS = 5, POOL_THREADS = 2 };

struct precision {
    const char *name;
    tfa_precision factors;
    tfa_residual residual;
    int quad; /* some of it in quadruple precision */
};
extern const struct precision precisions[PRECISIONS];

/* Arrays of numbers: of the request, filled at random within +-scale, and of the reply. */
enum { Q, V, TAU, QDD, POSE, TWIST, BASE_WRENCH, BASE_ACCELERATION, WRENCH, INPUTS };
enum { OUT_QDD, OUT_TAU, OUT_BASE_A, OUT_BASE_W, OUT_LAMBDA, OUT_POSES, OUT_MASS, OUTPUTS };

struct robot {
    char name[64];
    const char *base;
    tfa_model *model;
    size_t bodies;
    uint32_t frames[4], locked[LOCKED];
    size_t in_size[INPUTS], out_size[OUTPUTS]; /* doubles of a state */
    double *in[INPUTS], *out[OUTPUTS];
    tfa_spectrum spectrum[BATCH_MAX];
    tfa_answer answers[BATCH_MAX];
    tfa_workspace *workspaces[PRECISIONS];
    tfa_batch_pool *pools[PRECISIONS];
};

/** Prints the error and ends the program. */
_Noreturn void stop(const char *what, const char *name, const char *why);

/** The finalizer of splitmix64: every bit of x changes every bit of the result. */
uint64_t mix_bits(uint64_t x);

/** Reads a URDF; with_policies: mimic joints projected, damping and rotor inertia used.
 * @return status of tfa_model_load; only name and base are set where it is not TFA_OK */
int robot_load(struct robot *r, const char *path, tfa_base base, int with_policies);
void robot_free(struct robot *r);

/** Are there workspaces of this precision? Quadruple precision: up to 64 bodies. */
int robot_has_precision(const struct robot *r, size_t precision);

#endif
