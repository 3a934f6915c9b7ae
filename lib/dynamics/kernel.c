/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The table that one compiled variant of the kernels offers to the rest of the library: of one
 * state at a time, or of a batch with one state in each lane. A batch has no tips, whose six
 * wrenches fill lanes themselves (vec6.h), and none of the methods that search, keep O(N^2) numbers
 * or fill lanes themselves (hessenberg and the scans): gcc fuses their products in another way over
 * vectors, and answers would differ from those of one state at a time in the last bit (one state of
 * 19 of a chain of 20 bodies; a tip on one joint; gcc 12, 2026-11-22).
 */
#include "dynamics/chain/tfa.h"
#include "dynamics/cpu.h"
#include "dynamics/scan/chain_cut.h"
#include "dynamics/scan/segment_scan.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"
#include "interface/inputs.h"
#include "interface/kernel_table.h"

static size_t size(const tfa_model *model, struct tfa_reserved reserved)
{
    struct state *none;
    return state_walk(model, model_extent(model, reserved), NULL, &none);
}

static struct state *init(const tfa_model *model, struct tfa_reserved reserved, void *memory)
{
    struct state *s = state_init(model, model_extent(model, reserved), memory);
    s->in_segments = tfa_cut_segments(model).count > 0;
    TFA_V(tfa_precompute)(s);
    return s;
}

static int solves(tfa_method method)
{
    const struct method *row = TFA_V(method)(method);
    return row->chain || row->forward;
}

static void set_residual_kernel(struct state *s, const struct tfa_residual_kernel *residual_kernel)
{
    s->residual_kernel = residual_kernel;
}

#if NUM_LANES == 1
static void load(struct state *s, const tfa_request *request, uint32_t k)
{
    TFA_V(load)(s, request, k, 1);
}

static double zero_of_arrays(const tfa_request *r, const struct tfa_inputs *inputs)
{
    return zero_of_inputs(r, inputs);
}

static void set_executor(struct state *s, struct tfa_executor *executor)
{
    s->executor = executor;
}

static void round_sincos(struct state *s)
{
    s->round_sincos = 1;
}
#endif

const struct tfa_kernel TFA_V(kernel) = {
    .isa = TFA_STRING(TFA_ISA_NAME),
    .precision = TFA_PRECISION,
    .lanes = NUM_LANES,
    .supported = tfa_cpu_supported,
    .solves = solves,
    .size = size,
    .init = init,
    .answer = TFA_V(answer),
    .set_residual_kernel = set_residual_kernel,
#if NUM_LANES == 1
    .zero_of_inputs = zero_of_arrays,
    .factor_buffers = TFA_V(factor_buffers),
    .answer_tips = TFA_V(answer_tips),
    .constraint_residual = TFA_V(residual_of_reply),
    .answer_motion = TFA_V(answer_motion),
    .answer_joint_forces = TFA_V(answer_joint_forces),
    .estimate = TFA_V(estimate_forward),
    .set_executor = set_executor,
    .round_sincos = round_sincos,
    .segment_scan_bytes = TFA_V(segment_scan_bytes),
    .segment_scan_velocities = TFA_V(segment_scan_velocities),
    .segment_scan_factor = TFA_V(segment_scan_factor),
    .segment_scan_solve = TFA_V(segment_scan_solve),
    .segment_scan_correct = TFA_V(segment_scan_correct),
    .load = load,
    .add = TFA_V(residual_kernel_add),
    .residual = TFA_V(residual_kernel_residual),
    .unload = TFA_V(unload_qdd),
#endif
};
