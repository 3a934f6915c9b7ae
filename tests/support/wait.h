/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Waiting for a condition. A test asserts no duration: the bound is only ever used up by a failure.
 */
#ifndef TESTS_SUPPORT_WAIT_H
#define TESTS_SUPPORT_WAIT_H

#include <stdbool.h>
#include <stdint.h>
#include <time.h>

/** The bound of every wait for what must happen, here and in calls with a timeout: also of a daemon
 *  of 21 robots under ThreadSanitizer that gets a fiftieth of a processor to start. */
#define WAIT_NS UINT64_C(300000000000)
#define WAIT_MS 300000

/** CLOCK_MONOTONIC, ns */
static inline uint64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static inline void sleep_ms(unsigned ms)
{
    const struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = (long)(ms % 1000) * 1000000};
    nanosleep(&time, NULL);
}

/* Between two looks at a condition. @return whether there is another look: the last one comes after
 * the bound, so that a test that got no processor meanwhile looks once more */
static inline bool wait_again(uint64_t end, bool *last)
{
    if (*last)
        return false;
    sleep_ms(1);
    *last = now_ns() >= end;
    return true;
}

/** WAIT_FOR(condition): evaluates it every millisecond until it is true or WAIT_NS are over; its
 * value is that of the condition. assert_true(WAIT_FOR(count_answers() == 3)); */
#define WAIT_FOR(condition)                                                                        \
    __extension__({                                                                                \
        const uint64_t wait_end = now_ns() + WAIT_NS;                                              \
        bool wait_last = false, wait_met = false;                                                  \
        do {                                                                                       \
            wait_met = (condition);                                                                \
        } while (!wait_met && wait_again(wait_end, &wait_last));                                   \
        wait_met;                                                                                  \
    })

#endif
