/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests to a reduced model and to its oracle. See reductions.h.
 */
#include "model/model.h"
#include "reductions.h"
#include "test.h"

/* M scaled to unit diagonal has its eigenvalues within this ratio, both of the robot as it is
 * reduced and of the same with its mimics free: rounding the constants of a model to double alone
 * moves an answer by up to 1e-16 times this. Found by trial: of random robots and postures with up
 * to nine joints it accepts most, and the answers that it lets through agree to 1e-13. */
#define CONDITION 500

#define ATTEMPTS 30

/* Cyclic Jacobi rotations: A becomes diagonal. */
static void diagonalise(double *A, uint32_t n)
{
    for (int sweep = 0; sweep < 12; sweep++)
        for (uint32_t p = 0; p < n; p++)
            for (uint32_t q = p + 1; q < n; q++) {
                if (fabs(A[p * n + q]) < 1e-300)
                    continue;
                double theta = (A[q * n + q] - A[p * n + p]) / (2 * A[p * n + q]);
                double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
                double c = 1 / sqrt(t * t + 1), s = t * c;
                for (uint32_t k = 0; k < n; k++) {
                    double x = A[k * n + p], y = A[k * n + q];
                    A[k * n + p] = c * x - s * y;
                    A[k * n + q] = s * x + c * y;
                }
                for (uint32_t k = 0; k < n; k++) {
                    double x = A[p * n + k], y = A[q * n + k];
                    A[p * n + k] = c * x - s * y;
                    A[q * n + k] = s * x + c * y;
                }
            }
}

static double scaled_condition(const double *M, uint32_t n)
{
    double *A = calloc((size_t)n * n + 1, sizeof *A), least = INFINITY, most = 0;
    assert_non_null(A);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < n; k++)
            A[i * n + k] = M[i * n + k] / sqrt(M[i * n + i] * M[k * n + k]);
    diagonalise(A, n);
    for (uint32_t i = 0; i < n; i++) {
        least = fmin(least, A[i * n + i]);
        most = fmax(most, A[i * n + i]);
    }
    free(A);
    return n == 0 ? 1 : least > 0 ? most / least : INFINITY;
}

static double condition_of(const reduction *r, const question *a, uint32_t state,
                           const oracle_tie *ties, uint32_t rows)
{
    double *M = calloc((size_t)rows * rows + 1, sizeof *M);
    assert_non_null(M);
    oracle_tie_freedoms(r->o, ties, rows);
    oracle_set_state(r->o, &a->whole, state);
    oracle_mass_matrix(r->o, M);
    double condition = scaled_condition(M, rows);
    free(M);
    return condition;
}

/* Well conditioned as it is, and with its mimics free. */
static bool is_good(const reduction *r, const question *a, uint32_t state)
{
    const uint32_t all = oracle_freedoms(r->o);
    bool good = condition_of(r, a, state, r->tie, r->n) <= CONDITION;
    if (good && r->coupled) {
        oracle_tie *unmimicked = calloc(all, sizeof *unmimicked);
        assert_non_null(unmimicked);
        uint32_t rows = 0;
        for (uint32_t k = 0; k < all; k++)
            unmimicked[k] = r->tie[k].to == ORACLE_STILL ? r->tie[k] : (oracle_tie){rows++, 1};
        good = condition_of(r, a, state, unmimicked, rows) <= CONDITION;
        free(unmimicked);
    }
    oracle_tie_freedoms(r->o, r->tie, r->n);
    return good;
}

/* The public numbers of one state out of those of the whole robot, and what follows from them for
 * the joints that are not public. */
static void fill_state(question *a, const reduction *r, uint32_t state)
{
    double *whole_q = a->x->q + (size_t)state * r->whole_nq;
    double *whole_v = a->x->v + (size_t)state * r->whole_nv;
    const double *tau = a->x->tau + (size_t)state * r->whole_nv;
    const double *qdd = a->x->qdd + (size_t)state * r->whole_nv;
    const size_t q0 = (size_t)state * r->nq, v0 = (size_t)state * r->nv;
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const reduced_joint *j = &r->joint[k];
        tfa_joint_info at;
        if (j->locked) {
            memcpy(whole_q + j->q, j->at, j->q_count * sizeof *whole_q);
            memset(whole_v + j->v, 0, j->v_count * sizeof *whole_v);
        }
        if (j->index < 0)
            continue;
        if (r->coupled && j->q_count == 1) /* q of a follower is exact then */
            whole_q[j->q] = round(whole_q[j->q] * 0x1p16) / 0x1p16;
        at = tfa_model_joint(r->model, (uint32_t)j->index);
        memcpy(a->q + q0 + at.q_index, whole_q + j->q, j->q_count * sizeof *whole_q);
        memcpy(a->v + v0 + at.v_index, whole_v + j->v, j->v_count * sizeof *whole_v);
        memcpy(a->tau + v0 + at.v_index, tau + j->v, j->v_count * sizeof *tau);
        memcpy(a->qdd + v0 + at.v_index, qdd + j->v, j->v_count * sizeof *qdd);
    }
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const reduced_joint *j = &r->joint[k];
        if (j->leader < 0 || j->locked)
            continue;
        const reduced_joint *leader = &r->joint[j->leader];
        whole_q[j->q] = j->multiplier * whole_q[leader->q] + j->offset;
        whole_v[j->v] = j->multiplier * whole_v[leader->v];
    }
}

static bool present(const reduction *r, uint32_t link)
{
    return tfa_model_find_frame(r->model, r->whole->links[link].name) >= 0;
}

static uint32_t frame_of(const reduction *r, uint32_t link)
{
    return (uint32_t)tfa_model_find_frame(r->model, r->whole->links[link].name);
}

/* Both requests but for tips: the same but for q, v, names of links and the model's payloads. */
static void write_requests(question *a, const reduction *r)
{
    random_states *x = a->x;
    tfa_request q = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = x->count,
                     .wrench_count = x->wrench_count,
                     .wrenches = x->wrenches};
    if (r->base == TFA_BASE_FLOATING) {
        q.base_pose = x->base_pose;
        q.base_twist = x->base_twist;
        q.base_wrench = x->base_wrench;
        q.base_acceleration = x->base_acceleration;
    }
    a->r = a->whole = q;
    a->r.q = a->q;
    a->r.v = a->v;
    a->r.tau = a->tau;
    a->r.qdd = a->qdd;
    a->whole.q = x->q;
    a->whole.v = x->v;
    a->whole.gravity = r->gravity; /* the model's own */
    a->r.gravity = r->as_it_is ? r->gravity : NULL;
    for (uint32_t w = 0; w < x->wrench_count; w++) {
        while (!present(r, x->wrench_links[w])) /* the root always is */
            x->wrench_links[w] = (x->wrench_links[w] + 1) % (uint32_t)r->whole->link_count;
        a->whole.wrench_frames[w] = x->wrench_links[w];
        a->r.wrench_frames[w] = frame_of(r, x->wrench_links[w]);
    }
    memcpy(a->payloads, r->payloads, sizeof r->payloads);
    a->whole.payloads = a->payloads;
    a->whole.payload_count = r->payload_count;
    memcpy(a->whole.payload_frames, r->payload_links, sizeof r->payload_links);
}

bool question_is_good(const question *a, const reduction *r)
{
    bool good = true;
    for (uint32_t k = 0; !r->as_it_is && good && k < a->whole.count; k++)
        good = is_good(r, a, k);
    return good;
}

bool question_open(question *a, const reduction *r, uint64_t seed, uint32_t count,
                   uint32_t wrenches)
{
    memset(a, 0, sizeof *a);
    a->q = calloc((size_t)count * r->nq + 1, sizeof *a->q);
    a->v = calloc((size_t)count * r->nv + 1, sizeof *a->v);
    a->tau = calloc((size_t)count * r->nv + 1, sizeof *a->tau);
    a->qdd = calloc((size_t)count * r->nv + 1, sizeof *a->qdd);
    a->payloads =
        calloc((REDUCTION_PAYLOADS + TFA_MAX_PAYLOADS) * TFA_PAYLOAD_NUMBERS, sizeof *a->payloads);
    assert_true(a->q && a->v && a->tau && a->qdd && a->payloads);
    for (uint64_t attempt = 0; attempt < ATTEMPTS; attempt++) {
        a->x = random_states_create(seed * ATTEMPTS + attempt, r->whole, r->o, count, wrenches);
        for (uint32_t k = 0; k < count; k++)
            fill_state(a, r, k);
        write_requests(a, r);
        if (question_is_good(a, r))
            return true;
        random_states_free(a->x);
    }
    a->x = NULL;
    question_close(a);
    return false;
}

void question_close(question *a)
{
    random_states_free(a->x);
    free(a->payloads);
    free(a->qdd);
    free(a->tau);
    free(a->v);
    free(a->q);
}

void question_load(question *a, const reduction *r, random_source *s, uint32_t count,
                   double *numbers)
{
    a->r.payload_count = count;
    a->r.payloads = numbers;
    a->whole.payload_count = r->payload_count + count;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t link;
        do
            link = random_below(s, (uint32_t)r->whole->link_count);
        while (!present(r, link) || r->model->frame[frame_of(r, link)].part);
        random_payload(s, numbers + (size_t)k * TFA_PAYLOAD_NUMBERS);
        a->r.payload_frames[k] = frame_of(r, link);
        a->whole.payload_frames[r->payload_count + k] = link;
        memcpy(a->payloads + (size_t)(r->payload_count + k) * TFA_PAYLOAD_NUMBERS,
               numbers + (size_t)k * TFA_PAYLOAD_NUMBERS, TFA_PAYLOAD_NUMBERS * sizeof *numbers);
    }
}

uint32_t question_tips(question *a, const reduction *r, uint32_t first, uint32_t most)
{
    uint32_t link = first;
    a->r.tip_count = a->whole.tip_count = 0;
    for (; link < r->whole->link_count && a->r.tip_count < most; link++) {
        if (!present(r, link))
            continue;
        a->whole.tips[a->whole.tip_count++] = link;
        a->r.tips[a->r.tip_count++] = frame_of(r, link);
    }
    return link < r->whole->link_count ? link : 0;
}

static tfa_request advance(const tfa_request *all, uint32_t k, uint32_t nq, uint32_t nv)
{
    tfa_request one = *all;
    one.count = 1;
    one.q += (size_t)k * nq;
    one.v += (size_t)k * nv;
    one.tau = one.tau ? one.tau + (size_t)k * nv : NULL;
    one.qdd = one.qdd ? one.qdd + (size_t)k * nv : NULL;
    one.base_pose = one.base_pose ? one.base_pose + 7 * (size_t)k : NULL;
    one.base_twist = one.base_twist ? one.base_twist + 6 * (size_t)k : NULL;
    one.base_wrench = one.base_wrench ? one.base_wrench + 6 * (size_t)k : NULL;
    one.base_acceleration = one.base_acceleration ? one.base_acceleration + 6 * (size_t)k : NULL;
    one.wrenches += 6 * (size_t)one.wrench_count * k;
    return one;
}

tfa_request question_state(const question *a, const reduction *r, uint32_t k, tfa_request *whole)
{
    *whole = advance(&a->whole, k, r->whole_nq, r->whole_nv);
    return advance(&a->r, k, r->nq, r->nv);
}
