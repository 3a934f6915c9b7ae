/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Execution strategies of a workspace: one table in order of preference. The first row that serves
 * a request and has an answer wins.
 */
#ifndef TFA_ENGINE_STRATEGY_H
#define TFA_ENGINE_STRATEGY_H

#include "engine/workspace.h"
#include "interface/traits.h"
#include "model/model.h"

/* A checked request under way */
struct call {
    const tfa_request *request;
    struct tfa_resolved by;
    uint32_t traits;
    uint32_t batch_min; /* fewer states are computed one at a time */
    const struct strategy *strategy[TFA_STRATEGIES];
    uint32_t strategies; /* rows that serve it, in order */
    /* Of a request of one state: the robot's specialised kernel, where its answers are the whole;
     * else NULL */
    uint32_t (*solve_one)(const struct tfa_host_api *host, const tfa_request *request, uint32_t k,
                          tfa_reply *reply);
};

struct strategy {
    const char *name;
    /* 1: a workspace of this kind can run it */
    int (*is_available)(const tfa_workspace *w);
    uint32_t ops;     /* ops that it serves, TRAIT_FD .. */
    uint32_t refuses; /* traits */
    uint32_t added;   /* TRAITS_ADDED that its run answers; the kernel of one state adds others */
    uint32_t methods; /* resolved methods that it serves: TFA_METHOD_BITs */
    /* Further conditions; NULL: none */
    int (*serves)(const tfa_workspace *w, const struct call *c);
    /* Answers states from k on, before `end`. Returns how many; 0: the next row tries. */
    uint32_t (*run)(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                    tfa_reply *reply);
};

/* The rows that a workspace can run, in order. Returns how many. */
uint32_t tfa_strategies_of(const tfa_workspace *w, const struct strategy **out);

/* A call of a checked request, with the rows that serve it */
void tfa_call_init(struct call *call, const tfa_workspace *w, const tfa_request *request);

/* Resolves TFA_METHOD_AUTO. Cost: some ten instructions and one step for each locked joint. */
struct tfa_resolved tfa_resolve_method(const tfa_workspace *w, const tfa_request *request,
                                       uint32_t traits);

/* States k .. end - 1 of a call by its strategies from `row` on: compute.c */
void tfa_compute_by(tfa_workspace *w, const struct call *c, uint32_t row, uint32_t k, uint32_t end,
                    tfa_reply *reply);

/* joint_forces of states k .. k + count - 1, which have accelerations: compute.c */
void tfa_add_joint_forces(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t count,
                          tfa_reply *reply);

/* The runs of the rows, see strategies.c; mixed precision: mixed.c */
uint32_t tfa_run_mixed(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t end,
                       tfa_reply *reply);

/* The spectrum of state k, if there are arrays for it */
void tfa_finish_spectrum(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply);

/* Stores the answer of state k and its spectrum. */
static inline void tfa_finish_state(tfa_workspace *w, const struct call *c, uint32_t k,
                                    const tfa_answer *answer, tfa_reply *reply)
{
    if (reply->answers)
        reply->answers[k] = *answer;
    if (c->traits & TRAIT_SPECTRUM)
        tfa_finish_spectrum(w, c, k, reply);
}

/* Field and index of a reply, which a kernel sets for a state that it cannot answer. A whole reply
 * takes 15 ns to copy. */
struct failed_field {
    tfa_field field;
    uint32_t index;
};

static inline struct failed_field tfa_failed_field(const tfa_reply *reply)
{
    return (struct failed_field){reply->field, reply->index};
}

/* Voids the answers that a failed state does not have; the reply tells of the first one. */
void tfa_fail_state(tfa_workspace *w, const struct call *c, uint32_t k, int status,
                    struct failed_field failed, tfa_reply *reply);

/* tfa_finish_state for a state that may have failed. */
void tfa_finish_single(tfa_workspace *w, const struct call *c, uint32_t k, int status,
                       struct failed_field failed, const tfa_answer *answer, tfa_reply *reply);

/* Makes the answers NaN that a state which failed does not have. */
void tfa_void_failed_state(const tfa_workspace *w, const struct call *c, uint32_t k, int status,
                           const tfa_reply *reply);

#endif
