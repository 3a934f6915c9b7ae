/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `specialised`: transfers are those of the layout scalar.
 */
#ifndef TFA_LAYOUT_SPECIALISED_TRANSFER_H
#define TFA_LAYOUT_SPECIALISED_TRANSFER_H

#include "layout/scalar/layout_transfer.h"

#endif
