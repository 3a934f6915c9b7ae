/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Daemons whose lease is long, so that none is judged dead that gets no processor, lead at once.
 */
#ifndef TESTS_DDS_HERALD_H
#define TESTS_DDS_HERALD_H

#include "dds_client/dds_client.h"
#include "support/scoped.h"

#include <stdint.h>

/** A daemon in `domain` that has just started, or begins anew, and serves `robot`, does not listen
 * for a lease: it hears a leader, which says good-bye. Returns when it leads. */
void dds_herald(uint32_t domain, const char *robot);

/** The section "dds" of a configuration. */
const char *dds_yaml(uint32_t domain, int lease_ms);

/** A client of the robot; it must come about. */
tfa_dds_client *dds_connect(uint32_t domain, const char *robot);
SCOPED_POINTER(scoped_dds_client_close, tfa_dds_client, tfa_dds_client_close)
#define SCOPED_DDS_CLIENT SCOPED(scoped_dds_client_close) tfa_dds_client

#endif
