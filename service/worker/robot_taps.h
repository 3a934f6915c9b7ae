/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * How a worker that runs gets the taps of its robots (ipc/tap.h) and loses them.
 *
 *   tap    A14 store release, another thread <-> R14 worker, load acquire, for each request: what
 *          the tap points to is visible
 *   asked  A15 release, another thread       <-> R15 worker, load acquire, in each cycle: R14 finds
 *          no tap from before A14
 *   taken  A16 store release, worker         <-> R16 another thread, load acquire: the worker has
 *          done with every tap from before A14, whose memory may be freed
 *
 * Each side also loads its own word, relaxed. Both threads only store or load: neither waits.
 */
#ifndef TFA_SERVICE_WORKER_ROBOT_TAPS_H
#define TFA_SERVICE_WORKER_ROBOT_TAPS_H

#include "ipc/tap.h"

typedef struct tfa_robot_taps {
    _Atomic(tfa_tap *) *taps; /* by robot: A14, R14 */
    _Atomic uint64_t asked;   /* A15, R15 */
    _Atomic uint64_t taken;   /* A16, R16 */
} tfa_robot_taps;

/* ---- the worker's thread ---- */

/* Tap of a robot, for one request; NULL: none */
static inline tfa_tap *tfa_robot_taps_get(const tfa_robot_taps *t, uint32_t robot)
{
    return atomic_load_explicit(&t->taps[robot], memory_order_acquire); /* R14 */
}

/* No request is being answered: previous taps are not used any more. */
static inline void tfa_robot_taps_take(tfa_robot_taps *t)
{
    const uint64_t asked = atomic_load_explicit(&t->asked, memory_order_acquire); /* R15 */
    if (asked != atomic_load_explicit(&t->taken, memory_order_relaxed))
        atomic_store_explicit(&t->taken, asked, memory_order_release); /* A16 */
}

/* ---- one other thread at a time ---- */

/* From now on this tap; NULL: none */
static inline void tfa_robot_taps_set(tfa_robot_taps *t, uint32_t robot, tfa_tap *tap)
{
    atomic_store_explicit(&t->taps[robot], tap, memory_order_release); /* A14 */
    atomic_fetch_add_explicit(&t->asked, 1, memory_order_release);     /* A15 */
}

/* The worker will not touch a tap again that tfa_robot_taps_set took away. */
static inline bool tfa_robot_taps_are_taken(const tfa_robot_taps *t)
{
    return atomic_load_explicit(&t->taken, memory_order_acquire) == /* R16 */
           atomic_load_explicit(&t->asked, memory_order_relaxed);
}

#endif
