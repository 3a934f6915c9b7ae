/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cyclone as the gateways of the daemon use it: a domain with a bound on samples, and its log.
 */
#ifndef TFA_SERVICE_DDS_GATEWAY_DOMAIN_H
#define TFA_SERVICE_DDS_GATEWAY_DOMAIN_H

#include <dds/dds.h>
#include <stddef.h>

/**
 * Makes a domain with `settings` (Cyclone's XML; NULL: none), then those of the user
 * (CYCLONEDDS_URI), then a bound: Cyclone drops larger samples before it takes memory for them.
 * @return the domain; a Cyclone code, DDS_RETCODE_OUT_OF_RESOURCES included
 */
dds_entity_t tfa_dds_make_domain(uint32_t id, const char *settings, size_t sample_bytes);

/** Hands the first line of Cyclone's warnings to `log`, in any thread, for all domains of the
 *  process. Called while there is no domain. */
void tfa_dds_log_to(void (*log)(const char *text));

#endif
