/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Sizes from which one way to an answer is faster than another. They are constants of the library:
 * which method answers depends on the model and the request, never on the machine.
 */
#ifndef TFA_ENGINE_TUNING_H
#define TFA_ENGINE_TUNING_H

/* Bodies of a chain from which TFA_METHOD_AUTO takes the segment scan: faster than aba with AVX2
 * and AVX-512 (totalforce chart -m random -M aba,scan --rhs tau --refine 0, AMD EPYC Zen 4, 2
 * processors, 2026-11-22; the table is in docs/performance.md). */
#define TFA_SCAN_BODIES_MIN 160

/* Bodies of a chain from which the segments or block rows of one state go to several threads:
 * shorter chains are one thread's work. */
#define TFA_PARTS_BODIES_MIN 48

/* Bodies of a robot up to which workspaces reserve memory for batches: 40 to 80 KB a body
 * with vectors of 64 bytes. */
#define TFA_BATCH_BODIES_MAX 128

/* States from which a batch goes in lanes: two of a 7-joint arm take 0.62 to 0.93 times as long as
 * one by one (SSE2, AVX2, AVX-512; bench_batch, the same machine and day). */
#define TFA_BATCH_STATES_MIN 2

/* Time of a full vector of states over that of one state alone: eight lanes, a 7-joint arm
 * (bench_batch, Intel Xeon with AVX-512, 2026-11-22). */
#define TFA_BATCH_TIME_RATIO 1.5

/* Robots that auto gives to the scan have no lanes for batches: a state has the same bits alone and
 * in a batch, however the batch is cut. */
_Static_assert(TFA_SCAN_BODIES_MIN > TFA_BATCH_BODIES_MAX, "a batch would be answered by aba");

#endif
