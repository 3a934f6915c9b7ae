/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Links become bodies: the order of the joints, and fixed joints merged without a trace in the
 * answers. The witness is the same robot with each fixed joint made a revolute one that rests at
 * zero: its torques and its M, at the joints that both have, must be the same.
 */
#include "hand.h"
#include "models.h"
#include "test.h"

#define MAX_ROWS (HAND_LINKS * 6 + 6)
#define G 9.80665

static tfa_workspace *workspace(const tfa_model *m)
{
    tfa_workspace *w = workspace_for(m, NULL);
    return w;
}

TEST(test_order)
{
    hand h;
    hand_begin(&h);
    for (int k = 0; k < 6; k++) {
        static const char *const names[] = {"l0", "l1", "l2", "l3", "l4", "l5"};
        hand_link(&h, names[k], 1, 0.1, 0, 0);
    }
    hand_joint(&h, "third", TFA_JOINT_FLOATING, 3, 4);
    hand_joint(&h, "fourth", TFA_JOINT_PRISMATIC, 5, 0);
    hand_joint(&h, "second", TFA_JOINT_PLANAR, 1, 3);
    hand_joint(&h, "none", TFA_JOINT_FIXED, 5, 2);
    hand_joint(&h, "first", TFA_JOINT_CONTINUOUS, 2, 1);
    tfa_model *m = hand_model(&h, NULL);
    static const tfa_joint_info expected[] = {
        {"first", TFA_JOINT_CONTINUOUS, 0, 1, 0, 1, 0, 0, 0, 0, 1},
        {"second", TFA_JOINT_PLANAR, 1, 3, 1, 3, 1, 0, 0, 0, 1},
        {"third", TFA_JOINT_FLOATING, 4, 7, 4, 6, 2, 0, 0, 0, 1},
        {"fourth", TFA_JOINT_PRISMATIC, 11, 1, 10, 1, 3, 0, 0, 0, 1},
    };
    static const int32_t parents[] = {-1, 0, 1, -1};
    static const int32_t bodies[] = {3, 0, -1, 1, 2, -1}; /* of the links, in their own order */
    assert_int_equal(tfa_model_joint_count(m), 4);
    for (uint32_t k = 0; k < 4; k++) {
        tfa_joint_info j = tfa_model_joint(m, k), e = expected[k];
        assert_string_equal(j.name, e.name);
        assert_int_equal(j.type, e.type);
        assert_int_equal(j.q_index, e.q_index);
        assert_int_equal(j.q_count, e.q_count);
        assert_int_equal(j.v_index, e.v_index);
        assert_int_equal(j.v_count, e.v_count);
        assert_int_equal(j.body, e.body);
        assert_int_equal(tfa_model_body_parent(m, e.body), parents[k]);
    }
    for (uint32_t k = 0; k < 6; k++) {
        assert_string_equal(tfa_model_frame(m, k).name, h.link[k].name);
        assert_int_equal(tfa_model_frame(m, k).body, bodies[k]);
    }
    tfa_model_summary s = tfa_model_summarise(m);
    assert_int_equal(s.links, 6);
    assert_int_equal(s.joints, 5);
    assert_int_equal(s.bodies, 4);
    assert_int_equal(s.q_count, 12);
    assert_int_equal(s.v_count, 11);
    assert_int_equal(s.depth, 3);
    assert_int_equal(s.main_chain, 3);
    tfa_model_free(m);
}

/* Two masses on one body, the second turned by 90 degrees: its holding torque by hand. */
TEST(test_gravity_torque)
{
    hand h;
    hand_begin(&h);
    hand_link(&h, "base", 1, 5, 5, 5);
    hand_link(&h, "arm", 2, 0.3, 0, 0);
    hand_link(&h, "tool", 3, 0.2, 0, 0);
    hand_joint(&h, "pivot", TFA_JOINT_REVOLUTE, 0, 1);
    tfa_joint *fixed = hand_joint(&h, "mount", TFA_JOINT_FIXED, 1, 2);
    fixed->xyz[0] = 0.5;
    fixed->xyz[2] = 0.1;
    fixed->quat[2] = fixed->quat[3] = sqrt(0.5); /* about z: its x is the arm's y */
    tfa_model *m = hand_model(&h, NULL);
    tfa_model_summary s = tfa_model_summarise(m);
    assert_int_equal(s.bodies, 1);
    hand_near(s.total_mass, 6, 1e-15);
    hand_near(s.moving_mass, 5, 1e-15);
    tfa_workspace *w = workspace(m);
    for (int k = -3; k <= 3; k++) {
        double q = k, tau = 0;
        const tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS, .count = 1, .q = &q};
        tfa_reply reply = {.tau = &tau};
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        const double mx = 2 * 0.3 + 3 * 0.5, mz = 3 * 0.1;
        hand_near(tau, -G * (mx * cos(q) + mz * sin(q)), 1e-13);
    }
    tfa_workspace_free(w);
    tfa_model_free(m);
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    m = hand_model(&h, &floating);
    hand_near(tfa_model_summarise(m).moving_mass, 6, 1e-15);
    tfa_model_free(m);
}

static void rotate(double quat[4], double x, double y, double z, double w)
{
    double n = sqrt(x * x + y * y + z * z + w * w);
    quat[0] = x / n;
    quat[1] = y / n;
    quat[2] = z / n;
    quat[3] = w / n;
}

static tfa_joint *put(tfa_joint *j, double x, double y, double z)
{
    j->xyz[0] = x;
    j->xyz[1] = y;
    j->xyz[2] = z;
    rotate(j->quat, x + 0.3, y - 0.2, z + 0.1, 0.7);
    return j;
}

/* root =mount= turret -a- upper =plate= bracket =hook= cradle -b- lower =grip= finger, with a
 * branch bracket -c- slider; = is fixed. All frames are turned, all axes oblique. */
static void make_merged(hand *h)
{
    static const char *const names[] = {"root",   "turret", "upper",  "bracket", "cradle",
                                        "slider", "lower",  "finger", "eye"};
    hand_begin(h);
    for (uint32_t k = 0; k < 9; k++) {
        uint32_t l = hand_link(h, names[k], 1 + 0.5 * k, 0.05 * k, 0.1 - 0.02 * k, 0.03);
        rotate(h->link[l].quat, 0.1 * k, 0.5, -0.2, 0.6);
        h->link[l].inertia[0] *= 1.4;
        h->link[l].inertia[1] = 0.002;
        h->link[l].inertia[4] = -0.001;
    }
    h->link[8].mass = 0; /* a frame and nothing else */
    memset(h->link[8].inertia, 0, sizeof h->link[8].inertia);
    put(hand_joint(h, "mount", TFA_JOINT_FIXED, 0, 1), 0.1, 0, 0.4);
    put(hand_joint(h, "plate", TFA_JOINT_FIXED, 2, 3), 0, 0.2, 0.1);
    put(hand_joint(h, "hook", TFA_JOINT_FIXED, 3, 4), 0.2, 0.1, -0.1);
    put(hand_joint(h, "a", TFA_JOINT_REVOLUTE, 1, 2), -0.1, 0.1, 0.2)->axis[0] = 0.5;
    put(hand_joint(h, "b", TFA_JOINT_REVOLUTE, 4, 6), 0.3, 0, 0)->axis[2] = -2;
    put(hand_joint(h, "c", TFA_JOINT_PRISMATIC, 3, 5), 0, -0.2, 0.2)->axis[0] = -0.3;
    put(hand_joint(h, "grip", TFA_JOINT_FIXED, 6, 7), 0.1, 0.1, 0.1);
    put(hand_joint(h, "lens", TFA_JOINT_FIXED, 7, 8), 0, 0.05, 0);
}

/* The same motion of both robots, with a wrench on link `link`, in `frame`. */
struct motion {
    tfa_base base;
    uint32_t link;
    tfa_reference_frame frame;
};

struct answer {
    double tau[MAX_ROWS], base_wrench[6], M[MAX_ROWS * MAX_ROWS];
};

/* q, v and qdd by the names of the joints; those of one letter move. */
static void fill(const tfa_model *m, double *q, double *v, double *qdd)
{
    for (uint32_t k = 0; k < tfa_model_joint_count(m); k++) {
        const char *name = tfa_model_joint(m, k).name;
        double x = name[1] == '\0' ? name[0] - 'a' + 1 : 0;
        q[k] = 0.7 * x;
        v[k] = x - 1.7 * (x > 0);
        qdd[k] = 0.3 * x * x;
    }
}

static void answer_motion(const tfa_model *m, const struct motion *motion, struct answer *out)
{
    static const double pose[7] = {0.3, -0.2, 0.9, 0.5, -0.5, 0.5, 0.5};
    static const double twist[6] = {0.4, 0.1, -0.3, 0.2, -0.6, 0.5};
    static const double wrench[6] = {3, -7, 5, 1.1, 0.4, -2};
    double q[HAND_LINKS], v[HAND_LINKS], qdd[HAND_LINKS];
    fill(m, q, v, qdd);
    tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS,
                     .frame = motion->frame,
                     .count = 1,
                     .wrench_count = 1,
                     .q = q,
                     .v = v,
                     .qdd = qdd,
                     .wrenches = wrench};
    r.wrench_frames[0] = motion->link;
    if (motion->base == TFA_BASE_FLOATING) {
        r.base_pose = pose;
        r.base_twist = r.base_acceleration = twist;
    }
    tfa_reply reply = {.tau = out->tau, .base_wrench = out->base_wrench, .mass_matrix = out->M};
    tfa_workspace *w = workspace(m);
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    r.op = TFA_OP_MASS_MATRIX;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    tfa_workspace_free(w);
}

/* Row of M for row k of the merged model in the witness. */
static uint32_t row_of(const tfa_model *merged, const tfa_model *honest_client, uint32_t k)
{
    uint32_t base = tfa_model_base_freedoms(merged);
    if (k < base)
        return k;
    int32_t j = tfa_model_find_joint(honest_client, tfa_model_joint(merged, k - base).name);
    assert_true(j >= 0);
    return base + (uint32_t)j;
}

static void compare(const tfa_model *merged, const tfa_model *honest_client,
                    const struct motion *motion)
{
    static struct answer a, b;
    answer_motion(merged, motion, &a);
    answer_motion(honest_client, motion, &b);
    const uint32_t base = tfa_model_base_freedoms(merged), nv = tfa_model_v_count(merged);
    const uint32_t n = base + nv, wide = base + tfa_model_v_count(honest_client);
    for (uint32_t k = 0; k < n; k++) {
        uint32_t row = row_of(merged, honest_client, k);
        double x = k < base ? a.base_wrench[k] : a.tau[k - base];
        double y = k < base ? b.base_wrench[k] : b.tau[row - base];
        if (!(fabs(x - y) <= 1e-11 * (1 + fabs(y))))
            fail_msg("force %u: %.17g and %.17g (wrench on link %u, frame %d)", (unsigned)k, x, y,
                     (unsigned)motion->link, (int)motion->frame);
        for (uint32_t j = 0; j < n; j++) {
            double p = a.M[k * n + j], s = b.M[row * wide + row_of(merged, honest_client, j)];
            if (!(fabs(p - s) <= 1e-12 * (1 + fabs(s))))
                fail_msg("M %u %u: %.17g and %.17g", (unsigned)k, (unsigned)j, p, s);
        }
    }
}

/* A wrench on every link, frames of merged links included: J^T of each is right only if the frame
 * kept its pose. */
TEST(test_merged_is_unmerged)
{
    hand h;
    for (int base = 0; base < 2; base++) {
        const tfa_model_options options = {.base = base ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
        make_merged(&h);
        tfa_model *merged = hand_model(&h, &options);
        assert_int_equal(tfa_model_summarise(merged).bodies, 3 + base);
        for (size_t j = 0; j < h.d.joint_count; j++)
            if (h.joint[j].type == TFA_JOINT_FIXED) {
                h.joint[j].type = TFA_JOINT_REVOLUTE;
                h.joint[j].armature = 1; /* the lens has no mass */
            }
        tfa_model *honest_client = hand_model(&h, &options);
        assert_int_equal(tfa_model_summarise(honest_client).bodies, 8 + base);
        assert_true(tfa_model_summarise(merged).total_mass ==
                    tfa_model_summarise(honest_client).total_mass);
        for (uint32_t link = 0; link < 9; link++)
            for (int frame = TFA_FRAME_LOCAL_WORLD_ALIGNED; frame <= TFA_FRAME_WORLD; frame++) {
                struct motion motion = {options.base, link, (tfa_reference_frame)frame};
                compare(merged, honest_client, &motion);
            }
        tfa_model_free(merged);
        tfa_model_free(honest_client);
    }
}
