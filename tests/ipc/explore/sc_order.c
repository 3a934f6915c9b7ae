/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constraints of S as a transitive closure.
 */
#include "sc_order.h"

#include <stdint.h>

static sc_set precede[SC_OPERATIONS]; /* of operation k: those before it, transitively */
static int count;

void sc_reset(void)
{
    count = 0;
}

static sc_set with_predecessors_of(sc_set all, uint64_t set, int base)
{
    for (; set; set &= set - 1)
        all |= precede[base + __builtin_ctzll(set)];
    return all;
}

static sc_set with_predecessors(sc_set set)
{
    return with_predecessors_of(with_predecessors_of(set, (uint64_t)set, 0), (uint64_t)(set >> 64),
                                64);
}

bool sc_possible(sc_set before, sc_set after)
{
    return (with_predecessors(before) & after) == 0;
}

int sc_add(sc_set before, sc_set after)
{
    if (count == SC_OPERATIONS)
        return -1;
    const int added = count;
    const sc_set all = with_predecessors(before);
    precede[added] = all;
    count++;
    if (after == 0)
        return added;
    for (int k = 0; k < added; k++)
        if ((after & SC_BIT(k)) || (precede[k] & after))
            precede[k] |= all | SC_BIT(added);
    return added;
}
