/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Who stands beside whom in the lanes of vector registers: bodies of one state, as many at a time as
 * there are lanes. A packing is a table of steps: walked in order it meets parents before children,
 * in reverse order children before parents.
 */
#ifndef TFA_PLAN_PACKING_H
#define TFA_PLAN_PACKING_H

#include <stdint.h>

struct tfa_packing {
    uint32_t lanes, steps;
    const int32_t *body; /* steps x lanes; -1: nobody. Bodies of one step have the same kind of
                            joint; one with several freedoms stands alone, a floating
                            base in lane 0 */
};

#endif
