/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One mistake in a sound robot for every row, with the message that it must bring.
 */
#ifndef TESTS_MODEL_MISTAKES_H
#define TESTS_MODEL_MISTAKES_H

#include "hand.h"

/* Of the arm: base -shoulder- upper -elbow- lower -flange(fixed)- tool */
enum { BASE, UPPER, LOWER, TOOL };
enum { SHOULDER, ELBOW, FLANGE };

struct mistake {
    const char *name;
    void (*spoil)(hand *h);
    tfa_model_options options;
    int status;
    uint32_t line;
    size_t errors;
    const char *code, *text; /* of the first error */
};

extern const struct mistake mistakes[];
extern const size_t mistake_count;

/** Adds link 4, "pointer", without mass on joint 3, "swing". */
void massless_leaf(hand *h);

/** Leaves link "base" and takes its mass away. */
void massless_base(hand *h);

#endif
