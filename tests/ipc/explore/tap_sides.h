/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Producers of a tap, its recorder, and the control thread that gives a tap and takes it away, as
 * programs under test: the calls of service/worker/worker_tap.c, service/worker/turn.c,
 * service/control/recordings.c and tools/record, in their order.
 */
#ifndef TFA_EXPLORER_TAP_SIDES_H
#define TFA_EXPLORER_TAP_SIDES_H

#include <stdbool.h>
#include <stdint.h>

#define TAP_RECORDS_MAX 8

/** Errors of the code and its callers, each of which must be found */
typedef enum tap_error {
    TAP_ERROR_NONE,
    PRODUCER_IGNORES_FULL,
    PRODUCER_TRUSTS_POSITION,
    PRODUCER_IGNORES_END,
    PRODUCER_WRITES_NO_FILLER,
    PRODUCER_FILLS_WITHOUT_ROOM,
    PRODUCER_BEGINS_LAP_WITHOUT_ROOM,
    PRODUCER_COUNTS_NO_DROP,
    PRODUCER_COUNTS_DROP_LATE,
    PRODUCER_WAITS,
    PRODUCER_WRITES_AFTER_PUBLISH,
    RECORDER_IGNORES_WRITTEN,
    RECORDER_TAKES_FILLER,
    RECORDER_READS_AFTER_RELEASE,
    RECORDER_COUNTS_BEFORE_LOOK,
    RECORDER_NO_LAST_LOOK,
    WORKER_TAKES_IN_REQUEST,
    WORKER_KEEPS_TAP,
    WORKER_GETS_TAP_BEFORE_OFFER,
    CONTROL_ASKS_FIRST,
    CONTROL_FILLS_AFTER_SET,
    CONTROL_FREES_AT_ONCE,
    CONTROL_OFFERS_FIRST,
    TAP_ERRORS
} tap_error;

typedef struct tap_case {
    const char *name;
    uint32_t ring_bytes;            /**< of a ring: a power of two up to 128 */
    uint8_t bytes[TAP_RECORDS_MAX]; /**< of the records of each producer; 0 ends them */
    uint32_t looks;                 /**< of the recorder, before it waits for the hang-up */
    uint32_t producers;             /**< 1 or 2 */
    bool killed; /**< the recorder is killed at its step `tap_dies_at`: each is explored */
    bool lies;   /**< the recorder writes a position of the future before it reads */
    bool leaves; /**< the tap is taken away from a worker that runs, and freed */
    bool again;  /**< then another one is given, with a recorder of its own */
    bool reload; /**< other solvers are offered when it was taken away */
} tap_case;

/** The case and the error of the next exploration; the step of the recorder at which it is killed,
 *  0: none, and whether some execution came so far */
extern tap_case tap_under_test;
extern tap_error tap_error_made;
extern uint32_t tap_dies_at;
extern bool tap_died;

void tap_reset(void *argument);
void tap_finish(void *argument);
void tap_producer_body(void *argument);
void tap_second_producer_body(void *argument);
void tap_recorder_body(void *argument);
void tap_second_recorder_body(void *argument);
void tap_worker_body(void *argument);
void tap_control_body(void *argument);
const char *tap_error_text(tap_error error);

#endif
