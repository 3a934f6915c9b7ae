/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics as text for Prometheus (exposition format 0.0.4): counters and histograms of each
 * robot, ages of its inputs, messages of the DDS gateway. Seconds and SI units.
 */
#ifndef TFA_SERVICE_METRICS_METRICS_TEXT_H
#define TFA_SERVICE_METRICS_METRICS_TEXT_H

#include <stdio.h>
#include <totalforce/statistics.h>

/** Content-Type of the text over HTTP. */
#define METRICS_CONTENT_TYPE "text/plain; version=0.0.4; charset=utf-8"

/** Writes the snapshot; errors are those of `out`. */
void metrics_write(const tfa_snapshot *snapshot, FILE *out);

#endif
