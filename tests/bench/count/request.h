/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations of one state of a request, for benchmarks in C.
 */
#ifndef TFA_COUNT_REQUEST_H
#define TFA_COUNT_REQUEST_H

#include <totalforce/totalforce.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Multiplications, additions and divisions of state 0; sines are not counted. 0: no answer. */
double count_request(const tfa_model *model, const tfa_request *request);

#ifdef __cplusplus
}
#endif

#endif
