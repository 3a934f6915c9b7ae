/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mapped statistics.
 */
#ifndef TFA_CLIENT_CLIENT_STATISTICS_H
#define TFA_CLIENT_CLIENT_STATISTICS_H

#include "ipc/statistics_layout.h"

struct tfa_statistics {
    void *memory;
    size_t size;
    uint32_t workers, robots, clients; /* checked copies of the header's */
    tfa_statistics_view view;          /* of read-only memory */
};

#endif
