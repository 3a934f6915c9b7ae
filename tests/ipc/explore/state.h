/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The trail of choices and the set of states that were met.
 */
#ifndef TFA_EXPLORER_STATE_H
#define TFA_EXPLORER_STATE_H

#include <stdbool.h>
#include <stdint.h>

static inline uint64_t state_mix(uint64_t hash, uint64_t value)
{
    uint64_t x = (hash ^ value) * 0x9e3779b97f4a7c15u;
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93u;
    return x ^ (x >> 29);
}

void states_clear(void);

/** @return true: the state is new */
bool states_insert(uint64_t hash);
uint64_t states_count(void);

/** A new exploration; the next execution; @return false: every choice was taken */
void trail_clear(void);
bool trail_advance(void);
void trail_rewind(void);

/** True while the execution repeats choices of the one before. */
bool trail_replays(void);

/** One of `count` choices. */
int trail_choose(int count);

#endif
