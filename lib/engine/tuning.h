/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tuned sizes. They are constants of the library: the method that answers depends on model and
 * request, never on the machine (docs/tuning.md).
 */
#ifndef TFA_ENGINE_TUNING_H
#define TFA_ENGINE_TUNING_H

/* Chain length from which TFA_METHOD_AUTO takes the segment scan: faster than aba with AVX2 and
 * AVX-512 (docs/tuning.md). */
#define TFA_SCAN_BODIES_MIN 160

/* Chain length from which several threads share the segments or block rows of a state. */
#define TFA_PARTS_BODIES_MIN 48

/* Largest robot with memory for batches: 40 to 80 KB a body with vectors of 64 bytes. */
#define TFA_BATCH_BODIES_MAX 128

/* Smallest batch in lanes: two states of a 7-joint arm take 0.62 to 0.93 of the time
 * of one by one (SSE2, AVX2, AVX-512). */
#define TFA_BATCH_STATES_MIN 2

/* Time of a full vector of states over that of one state: eight lanes, 7-joint
 * arm. */
#define TFA_BATCH_TIME_RATIO 1.5

/* Robots that auto gives to the scan have no lanes for batches: a state has the same bits alone and
 * in a batch, however the batch is cut. */
_Static_assert(TFA_SCAN_BODIES_MIN > TFA_BATCH_BODIES_MAX, "a batch would be answered by aba");

#endif
