/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cyclone as the gateways of the daemon use it: a domain with a bound on samples, a participant,
 * the reason of a failure, the log.
 */
#ifndef TFA_SERVICE_DDS_DOMAIN_H
#define TFA_SERVICE_DDS_DOMAIN_H

#include <dds/dds.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

/* What a gateway has in a domain; 0: not yet. */
typedef struct dds_member {
    dds_entity_t domain, participant;
} dds_member;

/**
 * Makes a domain with `settings` (Cyclone's XML; NULL: none), then those of the user
 * (CYCLONEDDS_URI), then a bound: Cyclone drops larger samples before it takes memory for them.
 * @param sample_bytes  the bound; 0: the domain was made already
 * @param user_data     of the participant; NULL: none
 * @return TFA_OK; TFA_E_SYSTEM: see tfa_dds_error
 */
TFA_CHECKED int tfa_dds_join(uint32_t id, const char *settings, size_t sample_bytes,
                             const char *user_data, dds_member *member);
void tfa_dds_leave(const dds_member *member);

/** Why a gateway could not be created, in Cyclone's words. Static storage, one thread. */
const char *tfa_dds_error(void);
__attribute__((format(printf, 1, 2))) void tfa_dds_set_error(const char *format, ...);
/** Remembers a failure of this step. @return whether `entity_or_code` is one */
bool tfa_dds_failed(dds_return_t entity_or_code, const char *step);

enum { TFA_DDS_ORIGIN_SIZE = 192 };

/** What a discovered participant says of itself: process, number, host, addresses. Printable,
 *  without quotes and backslashes. Allocates; not in a listener. */
void tfa_dds_describe_origin(dds_entity_t participant, const uint8_t guid[16],
                             char text[TFA_DDS_ORIGIN_SIZE]);

/** False if nothing in CYCLONEDDS_URI, or in the files that it names, configures DDS Security. */
bool tfa_dds_has_security(void);

/** CLOCK_MONOTONIC, ns. */
int64_t tfa_dds_monotonic(void);

/** Hands the first line of Cyclone's warnings to `log`, in any thread, for all domains of the
 *  process. Called while there is no domain. */
void tfa_dds_log_to(void (*log)(const char *text));

#endif
