/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * tfa_compute: the form of a request, then a loop over the strategies that serve it.
 */
#include <math.h>
#include <string.h>

#include "engine/flush_to_zero.h"
#include "engine/form.h"
#include "engine/methods.h"

/* An answer whose numbers are not finite is none, if the state has one. */
static void fail_answer(tfa_workspace *w, const struct call *c, uint32_t k, tfa_reply *reply)
{
    if (reply->answers && reply->answers[k].status == TFA_OK)
        reply->answers[k].status = TFA_E_NOT_COMPUTED;
    tfa_fail_state(w, c, k, TFA_E_NOT_COMPUTED, (struct failed_field){TFA_FIELD_NONE, 0}, reply);
}

/* Answers of kinematics that the strategy of states k .. k + count - 1 left out */
static void answer_motion(tfa_workspace *w, const struct call *c, uint32_t traits, uint32_t k,
                          uint32_t count, tfa_reply *reply)
{
    const uint32_t flags = (traits & TRAIT_TIP_MOTION ? FLAGS_TIP_MOTION : 0) |
                           (traits & TRAIT_BODY_MOTION ? FLAGS_BODY_MOTION : 0);
    for (uint32_t end = k + count; k < end; k++)
        if (!w->kernel->answer_motion(w->state, c->request, c->by, flags, k, reply))
            fail_answer(w, c, k, reply);
}

void tfa_add_joint_forces(tfa_workspace *w, const struct call *c, uint32_t k, uint32_t count,
                          tfa_reply *reply)
{
    for (uint32_t end = k + count; reply->joint_forces && k < end; k++)
        if (!w->kernel->answer_joint_forces(w->state, c->request, c->by, k, 0, reply))
            fail_answer(w, c, k, reply);
}

/* Answers that the strategy of states k .. k + count - 1 left out */
static void add_answers(tfa_workspace *w, const struct call *c, uint32_t left, uint32_t k,
                        uint32_t count, tfa_reply *reply)
{
    if (left & TRAITS_MOTION)
        answer_motion(w, c, left, k, count, reply);
    if (left & TRAIT_JOINT_FORCES)
        tfa_add_joint_forces(w, c, k, count, reply);
}

void tfa_compute_by(tfa_workspace *w, const struct call *c, uint32_t row, uint32_t k, uint32_t end,
                    tfa_reply *reply)
{
    while (k < end) {
        uint32_t done = 0, s = row;
        while ((done = c->strategy[s]->run(w, c, k, end, reply)) == 0)
            s++; /* the last row answers everything */
        if (c->traits & TRAITS_ADDED)
            add_answers(w, c, c->traits & TRAITS_ADDED & ~c->strategy[s]->added, k, done, reply);
        k += done;
    }
}

/* Members of tfa_request before and behind `count`, up to the lists of frames */
#define CHOICES_BYTES offsetof(tfa_request, count)
#define SIZES_AT offsetof(tfa_request, tip_count)
#define SIZES_BYTES (offsetof(tfa_request, tips) - SIZES_AT)

static inline int is_equal(const void *a, const void *b, size_t offset, size_t bytes)
{
    return memcmp((const char *)a + offset, (const char *)b + offset, bytes) == 0;
}

/* The form of this request, if it was the last one of its op; else NULL. Requests with payloads or
 * locked joints are none: what they name lies in the caller's arrays. */
static inline struct tfa_form *find_form(tfa_workspace *w, const tfa_request *r)
{
    if ((unsigned)r->op > TFA_OP_LAST)
        return NULL;
    struct tfa_last *last = &w->last[r->op];
    const tfa_request *of = &last->request;
    if (!last->is_valid || !is_equal(of, r, 0, CHOICES_BYTES) ||
        !is_equal(of, r, SIZES_AT, SIZES_BYTES))
        return NULL;
    for (uint32_t k = 0; k < r->tip_count; k++)
        if (r->tips[k] != of->tips[k])
            return NULL;
    for (uint32_t k = 0; k < r->wrench_count; k++)
        if (r->wrench_frames[k] != of->wrench_frames[k])
            return NULL;
    return &last->form;
}

void tfa_form_init(struct tfa_form *form, const tfa_workspace *w, const tfa_request *r)
{
    tfa_inputs_of(w->model, r, &form->inputs);
    tfa_call_init(&form->call, w, r);
}

/* As tfa_request_check, of a request of this form */
static int check_form(const tfa_workspace *w, const struct tfa_form *form, const tfa_request *r,
                      tfa_reply *reply)
{
    tfa_reply_begin(w->model, reply);
    if (r->count == 0)
        return tfa_set_error(reply, TFA_E_SIZE, TFA_FIELD_COUNT, 0, 0);
    if (r->rank_threshold || r->characteristic_length ||
        TFA_OP_BIT(r->op) & (TRAIT_TASK | TRAITS_CONSTRAINED)) {
        const int status = tfa_check_operational(r, reply);
        if (status != TFA_OK)
            return status;
    }
    const double zero = w->kernel->zero_of_inputs(r, &form->inputs);
    return tfa_check_numbers(w->model, r, &form->inputs, zero, reply);
}

/* One state by the robot's specialised kernel, as run_specialised. Returns 1; 0 without an answer;
 * or TFA_SPECIALISED_NO_CODE. */
static inline uint32_t solve_one(const tfa_workspace *w, const struct call *c, const tfa_request *r,
                                 tfa_reply *reply)
{
    if (!c->solve_one || r->count != 1 || (r->tip_count && !reply->lambda_inv))
        return TFA_SPECIALISED_NO_CODE;
    const uint32_t answered = c->solve_one(&w->host, r, 0, reply);
    if (answered == 1 && reply->answers)
        *reply->answers =
            (tfa_answer){.method = (uint16_t)c->by.method, .error_estimate = (double)NAN};
    return answered;
}

static inline void compute_checked_form(tfa_workspace *w, struct tfa_form *form,
                                        const tfa_request *r, tfa_reply *reply)
{
    const uint32_t answered = solve_one(w, &form->call, r, reply);
    if (answered == 1)
        return;
    form->call.request = r;
    tfa_compute_by(w, &form->call, answered == 0, 0, r->count, reply); /* not by that row again */
}

int tfa_compute_form(tfa_workspace *w, struct tfa_form *form, const tfa_request *r,
                     tfa_reply *reply)
{
    const int status = check_form(w, form, r, reply);
    if (status != TFA_OK)
        return status;
    const uint64_t mode = tfa_flush_begin();
    compute_checked_form(w, form, r, reply);
    tfa_flush_end(mode);
    return reply->status;
}

int tfa_compute(tfa_workspace *w, const tfa_request *r, tfa_reply *reply)
{
    struct tfa_form *form = find_form(w, r);
    if (form)
        return tfa_compute_form(w, form, r, reply);
    const int status = tfa_request_check(w->model, r, reply);
    return status == TFA_OK ? tfa_compute_states(w, r, 0, r->count, reply) : status;
}

int tfa_compute_states(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                       uint32_t count, tfa_reply *reply)
{
    const int status = tfa_reserved_check(workspace, request, reply);
    return status == TFA_OK ? tfa_compute_checked(workspace, request, first, first + count, reply)
                            : status;
}

int tfa_compute_checked(tfa_workspace *w, const tfa_request *r, uint32_t first, uint32_t end,
                        tfa_reply *reply)
{
    struct tfa_form *form = find_form(w, r);
    if (!form) {
        struct tfa_last *last = &w->last[r->op];
        last->is_valid = !r->payload_count && !r->locked_count;
        last->request = *r;
        form = &last->form;
        tfa_form_init(form, w, r);
    }
    form->call.request = r;
    const uint64_t mode = tfa_flush_begin();
    tfa_compute_by(w, &form->call, 0, first, end, reply);
    tfa_flush_end(mode);
    return reply->status;
}

/* Writes to every page of a frame of its own. */
__attribute__((noinline)) void tfa_stack_prepare(void)
{
    volatile unsigned char buffer[TFA_STACK_BYTES];
    for (size_t k = 0; k < sizeof buffer; k += 4096)
        buffer[k] = 0;
}
