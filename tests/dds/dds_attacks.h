/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hostile participants in the DDS domain of a daemon with an arm.
 */
#ifndef TFA_TESTS_DDS_ATTACKS_H
#define TFA_TESTS_DDS_ATTACKS_H

#include <dds/dds.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

extern const size_t dds_attack_count;

/* If the arguments say so, be such a participant and never return. The first thing main does. */
void dds_attack_main(int argc, char **argv);

/* Starts one in a process of its own, which runs until it or this one is killed; attack_stop ends
 * it. Cyclone does not survive a fork: the program is started anew. */
pid_t dds_attack_start(size_t index, uint32_t domain);

/* Answers every request with DDS_LIE before the daemon may, and withdraws the robot again and
 * again, until it is stopped. */
#define DDS_LIE 666
typedef struct dds_forger {
    _Atomic bool stop;
    _Atomic uint32_t forged;
} dds_forger;
void dds_forge(dds_entity_t participant, const dds_entity_t *topics, dds_forger *f);

#endif
