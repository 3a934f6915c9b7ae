/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Daemons whose lease is long, so that none is judged dead that gets no processor, lead at once.
 */
#ifndef TESTS_DDS_HERALD_H
#define TESTS_DDS_HERALD_H

#include <stdint.h>

/** A daemon in `domain` that has just started, or begins anew, and serves `robot`, does not listen
 * for a lease: it hears a leader, which says good-bye. Returns when it leads. */
void dds_herald(uint32_t domain, const char *robot);

#endif
