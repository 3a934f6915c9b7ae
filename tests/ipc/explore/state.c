/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * An open hash set of 64-bit state hashes; the trail.
 */
#include "state.h"

#include <stdlib.h>
#include <string.h>

#define FIRST_CAPACITY (1u << 16)
#define TRAIL_MAX 1024

static uint64_t *set, capacity, members;
static struct {
    int taken, count;
} trail[TRAIL_MAX];
static int length, at;

void states_clear(void)
{
    if (!set)
        set = malloc((capacity = FIRST_CAPACITY) * sizeof *set);
    if (!set)
        abort();
    memset(set, 0, capacity * sizeof *set);
    members = 0;
}

uint64_t states_count(void)
{
    return members;
}

static bool insert(uint64_t hash)
{
    uint64_t k = hash & (capacity - 1);
    for (; set[k]; k = (k + 1) & (capacity - 1))
        if (set[k] == hash)
            return false;
    set[k] = hash;
    members++;
    return true;
}

bool states_insert(uint64_t hash)
{
    if (2 * members > capacity) {
        uint64_t *old = set;
        const uint64_t old_capacity = capacity;
        set = calloc(capacity *= 4, sizeof *set);
        if (!set)
            abort();
        members = 0;
        for (uint64_t k = 0; k < old_capacity; k++)
            if (old[k])
                (void)insert(old[k]);
        free(old);
    }
    return insert(hash ? hash : 1);
}

void trail_clear(void)
{
    length = at = 0;
}

void trail_rewind(void)
{
    at = 0;
}

bool trail_advance(void)
{
    while (length && trail[length - 1].taken + 1 == trail[length - 1].count)
        length--;
    if (length == 0)
        return false;
    trail[length - 1].taken++;
    return true;
}

bool trail_replays(void)
{
    return at < length;
}

int trail_choose(int count)
{
    if (at == length) {
        if (length == TRAIL_MAX)
            abort();
        trail[length].taken = 0;
        trail[length++].count = count;
    }
    return trail[at++].taken;
}
