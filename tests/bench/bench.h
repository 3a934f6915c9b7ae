/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the benchmarks share.
 */
#ifndef TFA_BENCH_H
#define TFA_BENCH_H

/* Writes a chain of `links` unit rods (radius 0.1 m, 1 kg, 1 m) with random joint axes and twists,
 * the mechanism "random" of the accuracy charts, as URDF. Returns 0 or -1. */
int chain_urdf(const char *path, int links, unsigned seed);

#endif
