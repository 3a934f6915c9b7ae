/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The methods of a request, resolved; and what a state reserves memory for.
 */
#ifndef TFA_INTERFACE_RESOLVED_H
#define TFA_INTERFACE_RESOLVED_H

#include <totalforce/dynamics.h>

/* The methods that answer a request, never TFA_METHOD_AUTO: its op, and lambda_inv where that is
 * asked for besides qdd. */
struct tfa_resolved {
    tfa_method method, osim;
};

/* What a state has memory for */
struct tfa_reserved {
    uint32_t methods; /* bits 1u << tfa_method */
    uint32_t tips;    /* of one request */
};

#endif
