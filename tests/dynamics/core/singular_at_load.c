/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot is refused for a mass matrix that is singular at every q if and only if the oracle's M is
 * singular at random ones: random chains and trees of few links, most of them without mass, with
 * axes along coordinate axes and origins on them, so that motions coincide often.
 */
#include "support/fixture.h"
#include "support/small_robot.h"
#include "test.h"

#define LINKS 7
#define MOST 64 /* freedoms */
#define ROBOTS test_extent(500, 4000)
#define CONFIGURATIONS 3
#define MASS 1.37  /* no inertia is exactly 1, which stands for a row of zeros in the oracle's M */
#define ZERO 1e-10 /* of a pivot of M, scaled to unit diagonal and given in double */

static void make(small_robot *r, random_source *s)
{
    static const tfa_joint_type types[] = {
        TFA_JOINT_REVOLUTE, TFA_JOINT_REVOLUTE, TFA_JOINT_REVOLUTE, TFA_JOINT_PRISMATIC,
        TFA_JOINT_FIXED,    TFA_JOINT_PLANAR,   TFA_JOINT_FLOATING};
    const uint32_t links = 2 + random_below(s, LINKS - 1);
    small_robot_begin(r);
    for (uint32_t k = 0; k + 1 < links; k++) {
        const tfa_joint_type type = types[random_below(s, sizeof types / sizeof *types)];
        tfa_joint *j =
            small_robot_add(r, random_below(s, 4) ? k : random_below(s, k + 1), type, 0, 0, 0);
        j->axis[random_below(s, 3)] = 1;
        j->xyz[random_below(s, 3)] = random_below(s, 3) ? 0 : 0.5;
        if (random_below(s, 4) == 0)
            random_quaternion(s, j->quat);
        if (random_below(s, 8) == 0)
            j->armature = 0.1;
    }
    for (uint32_t k = 0; k < links; k++) {
        tfa_link *l = &r->link[k];
        if (random_below(s, 3) == 0 || k + 1 == links)
            l->mass = MASS;
        if (l->mass > 0 && random_below(s, 3) > 0) /* else a point, or a rod */
            for (int e = 0; e < 6; e += e ? 2 : 3) /* ixx iyy izz */
                l->inertia[e] = random_below(s, 4) ? 0.1 : 0;
        if (l->mass > 0)
            l->com[random_below(s, 3)] = random_below(s, 2) ? 0.3 : 0;
    }
}

/* The smallest pivot of M, scaled to unit diagonal, largest first */
static double least_pivot(double *M, uint32_t n)
{
    double scale[MOST], least = 1;
    for (uint32_t i = 0; i < n; i++) {
        if (!(M[i * n + i] > 1e-14) || M[i * n + i] == 1) /* zero, but for rounding */
            return 0;
        scale[i] = 1 / sqrt(M[i * n + i]);
    }
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < n; k++)
            M[i * n + k] *= scale[i] * scale[k];
    uint8_t done[MOST] = {0};
    for (uint32_t step = 0; step < n; step++) {
        uint32_t p = n;
        for (uint32_t i = 0; i < n; i++)
            if (!done[i] && (p == n || M[i * n + i] > M[p * n + p]))
                p = i;
        const double pivot = M[p * n + p];
        least = fmin(least, pivot);
        if (!(pivot > ZERO))
            return least;
        done[p] = 1;
        for (uint32_t i = 0; i < n; i++)
            for (uint32_t k = 0; k < n; k++)
                if (!done[i] && !done[k])
                    M[i * n + k] -= M[i * n + p] * M[p * n + k] / pivot;
    }
    return least;
}

/* The largest of the smallest pivots at random q */
static double oracle_pivot(const tfa_description *d, tfa_base base, uint64_t seed)
{
    static double M[MOST * MOST];
    oracle *o = oracle_create(d, base);
    random_states *x = random_states_create(seed, d, o, CONFIGURATIONS, 0);
    const uint32_t n = oracle_freedoms(o);
    const tfa_request r = {.count = CONFIGURATIONS,
                           .q = x->q,
                           .v = x->v,
                           .base_pose = x->base_pose,
                           .base_twist = x->base_twist,
                           .gravity = x->gravity};
    double best = n ? 0 : 1;
    assert_true(n <= MOST);
    for (uint32_t k = 0; n && k < CONFIGURATIONS; k++) {
        oracle_set_state(o, &r, k);
        oracle_mass_matrix(o, M);
        best = fmax(best, least_pivot(M, n));
    }
    random_states_free(x);
    oracle_free(o);
    return best;
}

TEST(refused_if_and_only_if_singular)
{
    uint32_t refused = 0, sound = 0, other = 0;
    for (uint64_t seed = 1; seed <= ROBOTS; seed++) {
        static small_robot r;
        random_source s = {seed};
        tfa_report report = {0};
        tfa_model *model = NULL;
        make(&r, &s);
        const tfa_model_options options = {.base = seed % 3 ? TFA_BASE_FIXED : TFA_BASE_FLOATING};
        const int status = tfa_model_create(&r.d, &options, &report, &model);
        if (status == TFA_E_MODEL) { /* seven joints in a row */
            other++;
        } else {
            const double pivot = oracle_pivot(&r.d, options.base, seed);
            if ((status == TFA_OK) != (pivot > ZERO))
                fail_msg("seed %u: %s, pivot %.2g: %s", (unsigned)seed, tfa_status_name(status),
                         pivot, report.count ? report.messages[report.count - 1].text : "");
            refused += status != TFA_OK;
            sound += status == TFA_OK;
        }
        tfa_model_free(model);
        tfa_report_free(&report);
    }
    print_message("  %u refused, %u sound, %u refused for another reason\n", (unsigned)refused,
                  (unsigned)sound, (unsigned)other);
    assert_true(refused > ROBOTS / 10 && sound > ROBOTS / 10);
}
