/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Records and counters in shared memory.
 */
#include "ipc/statistics_layout.h"

#include <math.h>
#include <string.h>

#include "ipc/wire_blocks.h"
#include "statistics/bucket.h"

/* Copies of a record that is being written are tried so often: about a millisecond. */
#define TRIES 10000
#define STATE_INTERVAL_NS 10000000u

/* ---- records ---- */

void tfa_words_write(tfa_counter *words, const void *from, size_t bytes)
{
    const unsigned char *at = from;
    for (size_t i = 0; i < bytes / 8; i++) {
        uint64_t word;
        memcpy(&word, at + 8 * i, 8);
        tfa_counter_set(&words[i], word);
    }
}

void tfa_words_clear(tfa_counter *words, size_t count)
{
    for (size_t i = 0; i < count; i++)
        tfa_counter_set(&words[i], 0);
}

void tfa_record_write(tfa_counter *version, tfa_counter *words, const void *from, size_t bytes)
{
    tfa_record_begin(version);
    tfa_words_write(words, from, bytes);
    tfa_record_end(version);
}

uint64_t tfa_record_version(const tfa_counter *version)
{
    uint64_t v = 1;
    for (int i = 0; i < TRIES && v % 2; i++)
        v = atomic_load_explicit(version, memory_order_acquire); /* T1 */
    return v;
}

bool tfa_record_read(const tfa_counter *version, const tfa_counter *words, void *to, size_t bytes)
{
    unsigned char *at = to;
    for (int i = 0; i < TRIES; i++) {
        const uint64_t began = atomic_load_explicit(version, memory_order_acquire); /* T1 */
        if (began % 2)
            continue;
        for (size_t k = 0; k < bytes / 8; k++) {
            const uint64_t word = atomic_load_explicit(&words[k], memory_order_acquire); /* T2 */
            memcpy(at + 8 * k, &word, 8);
        }
        if (tfa_record_is_valid(version, began))
            return true;
    }
    return false;
}

/* ---- counters of requests ---- */

static uint64_t value_of(const tfa_counter *word)
{
    return atomic_load_explicit(word, memory_order_relaxed); /* the writer's own */
}

static void raise_to(tfa_counter *word, uint64_t value)
{
    if (value > value_of(word))
        tfa_counter_set(word, value);
}

static inline void count_time(tfa_shared_tally *t, int time, uint64_t ns)
{
    tfa_counter_add(&t->words[TFA_TALLY_SUMS + time], ns);
    raise_to(&t->words[TFA_TALLY_MAXIMA + time], ns);
    tfa_counter_add(
        &t->buckets[time][tfa_bucket_of(TFA_STATISTICS_BITS, TFA_STATISTICS_BUCKETS, ns)], 1);
}

static void count_estimate(tfa_shared_tally *t, double estimate)
{
    double bound = 1e-18;
    int k = 0;
    uint64_t bits;
    if (!(estimate >= 0)) /* NaN: as large as can be */
        estimate = HUGE_VAL;
    for (; k < TFA_STATISTICS_DECADES - 1 && estimate >= bound; k++)
        bound *= 10;
    tfa_counter_add(&t->words[TFA_TALLY_DECADES + k], 1);
    memcpy(&bits, &estimate, 8);
    raise_to(&t->words[TFA_TALLY_LARGEST], bits);
}

static void count_flags(tfa_shared_tally *t, const tfa_answer *answer)
{
    for (uint32_t flags = answer->flags & 0xff; flags; flags &= flags - 1)
        tfa_counter_add(&t->words[TFA_TALLY_FLAGS + __builtin_ctz(flags)], 1);
    if (answer->flags & TFA_ANSWER_ESTIMATED)
        count_estimate(t, answer->error_estimate);
}

static inline void count_answers(tfa_shared_tally *t, const tfa_tally_request *r)
{
    uint32_t method = r->answers ? r->answers[0].method : 0;
    method = method < TFA_STATISTICS_METHODS ? method : 0;
    tfa_counter_add(&t->words[TFA_TALLY_METHODS + method], 1);
    if (r->states != 1)
        tfa_counter_add(&t->words[TFA_TALLY_MORE_STATES], r->states - 1);
    if (r->refined)
        tfa_counter_add(&t->words[TFA_TALLY_REFINED], r->states);
    if (!r->answers)
        return;
    for (uint32_t i = 0; i < r->states; i++)
        if (__builtin_expect(r->answers[i].flags, 0))
            count_flags(t, &r->answers[i]);
}

void tfa_tally_count(tfa_shared_tally *t, const tfa_tally_request *r)
{
    const uint32_t status = (uint32_t)-r->status;
    tfa_record_begin(&t->version);
    tfa_counter_add(
        &t->words[TFA_TALLY_STATUSES + (status < TFA_STATISTICS_STATUSES ? status : -TFA_E_SYSTEM)],
        1);
    if (r->has_answers)
        count_answers(t, r);
    if (r->busy_ns < r->done - r->start)
        tfa_counter_add(&t->words[TFA_TALLY_PAUSES], r->done - r->start - r->busy_ns);
    count_time(t, TFA_TIME_QUEUE, r->start - r->received);
    count_time(t, TFA_TIME_COMPUTE, r->done - r->start);
    if (r->sent && r->sent <= r->done)
        count_time(t, TFA_TIME_TOTAL, r->done - r->sent);
    tfa_record_end(&t->version);
}

void tfa_tally_add(tfa_shared_tally *t, const tfa_shared_tally *from)
{
    tfa_record_begin(&t->version);
    for (int i = 0; i < TFA_TALLY_WORDS; i++) {
        const uint64_t value = value_of(&from->words[i]);
        if ((i >= TFA_TALLY_MAXIMA && i < TFA_TALLY_MAXIMA + TFA_TIMES) || i == TFA_TALLY_LARGEST)
            raise_to(&t->words[i], value);
        else
            tfa_counter_add(&t->words[i], value);
    }
    for (int k = 0; k < TFA_TIMES; k++)
        for (int i = 0; i < (int)TFA_STATISTICS_BUCKETS; i++)
            tfa_counter_add(&t->buckets[k][i], value_of(&from->buckets[k][i]));
    tfa_record_end(&t->version);
}

void tfa_tally_clear(tfa_shared_tally *t)
{
    tfa_record_begin(&t->version);
    tfa_words_clear(t->words, TFA_TALLY_WORDS);
    for (int k = 0; k < TFA_TIMES; k++)
        tfa_words_clear(t->buckets[k], TFA_STATISTICS_BUCKETS);
    tfa_record_end(&t->version);
}

void tfa_tally_sum(const tfa_shared_tally *t, tfa_tally_sums *sums)
{
    for (int i = 0; i < TFA_STATISTICS_STATUSES; i++) {
        const uint64_t count = value_of(&t->words[TFA_TALLY_STATUSES + i]);
        sums->requests += count;
        sums->rejected += tfa_wire_has_answers(-i) ? 0 : count;
    }
    sums->late += value_of(&t->words[TFA_TALLY_STATUSES - TFA_E_LATE]);
    const uint64_t pauses = value_of(&t->words[TFA_TALLY_PAUSES]),
                   compute = value_of(&t->words[TFA_TALLY_SUMS + TFA_TIME_COMPUTE]);
    sums->busy_ns += compute > pauses ? compute - pauses : 0;
}

/* ---- states ---- */

void tfa_state_publish(tfa_shared_state *s, const tfa_request *request, uint32_t q_count,
                       bool floating, uint64_t now)
{
    const uint64_t before = value_of(&s->words[0]); /* its time */
    if (before && now - before < STATE_INTERVAL_NS)
        return;
    tfa_robot_state state; /* only what is written is set */
    const size_t head = offsetof(tfa_robot_state, base_pose) / 8,
                 q = offsetof(tfa_robot_state, q) / 8;
    state.time = now;
    state.q_count = q_count <= TFA_STATISTICS_Q_MAX ? q_count : 0;
    state.floating = floating && request->base_pose;
    tfa_record_begin(&s->version);
    tfa_words_write(s->words, &state, 8 * head);
    if (state.floating)
        tfa_words_write(&s->words[head], request->base_pose, 7 * sizeof(double));
    tfa_words_write(&s->words[q], request->q, state.q_count * sizeof(double));
    tfa_record_end(&s->version);
}
