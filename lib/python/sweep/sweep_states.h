/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * States of a sweep as records of doubles, and how a record is drawn: by a counter-based generator,
 * state k of a seed is a function of (seed, k) alone.
 */
#ifndef PYTHON_SWEEP_STATES_H
#define PYTHON_SWEEP_STATES_H

#include <stdint.h>
#include <totalforce/dynamics.h>
#include <totalforce/limits.h>

/** Inputs of a state in the order of a record; those that the op does not read are absent. */
typedef enum state_field {
    STATE_BASE_POSE,  /**< x y z, quaternion x y z w */
    STATE_BASE_TWIST, /**< 6 */
    STATE_BASE_FORCE, /**< 6: base_wrench; base_acceleration for inverse dynamics */
    STATE_Q,
    STATE_V,
    STATE_FORCE, /**< tau; qdd for inverse dynamics */
    STATE_FIELDS
} state_field;

/** Half widths of the ranges that no file states */
typedef struct state_ranges {
    double velocity, force, acceleration;
} state_ranges;

/** Layout of a record and the ranges of its numbers. Release with state_record_free. */
typedef struct state_record {
    uint32_t width; /**< doubles of a record */
    uint32_t at[STATE_FIELDS], size[STATE_FIELDS];
    uint64_t *counter;                      /**< width: offset of the generator */
    double *low, *span;                     /**< width */
    uint32_t *quaternion, quaternion_count; /**< places of quaternions */
} state_record;

/**
 * Lays out the records of an op.
 * @param limits  of each public joint; NULL: none
 * @return TFA_OK, TFA_E_MEMORY
 */
int state_record_make(state_record *record, const tfa_model *model, tfa_op op,
                      const tfa_joint_limits *limits, const state_ranges *ranges);
void state_record_free(state_record *record);

/** Draws states first .. first + count - 1 of a seed: count x width numbers. The same bits on every
 *  machine. */
void state_record_draw(const state_record *record, uint64_t seed, uint64_t first, uint32_t count,
                       double *out);

/** Copies the fields of `count` records to arrays of their own; arrays of absent ones are not
 *  used. */
void state_record_scatter(const state_record *record, const double *records, uint32_t count,
                          double *const fields[STATE_FIELDS]);

#endif
