/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exact reductions change nothing: hundreds of random robots, each reduced in one way or in
 * several, give the answers of the robot with nothing reduced to 1e-13.
 */
#include "model/model.h"
#include "reductions.h"
#include "test.h"

#define STATES 2
#define WRENCHES 2
#define SEEDS_ALONE 12                      /* for each kind of reduction, on each base */
#define SEEDS_TOGETHER test_extent(60, 250) /* with several, on each base */

/* Lambda^-1 of TFA one-sided is not refined. */
static const reduction_bounds bounds = {1e-13, 1e-13, 1e-13, 2e-11};
static unsigned skipped, robots, fused_joints, inner_frames;

/* ---- structure, mass ---- */

static void check_fate(const reduction *r, const tfa_declared_joint *d)
{
    size_t k = 0;
    while (k < r->whole->joint_count && strcmp(r->whole->joints[k].name, d->name) != 0)
        k++;
    const reduced_joint *j = &r->joint[k];
    if (k == r->whole->joint_count || j->absent) {
        assert_int_equal(d->fate, TFA_FATE_ABSENT);
        return;
    }
    assert_int_equal(d->joint, j->index);
    if (r->whole->joints[k].type == TFA_JOINT_FIXED)
        assert_int_equal(d->fate, TFA_FATE_FIXED);
    else if (j->locked)
        assert_int_equal(d->fate, TFA_FATE_LOCKED);
    else if (j->leader >= 0) {
        assert_true(d->fate == TFA_FATE_FOLLOWS || d->fate == TFA_FATE_FUSED);
        assert_int_equal(d->leader, r->joint[j->leader].index);
        assert_true(d->multiplier == j->multiplier && d->offset == j->offset);
    } else
        assert_true(d->fate == TFA_FATE_MOVES || d->fate == TFA_FATE_FUSED);
}

static void check_structure(const reduction *r)
{
    const uint32_t base = r->n - r->nv;
    uint32_t own = 0;
    assert_int_equal(tfa_model_v_count(r->model), r->nv);
    assert_int_equal(tfa_model_q_count(r->model), r->nq);
    assert_int_equal(tfa_model_base_freedoms(r->model), base);
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const reduced_joint *j = &r->joint[k];
        if (j->index < 0)
            continue;
        tfa_joint_info info = tfa_model_joint(r->model, (uint32_t)j->index);
        assert_string_equal(info.name, r->whole->joints[k].name);
        assert_int_equal(info.type, r->whole->joints[k].type);
        assert_int_equal(base + info.v_index, r->tie[base + j->v].to);
        assert_true(info.armature == r->whole->joints[k].armature);
        own++;
    }
    assert_int_equal(tfa_model_joint_count(r->model), own);
    assert_int_equal(tfa_model_declared_count(r->model), r->file->joint_count);
    for (uint32_t k = 0; k < r->file->joint_count; k++) {
        tfa_declared_joint d = tfa_model_declared(r->model, k);
        check_fate(r, &d);
    }
    fused_joints += tfa_model_summarise(r->model).fused;
    for (uint32_t k = 0; k < r->model->frames; k++)
        inner_frames += r->model->frame[k].part > 0;
}

/* All coordinates 0 but those of joints that are locked or follow; absent links without mass. */
static void check_mass(const reduction *r, question *a)
{
    const size_t links = r->whole->link_count;
    double mass, com[3], pose[7] = {0, 0, 0, 0, 0, 0, 1}, *q = calloc(r->whole_nq + 1, sizeof *q);
    double *masses = calloc(links, sizeof *masses);
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const reduced_joint *j = &r->joint[k];
        if (j->locked)
            memcpy(q + j->q, j->at, j->q_count * sizeof *q);
        else if (j->q_count == 7)
            q[j->q + 6] = 1;
        else if (j->leader >= 0)
            q[j->q] = j->offset;
    }
    for (size_t k = 0; k < links; k++) {
        masses[k] = r->whole->links[k].mass;
        if (tfa_model_find_frame(r->model, r->whole->links[k].name) < 0)
            r->whole->links[k].mass = 0;
    }
    tfa_request at = a->whole;
    at.q = q;
    at.base_pose = pose;
    at.wrench_count = 0;
    oracle_set_state(r->o, &at, 0);
    oracle_mass(r->o, &mass, com);
    for (size_t k = 0; k < links; k++)
        r->whole->links[k].mass = masses[k];
    tfa_model_summary s = tfa_model_summarise(r->model);
    reduction_within(r, "total mass", &s.total_mass, &mass, 1, bounds.f64);
    reduction_within(r, "centre of mass", s.com, com, 3, bounds.f64);
    free(masses);
    free(q);
}

/* ---- one robot ---- */

/* Every link is a tip once, in groups. */
static void check_links(reduction *r, const question *a, uint32_t k)
{
    question tips = *a;
    uint32_t link = 0;
    do {
        tfa_request whole, one;
        link = question_tips(&tips, r, link, REDUCTION_TIPS);
        one = question_state(&tips, r, k, &whole);
        if (one.tip_count)
            reduction_check_lambda(r, &one, &whole, r->tie, &bounds, 3);
    } while (link > 0);
}

static void check(uint64_t seed, uint32_t kinds, tfa_base base)
{
    reduction r;
    question a;
    reduction_open(&r, seed, kinds, base);
    check_structure(&r);
    robots++;
    if (r.n > 0 && question_open(&a, &r, seed, STATES, WRENCHES)) {
        check_mass(&r, &a);
        a.r.frame = a.whole.frame = (tfa_reference_frame)(seed % 3);
        for (uint32_t k = 0; k < STATES; k++) {
            tfa_request whole, one = question_state(&a, &r, k, &whole);
            reduction_check_forward(&r, &one, &whole, r.tie, &bounds);
            reduction_check_inverse(&r, &one, &whole, &bounds);
            check_links(&r, &a, k);
        }
        question_close(&a);
    } else if (r.n > 0) {
        skipped++;
    }
    reduction_close(&r);
}

static void print_tally(void)
{
    reduction_print();
    print_message("  %u robots, %u without a well-conditioned posture, %u joints fused, %u frames "
                  "inside fused bodies\n",
                  robots, skipped, fused_joints, inner_frames);
    assert_true(skipped * 3 < robots);
    robots = skipped = fused_joints = inner_frames = 0;
}

TEST(each_reduction_is_exact)
{
    for (uint32_t kind = 0; kind <= REDUCE_TIPS; kind = kind ? 2 * kind : 1) {
        print_message("  kind %u\n", kind);
        for (uint64_t seed = 1; seed <= SEEDS_ALONE; seed++)
            for (int base = 0; base < 2; base++)
                check(seed, kind, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
        print_tally();
    }
}

TEST(combinations_are_exact)
{
    for (uint64_t seed = 1; seed <= SEEDS_TOGETHER; seed++)
        for (int base = 0; base < 2; base++)
            check(seed, REDUCE_ANYTHING, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
    assert_true(fused_joints > 0 && inner_frames > 0);
    print_tally();
}
