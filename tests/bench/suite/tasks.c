/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every measurement of the suite: name, text, and the request.
 */
#include "suite.h"

#include <stddef.h>

/* ---- scenes of the bundled humanoid ---- */

#define FINGER(name)                                                                               \
    {                                                                                              \
        name,                                                                                      \
        {                                                                                          \
            0.3                                                                                    \
        }                                                                                          \
    }
#define HAND(side)                                                                                 \
    FINGER(side "_thumb_1_joint"), FINGER(side "_thumb_2_joint"), FINGER(side "_index_1_joint"),   \
        FINGER(side "_index_2_joint"), FINGER(side "_middle_1_joint"),                             \
        FINGER(side "_middle_2_joint"), FINGER(side "_ring_1_joint"), FINGER(side "_ring_2_joint")

static const tfa_lock fingers[] = {HAND("left"), HAND("right")};
enum { FINGERS = sizeof fingers / sizeof *fingers };
static const char *const palms[] = {SUITE_PALM};

static const tfa_scene scenes[] = {
    [SCENE_HANDS] = {.locks = fingers, .lock_count = FINGERS},
    [SCENE_ARM] = {.root = "torso_link",
                   .tips = palms,
                   .tip_count = 1,
                   .locks = fingers,
                   .lock_count = FINGERS / 2},
};

const tfa_scene *suite_scene(enum scene scene)
{
    return scene >= SCENE_HANDS ? &scenes[scene] : NULL;
}

int suite_is_for(const struct task *t, const struct robot *r)
{
    if (r->base == TFA_BASE_FLOATING && (t->how == HOW_CHAINED || t->scene == SCENE_ARM))
        return 0;
    return (!t->scene || r->hands) && (!t->fewest || (r->chain && r->joints >= t->fewest)) &&
           (!t->most || r->joints <= t->most);
}

/* ---- sizes ---- */

static size_t model_bytes(const struct library *l, const tfa_description *d,
                          const tfa_model_options *o, const tfa_model *m)
{
    (void)m;
    return l->tfa_model_size(d, o);
}

static size_t workspace_bytes(const struct library *l, const tfa_description *d,
                              const tfa_model_options *o, const tfa_model *m)
{
    (void)d, (void)o;
    return l->tfa_workspace_size(m, NULL);
}

static size_t workspace_one_bytes(const struct library *l, const tfa_description *d,
                                  const tfa_model_options *o, const tfa_model *m)
{
    static const tfa_workspace_options one = {.states = TFA_STATES_ONE};
    (void)d, (void)o;
    return l->tfa_workspace_size(m, &one);
}

/* ---- tasks ---- */

#define FD .op = TFA_OP_FORWARD_DYNAMICS
#define ID .op = TFA_OP_INVERSE_DYNAMICS
#define MASS .op = TFA_OP_MASS_MATRIX
#define DERIVATIVES .op = TFA_OP_DERIVATIVES
#define ID_DERIVATIVES .op = TFA_OP_INVERSE_DYNAMICS_DERIVATIVES
#define LAMBDA .op = TFA_OP_OPERATIONAL_INERTIA
#define TIP .tips = 1
#define FORCES .flags = TFA_WANT_JOINT_FORCES
#define BY(name) .method = TFA_METHOD_##name
#define ONE .states = 1, .threads = 1
#define TWO .states = 1, .threads = 2
#define BATCH .states = 512, .threads = 1, .most = 128
#define BATCH_2 .states = 512, .threads = 2, .most = 128
#define METHOD_ONLY .estimate = TFA_ESTIMATE_NEVER
#define REFINED(steps) .estimate = TFA_ESTIMATE_NEVER, .refine = (steps)
#define MIXED(factors, residual_of)                                                                \
    .precision = TFA_##factors, .residual = TFA_RESIDUAL_##residual_of,                            \
    REFINED(TFA_REFINE_DEFAULT), ONE, .most = 300
#define LONG .fewest = 64
#define SMALL .most = 300
/* All defaults of the method: refined once and estimated where it inverts inertias */
#define WITH_ESTIMATE .estimate = TFA_ESTIMATE_ALWAYS, .refine = TFA_REFINE_DEFAULT
#define NO_REQUEST FD, METHOD_ONLY, ONE

const struct task suite_tasks[] = {
    /* one state, auto */
    {"fd", "forward dynamics", FD, METHOD_ONLY, ONE},
    {"fd-chained", "each state from the answer before it", FD, METHOD_ONLY, ONE,
     .how = HOW_CHAINED},
    {"fd-cold", "no cache holds data or code", FD, METHOD_ONLY, ONE, .how = HOW_COLD},
    {"fd+sentinel", "with the sentinel", FD, ONE},
    {"fd+estimate", "refined as by default, with the error estimate", FD, WITH_ESTIMATE, ONE},
    {"fd+lambda", "and Lambda^-1 of a tip", FD, METHOD_ONLY, ONE, TIP},
    {"fd+lambda-cold", "cold", FD, METHOD_ONLY, ONE, TIP, .how = HOW_COLD},
    {"fd+payload", "with a payload of the request", FD, METHOD_ONLY, ONE, .given = A_PAYLOAD},
    {"fd+gravity", "with a gravity of the request", FD, METHOD_ONLY, ONE, .given = A_GRAVITY},
    {"fd+wrench", "with a wrench on a link", FD, METHOD_ONLY, ONE, .given = A_WRENCH},
    {"fd+forces", "and the wrench across every joint", FD, METHOD_ONLY, ONE, FORCES},
    {"fd-same-q", "at a q seen before", FD, METHOD_ONLY, ONE, .how = HOW_SAME_Q},
    {"fd+lambda-same-q", "both at a q seen before", FD, METHOD_ONLY, ONE, TIP, .how = HOW_SAME_Q},
    {"id", "inverse dynamics", ID, METHOD_ONLY, ONE},
    {"id+forces", "and the wrench across every joint", ID, METHOD_ONLY, ONE, FORCES},
    {"id-cold", "cold", ID, METHOD_ONLY, ONE, .how = HOW_COLD},
    {"mass", "mass matrix", MASS, METHOD_ONLY, ONE, SMALL},
    {"derivatives", "dqdd/dq, dqdd/dv, dqdd/dtau", DERIVATIVES, METHOD_ONLY, ONE, .most = 250},
    {"id-derivatives", "dtau/dq, dtau/dv", ID_DERIVATIVES, METHOD_ONLY, ONE, .most = 250},
    {"lambda", "Lambda^-1 of a tip", LAMBDA, METHOD_ONLY, ONE, TIP},
    {"lambda-cold", "cold", LAMBDA, METHOD_ONLY, ONE, TIP, .how = HOW_COLD},
    {"lambda+sentinel", "with the sentinel", LAMBDA, ONE, TIP},
    {"lambda+estimate", "with the error estimate", LAMBDA, WITH_ESTIMATE, ONE, TIP},
    {"lambda-same-q", "at a q seen before", LAMBDA, METHOD_ONLY, ONE, TIP, .how = HOW_SAME_Q},
    {"lambda-4", "of four tips", LAMBDA, METHOD_ONLY, ONE, .tips = 4},
    /* one state, other methods */
    {"fd-crba", "forward dynamics by crba", FD, BY(CRBA), METHOD_ONLY, ONE, SMALL},
    {"fd-tfa", "by tfa", FD, BY(TFA), METHOD_ONLY, ONE, SMALL},
    {"lambda-propagation", "Lambda^-1 by propagation", LAMBDA, BY(PROPAGATION), METHOD_ONLY, ONE,
     TIP},
    {"lambda-efpa", "by efpa", LAMBDA, BY(EFPA), METHOD_ONLY, ONE, TIP},
    {"lambda-pv-osimr", "by pv-osimr", LAMBDA, BY(PV_OSIMR), METHOD_ONLY, ONE, TIP},
    {"lambda-crba", "by crba", LAMBDA, BY(CRBA), METHOD_ONLY, ONE, TIP, SMALL},
    {"lambda-tfa", "by tfa", LAMBDA, BY(TFA), METHOD_ONLY, ONE, TIP},
    {"lambda-tfa-one-sided", "by tfa, factors of one side", LAMBDA, BY(TFA_ONE_SIDED), METHOD_ONLY,
     ONE, TIP},
    /* one state, other precisions */
    {"aba-refined", "aba, one refinement step", FD, BY(ABA), REFINED(1), ONE, SMALL},
    {"tfa-refined", "tfa, one refinement step", FD, BY(TFA), REFINED(1), ONE, SMALL},
    {"aba-f32", "aba in float", FD, BY(ABA), METHOD_ONLY, ONE, SMALL, .precision = TFA_F32},
    {"aba-f32+f64", "factors in float, residuals in double", FD, BY(ABA), MIXED(F32, F64)},
    {"scan-f32+f64", "the scan, likewise", FD, BY(SCAN), MIXED(F32, F64)},
    {"aba-f64+f128", "factors in double, residuals quadruple", FD, BY(ABA), MIXED(F64, F128)},
    {"tfa-f64+f128", "tfa, likewise", FD, BY(TFA), MIXED(F64, F128)},
    {"aba-f128", "aba in quadruple precision", FD, BY(ABA), METHOD_ONLY, ONE, SMALL,
     .precision = TFA_F128},
    {"id-f128", "inverse dynamics in quadruple precision", ID, METHOD_ONLY, ONE, SMALL,
     .precision = TFA_F128},
    /* scenes of the bundled humanoid */
    {"lambda-palm", "whole", LAMBDA, METHOD_ONLY, ONE, TIP, .scene = SCENE_WHOLE},
    {"fd-hands", "hands locked in the scene", FD, METHOD_ONLY, ONE, .scene = SCENE_HANDS},
    {"lambda-hands", "hands locked in the scene", LAMBDA, METHOD_ONLY, ONE, TIP,
     .scene = SCENE_HANDS},
    {"fd-arm", "one arm as tip, its hand locked", FD, METHOD_ONLY, ONE, .scene = SCENE_ARM},
    {"lambda-arm", "one arm as tip, its hand locked", LAMBDA, METHOD_ONLY, ONE, TIP,
     .scene = SCENE_ARM},
    /* batches */
    {"batch-f64", "512 states side by side", FD, METHOD_ONLY, BATCH},
    {"batch-f64-one", "one after the other", FD, METHOD_ONLY, BATCH, .one_by_one = 1},
    {"batch-f64+sentinel", "with the sentinel", FD, BATCH},
    {"batch-f64-2", "by two threads", FD, METHOD_ONLY, BATCH_2},
    {"batch-f64+lambda", "and Lambda^-1 of a tip", FD, METHOD_ONLY, BATCH, TIP},
    {"batch-f64-crba", "by crba", FD, BY(CRBA), METHOD_ONLY, BATCH},
    {"batch-f64-tfa", "by tfa, refined as by default", FD, BY(TFA), REFINED(TFA_REFINE_DEFAULT),
     BATCH},
    {"batch-f64+payload", "with a payload of the request", FD, METHOD_ONLY, BATCH,
     .given = A_PAYLOAD},
    {"batch-f64+gravity", "with a gravity of the request", FD, METHOD_ONLY, BATCH,
     .given = A_GRAVITY},
    {"id+wrench", "with a wrench on a link", ID, METHOD_ONLY, ONE, .given = A_WRENCH},
    {"batch-id+wrench", "with a wrench on a link", ID, METHOD_ONLY, BATCH, .given = A_WRENCH},
    {"batch-f64+wrench", "with a wrench on a link", FD, METHOD_ONLY, BATCH, .given = A_WRENCH},
    {"batch-f32", "in float", FD, METHOD_ONLY, BATCH, .precision = TFA_F32},
    {"batch-f32+payload", "in float, with a payload of the request", FD, METHOD_ONLY, BATCH,
     .given = A_PAYLOAD, .precision = TFA_F32},
    {"batch-f32+wrench", "in float, with a wrench on a link", FD, METHOD_ONLY, BATCH,
     .given = A_WRENCH, .precision = TFA_F32},
    {"batch-f32+lambda", "in float, and Lambda^-1 of a tip", FD, METHOD_ONLY, BATCH, TIP,
     .precision = TFA_F32},
    {"batch-f32-lambda", "in float, Lambda^-1 of a tip", LAMBDA, METHOD_ONLY, BATCH, TIP,
     .precision = TFA_F32},
    {"batch-f32-id", "in float, inverse dynamics", ID, METHOD_ONLY, BATCH, .precision = TFA_F32},
    {"batch-f32-2", "in float, by two threads", FD, METHOD_ONLY, BATCH_2, .precision = TFA_F32},
    {"batch-id", "inverse dynamics", ID, METHOD_ONLY, BATCH},
    {"batch-f64+forces", "and the wrench across every joint", FD, METHOD_ONLY, BATCH, FORCES},
    {"batch-id+forces", "and the wrench across every joint", ID, METHOD_ONLY, BATCH, FORCES},
    {"batch-mass", "mass matrix", MASS, METHOD_ONLY, BATCH},
    {"batch-derivatives", "dqdd/dq, dqdd/dv, dqdd/dtau", DERIVATIVES, METHOD_ONLY, BATCH},
    {"batch-id-derivatives", "dtau/dq, dtau/dv", ID_DERIVATIVES, METHOD_ONLY, BATCH},
    {"batch-f32-derivatives", "in float", DERIVATIVES, METHOD_ONLY, BATCH, .precision = TFA_F32},
    {"batch-lambda", "Lambda^-1 of a tip", LAMBDA, METHOD_ONLY, BATCH, TIP},
    /* long chains, by method; -2: on two threads */
    {"aba", "forward dynamics by aba", FD, BY(ABA), METHOD_ONLY, ONE, LONG},
    {"aba+estimate", "with the error estimate", FD, BY(ABA), WITH_ESTIMATE, ONE, LONG},
    {"auto-2", "auto, two threads", FD, METHOD_ONLY, TWO, LONG},
    {"scan", "segment scan", FD, BY(SCAN), METHOD_ONLY, ONE, LONG},
    {"scan-2", "two threads", FD, BY(SCAN), METHOD_ONLY, TWO, LONG},
    {"scan+estimate", "refined, estimated", FD, BY(SCAN), WITH_ESTIMATE, ONE, LONG},
    {"scan+estimate-2", "two threads", FD, BY(SCAN), WITH_ESTIMATE, TWO, LONG},
    {"scan-two-pass", "in two passes", FD, BY(SCAN_TWO_PASS), METHOD_ONLY, ONE, LONG},
    {"tfa", "tfa", FD, BY(TFA), METHOD_ONLY, ONE, LONG},
    {"tfa-cr", "cyclic reduction", FD, BY(TFA_CR), METHOD_ONLY, ONE, LONG},
    {"tfa-cr-2", "two threads", FD, BY(TFA_CR), METHOD_ONLY, TWO, LONG},
    {"tfa-cr+1", "refined, estimated", FD, BY(TFA_CR), WITH_ESTIMATE, ONE, LONG},
    {"tfa-cr+1-2", "two threads", FD, BY(TFA_CR), WITH_ESTIMATE, TWO, LONG},
    {"cfa-cr", "constraint forces", FD, BY(CFA_CR), METHOD_ONLY, ONE, LONG},
    {"cfa-cr-2", "two threads", FD, BY(CFA_CR), METHOD_ONLY, TWO, LONG},
    {"lambda-scan", "Lambda^-1 by the scan", LAMBDA, BY(SCAN), METHOD_ONLY, ONE, TIP, LONG},
    {"lambda-scan-2", "two threads", LAMBDA, BY(SCAN), METHOD_ONLY, TWO, TIP, LONG},
    {"lambda-tfa-cr", "cyclic reduction", LAMBDA, BY(TFA_CR), METHOD_ONLY, ONE, TIP, LONG},
    {"lambda-tfa-cr-2", "two threads", LAMBDA, BY(TFA_CR), METHOD_ONLY, TWO, TIP, LONG},
    /* before the first request */
    {"parse", "URDF text to a description", NO_REQUEST, .how = HOW_PARSE},
    {"compile", "a description to a model", NO_REQUEST, .how = HOW_COMPILE},
    {"workspace", "a model to a workspace", NO_REQUEST, .how = HOW_WORKSPACE},
    {"model-bytes", "of a model", NO_REQUEST, .how = HOW_BYTES, .bytes = model_bytes},
    {"workspace-bytes", "of a workspace", NO_REQUEST, .how = HOW_BYTES, .bytes = workspace_bytes},
    {"workspace-one-bytes", "of one for single states", NO_REQUEST, .how = HOW_BYTES,
     .bytes = workspace_one_bytes},
    {0}};
