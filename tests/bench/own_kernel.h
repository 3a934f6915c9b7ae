/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A kernel of a robot's own, built or found, loaded, and what that took.
 */
#ifndef TFA_BENCH_OWN_KERNEL_H
#define TFA_BENCH_OWN_KERNEL_H

#include <totalforce/totalforce.h>

struct kernel {
    const char *name; /* "own" */
    char path[4352];
    double compile_s; /* wall clock; 0: it was there */
    double
        compilers_s; /* processor time of all compilers: what a load beside them does not change */
    double load_ms;  /* median of several loads, test included; 0: not loaded */
    size_t text;     /* bytes of its segments that are executed */
    char compiler[256];
    tfa_specialised *loaded;
};

/* Into `folder`, unless it is there. @return 0, or -1 after a message */
int kernel_build(struct kernel *k, const tfa_model *model, const char *folder,
                 const char *compiler);
/* @return 0, or -1 after a message */
int kernel_load(struct kernel *k, const tfa_model *model);
void kernel_close(struct kernel *k);

#endif
