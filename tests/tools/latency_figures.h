/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A scripted load, measured by the loops under test, and its figures computed from sorted lists,
 * within the resolution of a histogram.
 */
#ifndef TFA_TESTS_TOOLS_LATENCY_FIGURES_H
#define TFA_TESTS_TOOLS_LATENCY_FIGURES_H

#include "latency_script.h"

/** Runs a load from the script's present on; every request has an outcome. */
tally *script_measure(script *s, const load_shape *shape);
/** Asserts that the histogram holds these values. */
void assert_times(const tfa_histogram *h, const uint64_t *values, uint64_t count);
/** Asserts that the round trips are the delays of the lines, each once, that their parts have the
 *  script's shares, and that the breakdown has the parts of each percentile. */
void assert_parts(const tally *t, const script_line *lines, uint64_t count);

#endif
