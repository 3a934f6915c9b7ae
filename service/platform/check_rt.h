/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforced --check-rt`: how far this machine suits a real-time daemon.
 */
#ifndef TFA_SERVICE_PLATFORM_CHECK_RT_H
#define TFA_SERVICE_PLATFORM_CHECK_RT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "config/config.h"

/** What is asked, and where it is looked up. */
typedef struct tfa_check_rt {
    const char *root;                      /**< prefix of /proc and /sys: "", or a tree of a test */
    const config *settings;                /**< wishes; NULL: none */
    uint64_t rtprio, memlock, files;       /**< limits of this process; memlock in bytes */
    bool nice_capability, lock_capability; /**< CAP_SYS_NICE, CAP_IPC_LOCK */
    uint32_t processors;                   /**< online */
} tfa_check_rt;

/** The limits and capabilities of this process. */
tfa_check_rt tfa_check_rt_here(const config *settings);

/**
 * Prints one line for each property: verdict, name, value; and a remedy below where one helps.
 * Verdicts: ok; warning (worse latency); missing (the configuration asks for it and it cannot be
 * had).
 * @return properties that are missing
 */
unsigned tfa_check_rt_print(const tfa_check_rt *check, FILE *out);

#endif
