/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Numbers rounded as a computation in double rounds them: how far an exact answer moves by it is
 * the accuracy that the data allow.
 */
#ifndef TFA_MECHANISM_MOVE_H
#define TFA_MECHANISM_MOVE_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/description.h>

/** Each number goes to its upper or lower neighbour or stays, at random; 0 stays 0.
 * @param random  state of mechanism_random_bits */
void move_numbers(uint64_t *random, double *values, size_t count);

/** The same of all masses, inertias, places and rotations of a robot, whose rotations lose the low
 * parts behind double, and of armatures and mimic rules. */
void move_description(uint64_t *random, tfa_description *description);

#endif
