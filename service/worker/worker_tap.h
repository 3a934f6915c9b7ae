/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Writes answered requests into the tap of a robot: no allocation, no lock, no system call.
 */
#ifndef TFA_SERVICE_WORKER_WORKER_TAP_H
#define TFA_SERVICE_WORKER_WORKER_TAP_H

#include "ipc/tap.h"

/** An answered request. Either both parts are in wire form already, or neither. */
typedef struct tfa_tap_entry {
    const tfa_wire_shape *shape; /**< with the client's max_batch and max_tips */
    const void *request_copy;    /**< private copy of a slot; NULL: `request` is encoded */
    const void *reply_slot;      /**< the reply in it; its line is not read */
    const tfa_request *request;  /**< its estimate policy is settled, if it got so far */
    const tfa_reply *reply;
    uint64_t want;         /**< of reply_slot: its blocks; in wire form only */
    tfa_estimate estimate; /**< as sent */
    uint64_t id, t_sent, t_received, t_start, t_done;
} tfa_tap_entry;

/** Writes a record, or drops and counts it. */
void tfa_tap_put(tfa_tap *tap, const tfa_tap_entry *entry);

#endif
