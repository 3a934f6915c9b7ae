/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Background load: threads that compute, or write through more memory than caches hold.
 */
#ifndef TOOLS_LATENCY_MACHINE_BACKGROUND_LOAD_H
#define TOOLS_LATENCY_MACHINE_BACKGROUND_LOAD_H

#include <stdint.h>

typedef struct background_load background_load;

/** Starts the threads. @return NULL: no memory or threads */
background_load *background_load_start(uint32_t compute, uint32_t memory);

/** Ends them. NULL is allowed. */
void background_load_stop(background_load *load);

#endif
