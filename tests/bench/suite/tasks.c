/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What is asked of every robot, and of long chains besides.
 */
#include "suite.h"

#define FD TFA_OP_FORWARD_DYNAMICS
#define LAMBDA TFA_OP_OPERATIONAL_INERTIA
#define ONE .states = 1, .threads = 1
#define BATCH .states = 512
#define BARE .estimate = TFA_ESTIMATE_NEVER
#define LONG .fewest = 64
/* All defaults of the method: refined once and estimated where it inverts inertias */
#define CERTAIN .estimate = TFA_ESTIMATE_ALWAYS, .refine = TFA_REFINE_DEFAULT

const struct task suite_tasks[] = {
    {"fd", .op = FD, BARE, ONE},
    {"fd-chained", .op = FD, BARE, ONE, .how = HOW_CHAINED},
    {"fd-cold", .op = FD, BARE, ONE, .how = HOW_COLD},
    {"fd+sentinel", .op = FD, ONE},
    {"fd+estimate", .op = FD, CERTAIN, ONE},
    {"fd+lambda", .op = FD, BARE, ONE, .tips = 1},
    {"lambda", .op = LAMBDA, BARE, ONE, .tips = 1},
    {"lambda+sentinel", .op = LAMBDA, ONE, .tips = 1},
    {"lambda-4", .op = LAMBDA, BARE, ONE, .tips = 4},
    {"lambda+estimate", .op = LAMBDA, CERTAIN, ONE, .tips = 1},
    {"id", .op = TFA_OP_INVERSE_DYNAMICS, BARE, ONE},
    {"mass", .op = TFA_OP_MASS_MATRIX, BARE, ONE, .most = 300},
    {"fd-crba", .op = FD, .method = TFA_METHOD_CRBA, BARE, ONE, .most = 300},
    {"batch-f64", .op = FD, BARE, BATCH, .threads = 1, .most = 128},
    {"batch-f64+sentinel", .op = FD, BATCH, .threads = 1, .most = 128},
    {"batch-f64-2", .op = FD, BARE, BATCH, .threads = 2, .most = 128},
    {"batch-f32", .op = FD, BARE, BATCH, .threads = 1, .precision = TFA_F32, .most = 128},
    {"batch-f32-2", .op = FD, BARE, BATCH, .threads = 2, .precision = TFA_F32, .most = 128},
    {"batch-id", .op = TFA_OP_INVERSE_DYNAMICS, BARE, BATCH, .threads = 1, .most = 128},
    {"batch-lambda", .op = LAMBDA, BARE, BATCH, .threads = 1, .tips = 1, .most = 128},
    {"aba", .op = FD, .method = TFA_METHOD_ABA, BARE, ONE, LONG},
    {"aba+estimate", .op = FD, .method = TFA_METHOD_ABA, CERTAIN, ONE, LONG},
    {"auto-2", .op = FD, BARE, .states = 1, .threads = 2, LONG},
    {"scan", .op = FD, .method = TFA_METHOD_SCAN, BARE, ONE, LONG},
    {"scan-2", .op = FD, .method = TFA_METHOD_SCAN, BARE, .states = 1, .threads = 2, LONG},
    {"scan+estimate", .op = FD, .method = TFA_METHOD_SCAN, CERTAIN, ONE, LONG},
    {"scan+estimate-2", .op = FD, .method = TFA_METHOD_SCAN, CERTAIN, .states = 1, .threads = 2,
     LONG},
    {"scan-two-pass", .op = FD, .method = TFA_METHOD_SCAN_TWO_PASS, BARE, ONE, LONG},
    {"tfa", .op = FD, .method = TFA_METHOD_TFA, BARE, ONE, LONG},
    {"tfa-cr", .op = FD, .method = TFA_METHOD_TFA_CR, BARE, ONE, LONG},
    {"tfa-cr-2", .op = FD, .method = TFA_METHOD_TFA_CR, BARE, .states = 1, .threads = 2, LONG},
    {"tfa-cr+1", .op = FD, .method = TFA_METHOD_TFA_CR, CERTAIN, ONE, LONG},
    {"tfa-cr+1-2", .op = FD, .method = TFA_METHOD_TFA_CR, CERTAIN, .states = 1, .threads = 2, LONG},
    {"cfa-cr", .op = FD, .method = TFA_METHOD_CFA_CR, BARE, ONE, LONG},
    {"cfa-cr-2", .op = FD, .method = TFA_METHOD_CFA_CR, BARE, .states = 1, .threads = 2, LONG},
    {"lambda-scan", .op = LAMBDA, .method = TFA_METHOD_SCAN, BARE, ONE, .tips = 1, LONG},
    {"lambda-scan-2", .op = LAMBDA, .method = TFA_METHOD_SCAN, BARE, .states = 1, .threads = 2,
     .tips = 1, LONG},
    {"lambda-tfa-cr", .op = LAMBDA, .method = TFA_METHOD_TFA_CR, BARE, ONE, .tips = 1, LONG},
    {"lambda-tfa-cr-2", .op = LAMBDA, .method = TFA_METHOD_TFA_CR, BARE, .states = 1, .threads = 2,
     .tips = 1, LONG},
    {0}};
