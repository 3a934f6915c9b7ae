/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The total forces that the algorithm solves for, F of its block rows, are the answer joint_forces,
 * which knows nothing of them: in quadruple precision, for every length of chain.
 */
#include "dynamics/chain/chain.h"
#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "support/chains_state.h"
#include "support/fixture.h"
#include "test.h"

#define LONGEST 60
#define BOUND 1e-15 /* the answer is rounded to double */

static double worst;
static uint32_t compared;

/* F of a body, linear first, in the frame of its link */
static void total_force(const struct state *s, uint32_t frame, const struct row *row, double F[6])
{
    const svec f = sv_from(row->F);
    const xform at = frame_in_body(s, frame);
    const vec3 force = m3_tmul(at.E, f.v), moment = m3_tmul(at.E, v3_sub(f.w, v3_cross(at.r, f.v)));
    const num x[6] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
    for (int e = 0; e < 6; e++)
        F[e] = (double)x[e];
}

/* Joint forces of accelerations that are doubles; F of the torques that belong to these, in quad */
static void compare(struct bench *b, const double base_acceleration[6])
{
    static num tau[6 * LONGEST + 6], qdd[6 * LONGEST + 6];
    double forces[LONGEST + 1][6], F[LONGEST + 1][6], size = 0;
    struct state *s = bench_state(b);
    const struct tfa_chain *chain = b->model->chain;
    tfa_request r = bench_request(b);
    tfa_reply reply = {.joint_forces = forces[0]};
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.flags = TFA_WANT_JOINT_FORCES;
    r.frame = TFA_FRAME_LOCAL;
    r.qdd = b->tau;
    r.base_acceleration = base_acceleration;
    TFA_V(load)(s, &r, 0, 1);
    TFA_V(rnea)(s, s->qdd, tau, 1);
    assert_int_equal(TFA_V(factor)(s, TFA_METHOD_TFA), TFA_OK);
    TFA_V(chain_solve)(s, TFA_V(method)(TFA_METHOD_TFA)->chain, tau, qdd, 1);
    for (uint32_t f = 0; f < b->model->frames; f++) {
        const int32_t body = b->model->frame[f].body;
        if (body >= 0)
            total_force(s, f, (const struct row *)s->rows + s->body[body].depth - 1, F[f]);
    }
    assert_true(TFA_V(answer_joint_forces)(s, &r, s->by, 0, 0, &reply));
    for (uint32_t f = 0; f < b->model->frames; f++)
        for (int e = 0; e < 6 && b->model->frame[f].body >= 0; e++)
            size = fmax(size, fabs(forces[f][e]));
    for (uint32_t f = 0; f < b->model->frames; f++)
        for (int e = 0; e < 6 && b->model->frame[f].body >= 0; e++) {
            const double error = fabs(forces[f][e] - F[f][e]) / size;
            if (!(error <= BOUND))
                fail_msg("%s, %u links, link %u, %d: %g and %g of %g", b->d->name, (unsigned)b->n,
                         (unsigned)f, e, forces[f][e], F[f][e], size);
            worst = fmax(worst, error);
            compared++;
        }
    assert_int_equal(chain->length, s->bodies);
}

TEST(total_forces)
{
    static const chain_mechanism kinds[] = {CHAIN_MIXED, CHAIN_RANDOM, CHAIN_ALTERNATING};
    static const double base_acceleration[6] = {1, -2, 3, 0.4, -0.5, 0.6};
    for (uint32_t links = 1; links <= LONGEST; links++)
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            const tfa_base base = (links + k) % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
            struct bench b = bench_open(kinds[k], links, base, links);
            compare(&b, base == TFA_BASE_FLOATING ? base_acceleration : NULL);
            bench_close(&b);
        }
    print_message("  worst of %u, in doubles: %.1e, bound %g\n", (unsigned)compared, worst, BOUND);
    assert_true(compared > 6 * LONGEST);
}

/* M^-1 by columns is symmetric, though none of the factors of (59) is. */
TEST(inverse_of_the_mass_matrix)
{
    static num inverse[LONGEST][LONGEST + 6], unit[LONGEST + 6];
    num off = 0, size = 0;
    struct bench b = bench_open(CHAIN_RANDOM, LONGEST, TFA_BASE_FIXED, 1);
    struct state *s = bench_state(&b);
    const struct chain_method *tfa = TFA_V(method)(TFA_METHOD_TFA)->chain;
    assert_int_equal(TFA_V(factor)(s, TFA_METHOD_TFA), TFA_OK);
    for (uint32_t i = 0; i < LONGEST; i++) {
        unit[i] = 1;
        TFA_V(chain_solve)(s, tfa, unit, inverse[i], 0);
        unit[i] = 0;
    }
    for (uint32_t i = 0; i < LONGEST; i++)
        for (uint32_t j = 0; j < LONGEST; j++) {
            const num d = num_abs(inverse[i][j] - inverse[j][i]), x = num_abs(inverse[i][j]);
            off = d > off || !(d == d) ? d : off;
            size = x > size ? x : size;
        }
    print_message("  asymmetry %.1e\n", (double)(off / size));
    assert_true(size > 0 && (double)(off / size) <= 1e-25);
    bench_close(&b);
}
