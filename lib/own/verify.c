/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Is what a kernel answers right? Compared with the generic kernel before anybody is served. Relative
 * differences are those of the largest number of an answer.
 */
#include <math.h>
#include <stdio.h>

#include "model/model.h"
#include "own/verify.h"

#define BOUND 1e-10
#define ESTIMATES 100 /* of the generic answer's own error, where it is that ill-conditioned */

/* One array of an answer */
struct piece {
    const char *name;
    const double *own, *other;
    size_t n; /* numbers of a state */
};

/* The arrays that question k asks for; accelerations of base and joints are judged together. */
static uint32_t pieces_of(const struct trial *t, uint32_t k, struct piece p[4])
{
    const tfa_request *r = &t->request;
    const tfa_reply *a = &t->own.reply, *b = &t->other.reply;
    const size_t nv = t->model->v_count, n = (size_t)36 * r->tip_count * r->tip_count;
    const size_t poses = (size_t)7 * r->tip_count;
    const size_t base = t->model->base_freedoms;
    uint32_t count = 0;
    if (r->op == TFA_OP_FORWARD_DYNAMICS) {
        p[count++] = (struct piece){"qdd", a->qdd + nv * k, b->qdd + nv * k, nv};
        p[count++] = (struct piece){"base_acceleration", a->base_acceleration + base * k,
                                    b->base_acceleration + base * k, base};
    } else if (r->op == TFA_OP_INVERSE_DYNAMICS) {
        p[count++] = (struct piece){"tau", a->tau + nv * k, b->tau + nv * k, nv};
        p[count++] = (struct piece){"base_wrench", a->base_wrench + base * k,
                                    b->base_wrench + base * k, base};
    }
    if (r->tip_count)
        p[count++] = (struct piece){"lambda_inv", a->lambda_inv + n * k, b->lambda_inv + n * k, n};
    if (r->flags & TFA_WANT_POSES)
        p[count++] = (struct piece){"poses", a->poses + poses * k, b->poses + poses * k, poses};
    return count;
}

static double largest(const double *x, size_t n)
{
    double most = 0;
    for (size_t e = 0; e < n; e++)
        most = fmax(most, fabs(x[e]));
    return most;
}

/* Not a number where one of both is not. */
static double difference(const struct piece *p)
{
    double most = 0;
    for (size_t e = 0; e < p->n; e++) {
        const double d = fabs(p->own[e] - p->other[e]);
        if (!(d <= most))
            most = d;
        if (isnan(d))
            return d;
    }
    return most;
}

/* State k of the question; updates *error. Returns the piece that is wrong, or NULL. */
static const char *judge(const struct trial *t, uint32_t k, double *wrong, double *error)
{
    struct piece p[4];
    const uint32_t count = pieces_of(t, k, p);
    const double estimate = t->other.answers[k].error_estimate;
    const double bound = estimate * ESTIMATES > BOUND ? estimate * ESTIMATES : BOUND;
    const int motion = t->request.op != TFA_OP_OPERATIONAL_INERTIA;
    const double together =
        motion ? fmax(largest(p[0].other, p[0].n), largest(p[1].other, p[1].n)) : 0;
    for (uint32_t i = 0; i < count; i++) {
        const double size = motion && i < 2 ? together : largest(p[i].other, p[i].n);
        const double relative = size > 0 ? difference(&p[i]) / size : difference(&p[i]);
        if (!(relative <= bound)) {
            *wrong = relative;
            return p[i].name;
        }
        if (bound <= BOUND)
            *error = fmax(*error, relative);
    }
    return NULL;
}

/* ---- asking it ---- */

/* States that `one` or, `lanes` at a time, `many` answers; done[k] says which. */
static void answer(struct trial *t, const struct tfa_own_kernel *kernel, uint32_t lanes,
                   uint8_t done[TRIAL_STATES])
{
    const uint32_t count = t->request.count;
    for (uint32_t k = 0; k < count;) {
        const uint32_t some = !lanes ? 1 : count - k < lanes ? count - k : lanes;
        tfa_reply reply = t->own.reply;
        reply.answers = NULL;
        const int sound = lanes ? kernel->many(&t->host, &t->request, k, some, &reply)
                                : kernel->one(&t->host, &t->request, k, &reply);
        for (uint32_t l = 0; l < some; l++)
            done[k + l] = sound != 0;
        k += some;
    }
}

static int complain(struct own_reason *why, const char *path, const char *question, uint32_t lanes,
                    const char *piece, uint32_t k, double wrong)
{
    char size[48] = "has numbers that were not written, or are none";
    if (!isnan(wrong))
        snprintf(size, sizeof size, "is off by %.2g of its size", wrong);
    return own_refuse(why, TFA_E_NOT_COMPUTED, "'%s' is refused: %s%s: %s of state %u %s", path,
                      question, lanes ? ", several at a time" : "", piece, k, size);
}

static int try_one(struct trial *t, const struct tfa_own_kernel *kernel, const char *path,
                   const struct trial_question *q, uint32_t lanes, double *error,
                   struct own_reason *why)
{
    uint8_t done[TRIAL_STATES] = {0};
    double wrong = 0;
    trial_spoil(t);
    tfa_request r = t->request;
    if (q->op != TFA_OP_INVERSE_DYNAMICS)
        r.estimate = TFA_ESTIMATE_ALWAYS;
    (void)tfa_compute(t->generic, &r, &t->other.reply);
    answer(t, kernel, lanes, done);
    if (!trial_guards_hold(t))
        return own_refuse(why, TFA_E_NOT_COMPUTED,
                          "'%s' is refused: %s: it writes behind the end of an answer", path,
                          q->name);
    for (uint32_t k = 0; k < r.count; k++) {
        if (t->other.answers[k].status != TFA_OK)
            continue;
        t->asked++;
        t->left += !done[k];
        const char *piece = done[k] ? judge(t, k, &wrong, error) : NULL;
        if (piece)
            return complain(why, path, q->name, lanes, piece, k, wrong);
    }
    return TFA_OK;
}

static int try_question(struct trial *t, const struct tfa_own_kernel *kernel, const char *path,
                        const struct trial_question *q, double *error, struct own_reason *why)
{
    int status = TFA_OK;
    tfa_reply checked;
    for (uint32_t tip = q->tips ? 0 : t->model->bodies - 1; status == TFA_OK; tip++) {
        if (tip == t->model->bodies)
            break;
        trial_ask(t, q, tip);
        if (tfa_request_check(t->model, &t->request, &checked) != TFA_OK ||
            !kernel->takes(&t->host, &t->request))
            continue;
        status = try_one(t, kernel, path, q, 0, error, why);
        if (status == TFA_OK && kernel->lanes && !q->tips)
            status = try_one(t, kernel, path, q, kernel->lanes, error, why);
    }
    return status;
}

int own_verify(const char *path, const struct tfa_own_kernel *kernel, const tfa_model *model,
               double *error, struct own_reason *why)
{
    struct trial t;
    const struct trial_question *q;
    *error = 0;
    int status = trial_open(&t, model);
    for (uint32_t i = 0; status == TFA_OK && (q = trial_question(i)); i++)
        status = try_question(&t, kernel, path, q, error, why);
    if (status == TFA_OK && 2 * t.left >= t.asked)
        status = own_refuse(why, TFA_E_NOT_COMPUTED,
                            "'%s' is refused: it left %u of %u states to the generic kernel", path,
                            t.left, t.asked);
    trial_close(&t);
    return status;
}
