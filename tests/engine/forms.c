/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A workspace that has answered other requests, and a prepared request, answer and refuse as a new
 * workspace: what they remember of a request is never that of another one.
 */
#include "models.h"
#include "support/questions.h"
#include "test.h"

#define STATES 3

struct setting {
    test_robot *robot;
    random_states *x;
    tfa_workspace *used; /* answers everything */
    answers *a, *b;
};

/* One workspace answers all of them */
static void every_question(test_robot *robot, void (*ask)(struct setting *s, const question *q))
{
    struct setting s = {.robot = robot,
                        .x = fixture_states(robot, 7, STATES, 2),
                        .used = workspace_for(robot->model, NULL),
                        .a = answers_create(robot, STATES),
                        .b = answers_create(robot, STATES)};
    for (size_t k = 0; k < question_count; k++)
        if (question_fits(robot, &questions[k]))
            ask(&s, &questions[k]);
    answers_free(s.a);
    answers_free(s.b);
    tfa_workspace_free(s.used);
    random_states_free(s.x);
}

/* By a new workspace into b; by the one in use into a. Both must agree, in what they refuse,
 * too. */
static void ask_used_and_new(struct setting *s, const question *q, const char *what,
                             const tfa_request *r)
{
    tfa_workspace *fresh = workspace_for(s->robot->model, NULL);
    answers_ask(s->a, s->used, r);
    answers_ask(s->b, fresh, r);
    assert_same_answers(s->robot, q, what, s->a, s->b);
    tfa_workspace_free(fresh);
}

static void expect_refusal(struct setting *s, const question *q, const char *what,
                           const tfa_request *r, tfa_prepared *prepared)
{
    tfa_reply of_check = {0}, of_used = answers_reply(s->a, 0, 0), of_run = of_used;
    const int status = tfa_request_check(s->robot->model, r, &of_check);
    (void)tfa_compute(s->used, r, &of_used);
    if (prepared)
        (void)tfa_run(prepared, r, &of_run);
    for (int k = 0; k < (prepared ? 2 : 1) && status != TFA_OK; k++) {
        const tfa_reply *got = k ? &of_run : &of_used;
        if (got->status != status || got->field != of_check.field || got->index != of_check.index ||
            got->state != of_check.state)
            fail_msg("%s: %s: %s: %s at %s %u of state %u, expected %s at %s %u of state %u",
                     s->robot->name, q->name, what, tfa_status_name(got->status),
                     tfa_field_name(got->field), (unsigned)got->index, (unsigned)got->state,
                     tfa_status_name(status), tfa_field_name(of_check.field),
                     (unsigned)of_check.index, (unsigned)of_check.state);
    }
}

/* ---- requests after one another ---- */

/* The same form with other numbers and another count; other frames, locked joints and payloads,
 * which are changed where they lie */
static void ask_relatives(struct setting *s, const question *q)
{
    const uint32_t frames = tfa_model_frame_count(s->robot->model);
    double payloads[TFA_PAYLOAD_NUMBERS];
    uint32_t locked[1] = {0};
    tfa_request r = question_request(s->robot, q, s->x, STATES);
    if (r.payload_count)
        r.payloads = memcpy(payloads, r.payloads, sizeof payloads);
    if (r.locked_count)
        r.locked = locked;
    ask_used_and_new(s, q, "first", &r);
    ask_used_and_new(s, q, "again", &r);
    r.q += s->robot->nq;
    r.count = 1;
    r.base_pose = r.base_pose ? r.base_pose + 7 : NULL;
    ask_used_and_new(s, q, "another state", &r);
    r.v = r.v ? NULL : s->x->v;
    r.gravity = NULL;
    ask_used_and_new(s, q, "other arrays", &r);
    for (uint32_t k = 0; k < r.tip_count; k++)
        r.tips[k] = k % frames;
    ask_used_and_new(s, q, "other tips", &r);
    r.wrench_frames[0] = 0;
    ask_used_and_new(s, q, "other frames of wrenches", &r);
    payloads[0] *= 2;
    locked[0] = tfa_model_joint_count(s->robot->model) - 1;
    if (r.payload_count || r.locked_count)
        ask_used_and_new(s, q, "changed in place", &r);
}

static void in_sequence(test_robot *robot)
{
    every_question(robot, ask_relatives);
}

EVERY_ROBOT(a_workspace_remembers_nothing_of_other_requests, in_sequence, true)

static void constrained_in_sequence(test_robot *robot)
{
    fixture_constrained(robot, in_sequence);
}

EVERY_ROBOT(nor_of_constraints, constrained_in_sequence, true)

/* ---- prepared requests ---- */

static void run_prepared(struct setting *s, const question *q)
{
    double payloads[TFA_PAYLOAD_NUMBERS];
    const uint32_t nowhere[1] = {UINT32_MAX};
    tfa_request r = question_request(s->robot, q, s->x, STATES);
    tfa_prepared *prepared;
    tfa_reply reply;
    assert_int_equal(tfa_prepare(s->used, &r, &reply, &prepared), TFA_OK);
    answers_ask(s->b, s->used, &r);
    r.payloads = payloads; /* of these it has copies */
    r.locked = nowhere;
    for (size_t k = 0; k < TFA_PAYLOAD_NUMBERS; k++)
        payloads[k] = NAN;
    answers_clear(s->a);
    reply = answers_reply(s->a, 0, 0);
    (void)tfa_run(prepared, &r, &reply);
    assert_same_answers(s->robot, q, "prepared", s->a, s->b);
    tfa_prepared_free(prepared);
}

static void prepared_requests(test_robot *robot)
{
    every_question(robot, run_prepared);
}

EVERY_ROBOT(prepared_requests_answer_alike, prepared_requests, true)

/* ---- faults behind a valid request of the same form ---- */

static void refuse_numbers(struct setting *s, const question *q, tfa_request *r,
                           tfa_prepared *prepared)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    const struct {
        const char *what;
        double *x;
        size_t width;
    } arrays[] = {{"q", s->x->q, s->robot->nq},
                  {"v", s->x->v, s->robot->nv},
                  {"tau", s->x->tau, s->robot->nv},
                  {"wrenches", s->x->wrenches, r->wrench_count ? 6 * (size_t)r->wrench_count : 0},
                  {"base_pose", s->x->base_pose, r->base_pose ? 7 : 0}};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        for (size_t e = 0; e < arrays[k].width * STATES; e++) {
            const double good = arrays[k].x[e];
            arrays[k].x[e] = bad[e % 3];
            expect_refusal(s, q, arrays[k].what, r, prepared);
            arrays[k].x[e] = good;
        }
}

/* What lies in the caller's arrays can change though the request does not. */
static void refuse_in_place(struct setting *s, const question *q, const tfa_request *good)
{
    double payloads[TFA_PAYLOAD_NUMBERS];
    uint32_t locked[1] = {0};
    tfa_request r = *good;
    if (r.payload_count)
        r.payloads = memcpy(payloads, r.payloads, sizeof payloads);
    if (r.locked_count)
        r.locked = locked;
    answers_ask(s->a, s->used, &r);
    payloads[0] = -1;
    locked[0] = UINT32_MAX;
    expect_refusal(s, q, "spoilt in place", &r, NULL);
}

static void refuse_choices(struct setting *s, const question *q, const tfa_request *good)
{
    tfa_request r = *good;
    r.count = 0;
    expect_refusal(s, q, "no state", &r, NULL);
    r = *good;
    r.q = NULL;
    expect_refusal(s, q, "no q", &r, NULL);
    r = *good;
    r.tips[0] = UINT32_MAX;
    expect_refusal(s, q, "a tip that is not there", &r, NULL);
    r = *good;
    r.wrenches = NULL;
    expect_refusal(s, q, "no wrenches", &r, NULL);
    r = *good;
    r.wrench_frames[0] = UINT32_MAX;
    expect_refusal(s, q, "a wrench on nothing", &r, NULL);
    r = *good;
    r.method = (tfa_method)99;
    expect_refusal(s, q, "a method that is not there", &r, NULL);
    r = *good;
    r.flags |= 1u << 31;
    expect_refusal(s, q, "a flag that is not there", &r, NULL);
}

static void refuse_relatives(struct setting *s, const question *q)
{
    tfa_request r = question_request(s->robot, q, s->x, STATES);
    tfa_prepared *prepared;
    tfa_reply reply;
    assert_int_equal(tfa_prepare(s->used, &r, &reply, &prepared), TFA_OK);
    answers_ask(s->a, s->used, &r);
    refuse_numbers(s, q, &r, prepared);
    refuse_choices(s, q, &r);
    refuse_in_place(s, q, &r);
    tfa_prepared_free(prepared);
}

static void refusals(test_robot *robot)
{
    every_question(robot, refuse_relatives);
}

EVERY_ROBOT(faults_are_found_in_forms_that_are_known, refusals, true)
