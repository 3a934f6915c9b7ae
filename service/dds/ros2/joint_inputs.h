/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Positions, velocities and efforts of a robot's joints, merged from messages that name joints: of
 * several publishers, each with some of the joints. Without clock, thread or I/O.
 *
 * Rules:
 *  - A message with an array that is neither empty nor as long as its names, or with a joint twice,
 *    is refused whole.
 *  - Names that the robot has not are skipped: other robots and grippers share the topic.
 *  - A number that is not finite leaves the former one, which ages; the joint's other values are
 *    taken: publishers fill what hardware lacks with NaN.
 *  - Of each value the newest counts, with the time of its receipt. Stamps of messages do not
 *    count: clocks of hosts differ.
 *  - Values that are missing or older than a limit are refused; nothing is extrapolated.
 *
 * Times are ns of any monotonic clock of this process. Not thread-safe.
 */
#ifndef TFA_SERVICE_DDS_ROS2_JOINT_INPUTS_H
#define TFA_SERVICE_DDS_ROS2_JOINT_INPUTS_H

#include <stdbool.h>
#include <stdint.h>

typedef enum tfa_joint_value {
    TFA_JOINT_POSITION, /* rad or m */
    TFA_JOINT_VELOCITY, /* rad/s or m/s */
    TFA_JOINT_EFFORT,   /* N m or N */
    TFA_JOINT_VALUE_COUNT
} tfa_joint_value;

/** A message: names, and for each value an array as long as they are, or an empty one. */
typedef struct tfa_joint_message {
    const char *const *name;
    uint32_t name_count;
    const double *value[TFA_JOINT_VALUE_COUNT];
    uint32_t value_count[TFA_JOINT_VALUE_COUNT];
} tfa_joint_message;

typedef enum tfa_joint_fault {
    TFA_JOINT_FAULT_LENGTH,     /* an array is neither empty nor as long as the names */
    TFA_JOINT_FAULT_TWICE,      /* a joint is named twice */
    TFA_JOINT_FAULT_UNKNOWN,    /* the robot has no such joint */
    TFA_JOINT_FAULT_NOT_FINITE, /* NaN or infinity */
    TFA_JOINT_FAULT_MISSING,    /* asked for, and never received */
    TFA_JOINT_FAULT_STALE,      /* asked for, and older than the limit */
    TFA_JOINT_FAULT_COUNT
} tfa_joint_fault;

/** What was refused, for diagnostics. */
typedef struct tfa_joint_fault_record {
    /* messages (length, twice), names (unknown), numbers (not finite) or reads (missing, stale) */
    uint64_t count;
    tfa_joint_value value; /* of the last one; of a name that is unknown or twice: no meaning */
    char joint[64];        /* of the last one, cut off if longer */
} tfa_joint_fault_record;

/** What the last merge or read did. */
typedef struct tfa_joint_outcome {
    tfa_joint_fault fault; /**< the last one, unknown names apart; TFA_JOINT_FAULT_COUNT: none */
    uint32_t taken;        /**< joints that a merge named, but those of NaN or infinity alone */
} tfa_joint_outcome;

typedef struct tfa_joint_inputs tfa_joint_inputs;

/**
 * Inputs of a robot with these joints, nothing received yet.
 * @param name  joints of one coordinate each, no name twice; copied
 * @return NULL: out of memory
 */
tfa_joint_inputs *tfa_joint_inputs_create(const char *const *name, uint32_t count);
void tfa_joint_inputs_free(tfa_joint_inputs *inputs);

/**
 * Takes from a message the values of the set `values`, bits 1 << tfa_joint_value; the other arrays
 * are checked for their lengths only: efforts of a JointState that reports measurements are no
 * commands. Cost: one comparison of strings for each name if the message has the order of the last
 * one, else a binary search.
 * @return false: the message was refused whole, tfa_joint_inputs_fault says why
 */
bool tfa_joint_inputs_merge(tfa_joint_inputs *inputs, const tfa_joint_message *message,
                            uint32_t values, int64_t now);

/**
 * Copies one value of all joints, in the order of their creation.
 * @param out      count numbers; unchanged on refusal
 * @param age_max  ns; a value exactly as old is taken
 * @return false: a joint's value is missing or stale, tfa_joint_inputs_fault says which
 */
bool tfa_joint_inputs_read(tfa_joint_inputs *inputs, tfa_joint_value value, int64_t now,
                           int64_t age_max, double *out);

/** True once every joint has got all of these values since it was true before: of several
 *  publishers the last one completes a sample. */
bool tfa_joint_inputs_renewed(tfa_joint_inputs *inputs, uint32_t values);

/** Takes over values and times of joints with the same names, and faults: another model.
 */
void tfa_joint_inputs_adopt(tfa_joint_inputs *inputs, const tfa_joint_inputs *before);

/** Forgets all values; faults stay counted. */
void tfa_joint_inputs_forget(tfa_joint_inputs *inputs);

/** The newest value of joint `joint`: how old it is, ns; -1: none was received. */
int64_t tfa_joint_inputs_age(const tfa_joint_inputs *inputs, uint32_t joint, tfa_joint_value value,
                             int64_t now);

tfa_joint_outcome tfa_joint_inputs_outcome(const tfa_joint_inputs *inputs);

const tfa_joint_fault_record *tfa_joint_inputs_fault(const tfa_joint_inputs *inputs,
                                                     tfa_joint_fault fault);

#endif
