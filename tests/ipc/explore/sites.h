/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The call sites of atomic operations that have been executed, and the weakening of one of them.
 */
#ifndef TFA_EXPLORER_SITES_H
#define TFA_EXPLORER_SITES_H

#include <stdatomic.h>

/** Lists the site at its first use. @return the order in force */
memory_order site_order(explorer_site *site, int kind, memory_order declared, const char *function);

/** First of the list, in order of first use */
explorer_site *sites_first(void);

/** "ring.h:175 tfa_ring_send store", valid until the next call */
const char *site_text(const explorer_site *site);
const char *order_text(memory_order order);

/** Next weaker order of this kind of site. @return `order` itself: there is none */
memory_order weaker_order(int kind, memory_order order);

#endif
