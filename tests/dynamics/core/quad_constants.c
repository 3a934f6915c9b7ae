/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * f128 answers for the numbers of the description or of the file, not for constants rounded on the
 * way: it gives the doubles that the oracle gives, which merges nothing and reads the rotations and
 * axes of a file from its text. Tips of 1e12 kg amplify a constant that is off
 * by 1e-16 to an answer that is off by 1e-4; here such answers agree to the last bit, so that
 * constants are right to 1e-28.
 */
#include "models.h"
#include "support/fixture.h"
#include "support/oracle_motion.h"
#include "test.h"

#define BOUND 0x1p-52 /* both are rounded to double at the end */
#define HEAVY 1e12
#define STATED 1e-31 /* a double and what it leaves hold 107 bits */

static double worst;

static void compare(const test_robot *robot, const tfa_request *request, const random_states *x)
{
    const uint32_t n = robot->n, six = n - robot->nv;
    double *want = calloc(2 * (size_t)n + 72, sizeof *want), *got = want + n;
    double *want_lambda = want + 2 * n, *got_lambda = want_lambda + 36;
    tfa_request r = *request;
    tfa_reply reply = {.qdd = got + six, .base_acceleration = got};
    oracle_set_state(robot->o, &r, 0);
    oracle_forward(robot->o, x->tau, x->base_wrench, want + six, want);
    compute_ok(robot, robot->f128, &r, &reply);
    assert_within(robot, "qdd", relative_error(got, want, n), BOUND, &worst);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.qdd = x->qdd;
    r.base_acceleration = six ? x->base_acceleration : NULL;
    reply = (tfa_reply){.tau = got + six, .base_wrench = got};
    oracle_inverse(robot->o, x->qdd, x->base_acceleration, want + six, want);
    compute_ok(robot, robot->f128, &r, &reply);
    assert_within(robot, "tau", relative_error(got, want, n), BOUND, &worst);
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.tip_count = 1;
    r.tips[0] = (uint32_t)robot->description->link_count - 1;
    reply = (tfa_reply){.lambda_inv = got_lambda};
    oracle_lambda_inv(robot->o, r.tips, 1, r.frame, want_lambda);
    compute_ok(robot, robot->f128, &r, &reply);
    assert_within(robot, "lambda_inv", relative_error(got_lambda, want_lambda, 36), BOUND, &worst);
    free(want);
}

static void without_payload(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, 1, 2);
    const tfa_request r = fixture_request(robot, x);
    compare(robot, &r, x);
    random_states_free(x);
}

static void with_payloads(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, 1, 2);
    random_source s = {robot->seed};
    double payload[2 * TFA_PAYLOAD_NUMBERS];
    tfa_request r = fixture_request(robot, x);
    random_payload(&s, payload);
    random_payload(&s, payload + TFA_PAYLOAD_NUMBERS);
    r.payload_count = 2;
    r.payloads = payload;
    for (int k = 0; k < 2; k++)
        r.payload_frames[k] = random_below(&s, (uint32_t)robot->description->link_count);
    compare(robot, &r, x);
    random_states_free(x);
}

static double distance(const mat3 *a, const mat3 *b)
{
    quad sum = 0;
    for (int k = 0; k < 3; k++) {
        const vec3 d = vec_sub(a->col[k], b->col[k]);
        sum += vec_dot(d, d);
    }
    return (double)quad_sqrt(sum);
}

/* The description holds the rotations and axes of the text. */
static void assert_stated(const tfa_description *d, const oracle_text *text)
{
    for (size_t k = 0; k < d->link_count; k++) {
        const mat3 turn = mat_from_quaternion_parts(d->links[k].quat, d->links[k].quat_low);
        assert_true(distance(&turn, &text->link[k]) < STATED);
    }
    for (size_t k = 0; k < d->joint_count; k++) {
        const tfa_joint *j = &d->joints[k];
        const mat3 turn = mat_from_quaternion_parts(j->quat, j->quat_low);
        assert_true(distance(&turn, &text->joint[k]) < STATED);
        if (j->type == TFA_JOINT_FIXED || j->type == TFA_JOINT_FLOATING)
            continue;
        const vec3 axis = vec_from_parts(j->axis, j->axis_low);
        const vec3 off = vec_sub(axis, vec_unit(text->axis[k]));
        assert_true(vec_dot(off, off) < STATED * STATED);
    }
}

static uint32_t files;

/* Against the text where the robot has one */
static void as_stated(test_robot *robot)
{
    oracle_text *text = NULL;
    if (robot->path[0]) {
        text = oracle_text_load(robot->path, robot->description);
        oracle_use_text(robot->o, text);
        assert_stated(robot->description, text);
        files++;
    }
    without_payload(robot);
    oracle_use_text(robot->o, NULL);
    oracle_text_free(text);
}

TEST(every_robot)
{
    worst = 0;
    files = 0;
    for_every_robot(as_stated, false);
    assert_true(files > 0);
    print_message("  files %u, worst %.2g\n", (unsigned)files, worst);
}

static void make_heavy(tfa_link *link)
{
    link->mass *= HEAVY;
    for (int k = 0; k < 6; k++)
        link->inertia[k] *= HEAVY;
}

/* The last link with mass of a file, 1e12 times what it is */
static void with_heavy_link(test_robot *robot)
{
    if (!robot->path[0])
        return;
    tfa_description *d = robot->description;
    size_t last = d->link_count - 1;
    while (last > 0 && !(d->links[last].mass > 0))
        last--;
    make_heavy(&d->links[last]);
    test_robot heavy;
    fixture_open_description(robot->name, d, robot->base, &heavy);
    snprintf(heavy.path, sizeof heavy.path, "%s", robot->path);
    heavy.seed = robot->seed;
    as_stated(&heavy);
    fixture_close(&heavy);
}

TEST(files_with_a_heavy_link)
{
    worst = 0;
    for_every_robot(with_heavy_link, false);
    print_message("  worst %.2g\n", worst);
}

TEST(every_robot_with_payloads)
{
    worst = 0;
    for_every_robot(with_payloads, true);
    print_message("  worst %.2g\n", worst);
}

/* The last link on a random robot, 1e12 times what it was */
TEST(heavy_tips)
{
    worst = 0;
    for (uint64_t seed = 1; seed <= 48; seed++) {
        const random_robot_options options = {.shape = (random_shape)(seed % 3),
                                              .joints = 4 + (uint32_t)(seed % 7),
                                              .all_types = seed % 2 == 0,
                                              .fixed_fraction = 0.3};
        test_robot r;
        tfa_description *d = random_robot_create(seed, &options);
        make_heavy(&d->links[d->link_count - 1]);
        fixture_open_description("heavy tip", d, seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED,
                                 &r);
        r.seed = seed;
        without_payload(&r);
        fixture_close(&r);
        random_robot_free(d);
    }
    print_message("  worst %.2g\n", worst);
}

/* Three numbers with 2 to 17 digits */
static void put_vector(FILE *out, random_source *s, const char *name, double most)
{
    const int digits = 2 + (int)random_below(s, 16);
    fprintf(out, " %s=\"", name);
    for (int k = 0; k < 3; k++)
        fprintf(out, "%s%.*g", k ? " " : "", digits, random_uniform(s, -most, most));
    fputs("\"", out);
}

static void put_link(FILE *out, random_source *s, uint32_t k, double scale)
{
    const double mass = scale * random_uniform(s, 0.5, 2);
    fprintf(out, "<link name=\"l%u\"><inertial><origin", (unsigned)k);
    put_vector(out, s, "xyz", 0.2);
    put_vector(out, s, "rpy", 4);
    fprintf(out, "/><mass value=\"%.17g\"/><inertia ixy=\"0\" ixz=\"0\" iyz=\"0\"", mass);
    for (int i = 0; i < 3; i++)
        fprintf(out, " i%c%c=\"%.17g\"", 'x' + i, 'x' + i, mass * random_uniform(s, 0.02, 0.03));
    fputs("/></inertial></link>\n", out);
}

/* Rotations, and axes of any length */
static void put_joint(FILE *out, random_source *s, uint32_t child, const char *type)
{
    const uint32_t parent = random_below(s, 2) ? child - 1 : random_below(s, child);
    fprintf(out,
            "<joint name=\"j%u\" type=\"%s\"><parent link=\"l%u\"/><child link=\"l%u\"/><origin",
            (unsigned)child, type, (unsigned)parent, (unsigned)child);
    put_vector(out, s, "xyz", 0.5);
    put_vector(out, s, "rpy", 4);
    fputs("/><axis", out);
    put_vector(out, s, "xyz", 2);
    fputs("/></joint>\n", out);
}

/* The text of a random robot with a tip of 1e12 kg; release with free(). */
static char *random_text(uint64_t seed, size_t *length)
{
    static const char *const types[] = {"revolute", "continuous", "prismatic",
                                        "fixed",    "planar",     "floating"};
    random_source s = {seed};
    const uint32_t joints = 4 + random_below(&s, 7), kinds = seed % 2 ? 6 : 1;
    char *text = NULL;
    FILE *out = open_memstream(&text, length);
    assert_non_null(out);
    fputs("<robot name=\"random\">\n", out);
    for (uint32_t k = 0; k <= joints; k++) {
        put_link(out, &s, k, k == joints ? HEAVY : 1);
        if (k > 0)
            put_joint(out, &s, k, types[k == joints ? 0 : random_below(&s, kinds)]);
    }
    fputs("</robot>\n", out);
    assert_int_equal(fclose(out), 0);
    return text;
}

TEST(random_texts)
{
    worst = 0;
    for (uint64_t seed = 1; seed <= 96; seed++) {
        test_robot r;
        size_t length;
        tfa_description *d;
        tfa_report report = {0};
        char *text = random_text(seed, &length);
        assert_int_equal(tfa_urdf_parse(text, length, "text", &d, &report), TFA_OK);
        oracle_text *stated = oracle_text_read(text, d);
        assert_stated(d, stated);
        fixture_open_description("random text", d,
                                 seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED, &r);
        r.seed = seed;
        oracle_use_text(r.o, stated);
        without_payload(&r);
        fixture_close(&r);
        tfa_description_free(d);
        oracle_text_free(stated);
        tfa_report_free(&report);
        free(text);
    }
    print_message("  worst %.2g\n", worst);
}
