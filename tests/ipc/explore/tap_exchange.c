/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A worker that gets a tap and loses it: tfa_worker_cycle of service/worker/turn.c;
 * recordings_begin, end_recording and recordings_tick of service/control/recordings.c; commit of
 * service/control/reload.c.
 */
#include "tap_parts.h"

static _Atomic(tfa_tap *) tap_of_robot;
static tfa_robot_taps taps = {.taps = &tap_of_robot};
static _Atomic uint64_t offered, phase; /* A12, R12; A10, R10 */

/* ---- the worker ---- */

static uint64_t accept_offer(void)
{
    return atomic_load_explicit(&offered, memory_order_acquire); /* R12 */
}

static void record_request(tfa_tap *tap, uint64_t solvers)
{
    if (tap_has_error(WORKER_TAKES_IN_REQUEST))
        tfa_robot_taps_take(&taps);
    if (!tap)
        return;
    explorer_check(solvers == 0, "an answer of other solvers was recorded");
    tap_put(&tap_producers[0], tap);
}

static void end_worker(void)
{
    atomic_store_explicit(&phase, 1, memory_order_release); /* A10 */
}

void tap_worker_body(void *argument)
{
    tfa_tap *kept = NULL;
    (void)argument;
    for (uint32_t k = 0; k < tap_records(); k++) {
        tfa_tap *early =
            tap_has_error(WORKER_GETS_TAP_BEFORE_OFFER) ? tfa_robot_taps_get(&taps, 0) : NULL;
        const uint64_t solvers = tap_under_test.reload ? accept_offer() : 0;
        if (!tap_has_error(WORKER_TAKES_IN_REQUEST))
            tfa_robot_taps_take(&taps);
        tfa_tap *tap = early ? early : kept ? kept : tfa_robot_taps_get(&taps, 0);
        if (tap_has_error(WORKER_KEEPS_TAP))
            kept = tap;
        record_request(tap, solvers);
    }
    end_worker();
}

/* ---- the control thread ---- */

static void offer_solvers(void)
{
    atomic_store_explicit(&offered, 1, memory_order_release); /* A12 */
}

static void give_tap(uint32_t ring)
{
    tap_producer *p = &tap_producers[0];
    if (tap_has_error(CONTROL_FILLS_AFTER_SET))
        tfa_robot_taps_set(&taps, 0, &p->tap);
    explorer_data_write(&p->memory, ring + 1);
    if (ring)
        tap_open(p, ring);
    if (!tap_has_error(CONTROL_FILLS_AFTER_SET))
        tfa_robot_taps_set(&taps, 0, &p->tap);
}

static void take_tap_away(void)
{
    if (!tap_has_error(CONTROL_ASKS_FIRST)) {
        tfa_robot_taps_set(&taps, 0, NULL);
        return;
    }
    atomic_fetch_add_explicit(&taps.asked, 1, memory_order_release);
    atomic_store_explicit(&tap_of_robot, NULL, memory_order_release);
}

static bool worker_has_ended(void)
{
    return atomic_load_explicit(&phase, memory_order_acquire) != 0; /* R10 */
}

/* One look at what the worker has taken stands for many: it may read each store, later ones too. */
static void free_tap(void)
{
    if (!tap_has_error(CONTROL_FREES_AT_ONCE) && !tfa_robot_taps_are_taken(&taps))
        while (!worker_has_ended())
            explorer_spin();
    explorer_data_write(&tap_producers[0].memory, 0);
}

void tap_control_body(void *argument)
{
    (void)argument;
    give_tap(0);
    if (tap_under_test.reload && tap_has_error(CONTROL_OFFERS_FIRST))
        offer_solvers();
    take_tap_away();
    if (tap_under_test.reload && !tap_has_error(CONTROL_OFFERS_FIRST))
        offer_solvers();
    free_tap();
    if (tap_under_test.again)
        give_tap(1);
}
