/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Percentile distribution of a histogram in HdrHistogram's text format (.hgrm).
 */
#ifndef TOOLS_LATENCY_REPORT_HGRM_H
#define TOOLS_LATENCY_REPORT_HGRM_H

#include <stdio.h>
#include <totalforce/histogram.h>

/** Writes the distribution, which HdrHistogram's plotters read; values are divided by `scale`. */
void hgrm_write(const tfa_histogram *h, FILE *out, double scale);

#endif
