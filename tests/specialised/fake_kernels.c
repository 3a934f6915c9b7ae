/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Kernels that are sound, and kernels that are not: each wrong one is refused with its reason, and
 * the sound one answers in a workspace as the generic kernel does.
 */
#include "bench.h"
#include "models.h"
#include "specialised/specialised_internal.h"
#include "test.h"

/* What each fault of fake_kernel.c leads to */
static const struct {
    const char *fault;
    int status;
    const char *error_text;
} faults[] = {
    {"WRONG_ABI", TFA_E_UNSUPPORTED, "exports version"},
    {"WRONG_SIZES", TFA_E_UNSUPPORTED, "built from other sources"},
    {"WRONG_HASH", TFA_E_UNSUPPORTED, "another model"},
    {"WRONG_ISA", TFA_E_UNSUPPORTED, "instruction set vax"},
    {"NO_TABLE", TFA_E_UNSUPPORTED, "exports no tfa_specialised_kernel"},
    {"HALF_A_TABLE", TFA_E_UNSUPPORTED, "incomplete"},
    {"WRONG_ANSWER", TFA_E_NOT_COMPUTED, "inverse dynamics: tau of state 0"},
    {"WRONG_SEVERAL", TFA_E_NOT_COMPUTED, "several at a time"},
    {"WRONG_RARELY", TFA_E_NOT_COMPUTED, "tau of state 41"},
    {"TAKES_TOO_MUCH", TFA_E_NOT_COMPUTED, "with a payload"},
    {"WRITES_TOO_MUCH", TFA_E_NOT_COMPUTED, "behind the end"},
    {"NEVER_ANSWERS", TFA_E_NOT_COMPUTED, "states to the generic kernel"},
    {"LEAVES_A_HOLE", TFA_E_NOT_COMPUTED, "not written"},
    {"WRONG_FLOATS", TFA_E_NOT_COMPUTED, "in float"},
    {"IGNORES_WRENCHES", TFA_E_NOT_COMPUTED, "with a wrench"},
    {"HALF_OF_FLOATS", TFA_E_UNSUPPORTED, "incomplete"},
};

TEST(faults_are_refused)
{
    bench b;
    char path[256];
    bench_open(&b);
    bench_path(&b, "kernel.so", path);
    for (size_t k = 0; k < sizeof faults / sizeof *faults; k++) {
        bench_build(&b, b.arm, faults[k].fault, path);
        if (bench_load(&b, path) != faults[k].status)
            fail_msg("%s: not refused as it should be: %s", faults[k].fault, b.error_text);
        bench_assert_error_text(&b, faults[k].error_text);
    }
    bench_close(&b);
}

/* clang fuses products, but not where states in lanes would get other bits. */
TEST(fused_products_keep_the_bits)
{
    bench b;
    char path[256];
    bench_open(&b);
    bench_path(&b, "kernel.so", path);
    bench_build(&b, b.arm, "OTHER_WHEN_FUSED", path);
    assert_true(specialised_same_bits(b.arm, path));
    bench_build(&b, b.arm, "WRONG_SEVERAL", path);
    assert_false(specialised_same_bits(b.arm, path));
    bench_close(&b);
}

/* ---- a sound one in a workspace ---- */

#define STATES 11

struct motion {
    double q[STATES * 7], v[STATES * 7], qdd[STATES * 7];
};

static void set_motion(struct motion *m)
{
    for (int k = 0; k < STATES * 7; k++) {
        m->q[k] = 0.4 * (k % 13) - 2;
        m->v[k] = 0.3 * (k % 7) - 1;
        m->qdd[k] = 0.7 * (k % 5) - 1.5;
    }
}

static tfa_workspace *workspace_of(const bench *b, const tfa_specialised *kernel,
                                   tfa_precision precision)
{
    const tfa_workspace_options options = {.precision = precision, .specialised = kernel};
    tfa_workspace *w = workspace_for(b->arm, &options);
    return w;
}

/* Both workspaces, the same request */
static void ask_both(tfa_workspace *specialised, tfa_workspace *generic, const tfa_request *r)
{
    double tau[2][STATES * 7] = {0}, qdd[2][STATES * 7] = {0};
    tfa_answer answers[2][STATES];
    memset(answers, 0, sizeof answers);
    tfa_reply replies[2] = {{.tau = tau[0], .qdd = qdd[0], .answers = answers[0]},
                            {.tau = tau[1], .qdd = qdd[1], .answers = answers[1]}};
    assert_int_equal(tfa_compute(specialised, r, &replies[0]), TFA_OK);
    assert_int_equal(tfa_compute(generic, r, &replies[1]), TFA_OK);
    for (uint32_t k = 0; k < 7 * r->count; k++) {
        assert_true(fabs(tau[0][k] - tau[1][k]) <= 1e-12 * 100);
        assert_true(fabs(qdd[0][k] - qdd[1][k]) <= 1e-9 * (1 + fabs(qdd[1][k])));
    }
    for (uint32_t k = 0; k < r->count; k++) {
        assert_int_equal(answers[0][k].method, answers[1][k].method);
        assert_int_equal(answers[0][k].status, TFA_OK);
        assert_true(isnan(answers[0][k].error_estimate));
    }
}

TEST(a_sound_kernel_answers)
{
    bench b;
    tfa_specialised *kernel;
    struct motion m;
    char path[400], name[TFA_SPECIALISED_NAME_SIZE];
    bench_open(&b);
    tfa_specialised_name(b.arm, name);
    snprintf(path, sizeof path, "%s/%s", b.kernels, name);
    bench_build(&b, b.arm, "SOUND", path);
    assert_int_equal(
        tfa_specialised_find(b.kernels, b.arm, &kernel, b.error_text, sizeof b.error_text), TFA_OK);
    const tfa_specialised_info info = tfa_specialised_describe(kernel);
    assert_string_equal(info.path, path);
    assert_string_equal(info.isa, tfa_isa_name());
    assert_int_equal(info.bodies, 7);
    assert_true(info.error < 1e-10);
    assert_true(info.error > 0); /* it did answer, by other steps than the generic kernel */
    set_motion(&m);
    tfa_workspace *specialised = workspace_of(&b, kernel, TFA_F64),
                  *generic = workspace_of(&b, NULL, TFA_F64);
    for (uint32_t count = 1; count <= STATES; count++) {
        tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = count,
                         .q = m.q,
                         .v = m.v,
                         .qdd = m.qdd};
        ask_both(specialised, generic, &r);
        r.op = TFA_OP_FORWARD_DYNAMICS; /* which it leaves to the generic kernel */
        ask_both(specialised, generic, &r);
    }
    tfa_workspace_free(specialised);
    tfa_workspace_free(generic);
    tfa_specialised_free(kernel);
    bench_close(&b);
}

/* It does answer: the fake kernel's numbers are not to the bit those of the generic kernel. In
 * float it computes doubles as well, unlike the generic kernel. */
static void assert_kernel_answers(tfa_precision precision)
{
    bench b;
    tfa_specialised *kernel;
    struct motion m;
    char path[256];
    double tau[2][7];
    bench_open(&b);
    bench_build(&b, b.arm, "SOUND", bench_path(&b, "kernel.so", path));
    assert_int_equal(tfa_specialised_load(path, b.arm, &kernel, NULL, 0), TFA_OK);
    set_motion(&m);
    const tfa_specialised *both[2] = {kernel, NULL};
    int differs = 0;
    for (int state_of = 0; state_of < STATES; state_of++) {
        for (int k = 0; k < 2; k++) {
            tfa_workspace *w = workspace_of(&b, both[k], precision);
            const tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS,
                                   .count = 1,
                                   .q = m.q + 7 * state_of,
                                   .v = m.v,
                                   .qdd = m.qdd};
            tfa_reply reply = {.tau = tau[k]};
            assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
            tfa_workspace_free(w);
        }
        differs |= memcmp(tau[0], tau[1], sizeof tau[0]) != 0;
    }
    assert_true(differs);
    tfa_specialised_free(kernel);
    bench_close(&b);
}

TEST(it_is_the_kernel_that_answers)
{
    assert_kernel_answers(TFA_F64);
    assert_kernel_answers(TFA_F32);
}

/* Refinement in another precision than that of the factors is the generic kernels'. */
TEST(mixed_precision_is_left_to_the_generic_kernels)
{
    bench b;
    tfa_specialised *kernel;
    struct motion m;
    char path[256];
    double tau[2][STATES * 7];
    bench_open(&b);
    bench_build(&b, b.arm, "SOUND", bench_path(&b, "kernel.so", path));
    assert_int_equal(tfa_specialised_load(path, b.arm, &kernel, NULL, 0), TFA_OK);
    set_motion(&m);
    const tfa_specialised *both[2] = {kernel, NULL};
    for (int k = 0; k < 2; k++) {
        const tfa_workspace_options options = {
            .precision = TFA_F32, .residual = TFA_RESIDUAL_F64, .specialised = both[k]};
        tfa_workspace *w = workspace_for(b.arm, &options);
        const tfa_request r = {
            .op = TFA_OP_INVERSE_DYNAMICS, .count = STATES, .q = m.q, .v = m.v, .qdd = m.qdd};
        tfa_reply reply = {.tau = tau[k]};
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        tfa_workspace_free(w);
    }
    assert_memory_equal(tau[0], tau[1], sizeof tau[0]);
    tfa_specialised_free(kernel);
    bench_close(&b);
}

TEST(another_robot_refuses_it)
{
    bench b;
    tfa_specialised *kernel;
    tfa_workspace *w;
    tfa_batch_pool *pool;
    char path[256];
    bench_open(&b);
    bench_build(&b, b.arm, "SOUND", bench_path(&b, "kernel.so", path));
    tfa_model *floating = bench_robot("arm7.urdf", TFA_BASE_FLOATING);
    assert_int_equal(
        tfa_specialised_load(path, floating, &kernel, b.error_text, sizeof b.error_text),
        TFA_E_UNSUPPORTED);
    bench_assert_error_text(&b, "for another model");
    assert_null(kernel);
    assert_int_equal(tfa_specialised_find(b.kernels, b.arm, &kernel, NULL, 0), TFA_E_FILE);
    assert_int_equal(tfa_specialised_load(path, b.arm, &kernel, NULL, 0), TFA_OK);
    const tfa_workspace_options options = {.specialised = kernel};
    const tfa_batch_pool_options pooled = {.threads = 2, .specialised = kernel};
    assert_int_equal(tfa_workspace_create(floating, &options, &w), TFA_E_ARGUMENT);
    assert_int_equal(tfa_batch_pool_create(floating, &pooled, &pool), TFA_E_ARGUMENT);
    assert_int_equal(tfa_batch_pool_create(b.arm, &pooled, &pool), TFA_OK);
    tfa_batch_pool_free(pool);
    tfa_model_free(floating);
    tfa_specialised_free(kernel);
    bench_close(&b);
}

/* Two at a time are two, also when the file that the first came from is another one by now. */
TEST(several_are_loaded_at_once)
{
    bench b;
    tfa_specialised *first, *second;
    char path[256];
    bench_open(&b);
    tfa_model *quadruped = bench_robot("quadruped.urdf", TFA_BASE_FIXED);
    bench_path(&b, "kernel.so", path);
    bench_build(&b, b.arm, "SOUND", path);
    assert_int_equal(tfa_specialised_load(path, b.arm, &first, b.error_text, sizeof b.error_text),
                     TFA_OK);
    bench_build(&b, quadruped, "SOUND", path);
    assert_int_equal(
        tfa_specialised_load(path, quadruped, &second, b.error_text, sizeof b.error_text), TFA_OK);
    assert_int_equal(tfa_specialised_describe(first).bodies, 7);
    assert_int_not_equal(tfa_specialised_describe(second).bodies, 7);
    tfa_specialised_free(first);
    tfa_specialised_free(second);
    tfa_model_free(quadruped);
    bench_close(&b);
}
