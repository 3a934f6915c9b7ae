/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scan over segments that are computed in SIMD lanes, one number at a time (kernel_table.h).
 */
#ifndef TFA_DYNAMICS_SCAN_SEGMENT_SCAN_H
#define TFA_DYNAMICS_SCAN_SEGMENT_SCAN_H

#include "dynamics/scan/segment_boundary.h"
#include "spatial/num.h"

struct scan;
size_t TFA_V(segment_scan_bytes)(void);
void TFA_V(segment_scan_velocities)(struct tfa_segment_boundary *boundary, int first);
int TFA_V(segment_scan_factor)(struct scan *scan, struct tfa_segment_boundary *boundary,
                               double max_ratio);
void TFA_V(segment_scan_solve)(struct scan *scan, struct tfa_segment_boundary *boundary,
                               const double gravity[3]);
int TFA_V(segment_scan_correct)(struct scan *scan, struct tfa_segment_boundary *boundary);

#endif
