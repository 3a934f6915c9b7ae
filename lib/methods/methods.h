/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the files of this folder share.
 */
#ifndef TFA_METHODS_METHODS_H
#define TFA_METHODS_METHODS_H

#include <totalforce/dynamics.h>

/* Rank and extreme eigenvalues of a symmetric n x n matrix (n <= 6 TFA_MAX_TIPS). `scratch`
 * holds n x n doubles. */
tfa_spectrum tfa_spectrum_of(const double *matrix, uint32_t n, double *scratch);

/* tfa_compute for a request that tfa_request_check passed; the reply is as that left it. */
int tfa_compute_checked(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply);

#endif
