/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Computing: a workspace answers one request with one reply. The daemon, the command line and
 * programs that link the library all call tfa_compute, so they give the same bits.
 *
 *     M(q) qdd + h(q, v) = tau + sum J^T wrench        h: gravity and velocity products
 *     Lambda^-1 = J M^-1 J^T                           J: twist of a tip = J v
 *
 * (Featherstone 2008, 3.1; Khatib, IEEE J. Robotics and Automation 3(1), 1987). With a floating
 * base, v stands for (base_twist, v), tau for (base_wrench, tau) and qdd for (base_acceleration,
 * qdd). Six-vectors are linear first, angular second; quaternions x y z w; matrices row major; SI
 * units. Coordinates and frames: docs/conventions.md. In costs, N is the number of bodies, d the
 * depth of the tree and m the number of tips.
 */
#ifndef TOTALFORCE_DYNAMICS_H
#define TOTALFORCE_DYNAMICS_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/method.h>
#include <totalforce/model.h>
#include <totalforce/request.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Memory of one computation: factors, intermediate vectors, batches. One thread at a time. */
typedef struct tfa_workspace tfa_workspace;

/** States of a request that are computed together, one in each SIMD lane. */
typedef enum tfa_states {
    TFA_STATES_AUTO = 0, /**< as many as the processor has lanes, for robots up to 128 bodies */
    TFA_STATES_ONE = 1,  /**< one: the smallest workspace */
} tfa_states;

/** Sets of methods: one bit for each. */
#define TFA_METHOD_BIT(method) (1u << (method))
#define TFA_METHODS_ALL UINT32_MAX /**< every method */

struct tfa_specialised; /* specialised.h */

/** Zero-initialise for the defaults. */
typedef struct tfa_workspace_options {
    tfa_precision precision; /**< of the factors */
    tfa_residual residual;   /**< of refinement; another precision needs memory for both */
    tfa_states states;       /**< computed together */
    uint32_t methods;  /**< TFA_METHOD_BITs to reserve memory for, in addition to auto, its choices,
                           rnea, aba, propagation, efpa, pv-osimr, scan and scan-two-pass. The mass
                           matrix uses the memory of crba. 0: TFA_METHODS_ALL for robots up to 256
                           bodies, no more for larger ones */
    uint32_t max_tips; /**< tips of a request to reserve memory for, up to TFA_MAX_TIPS: 1 KB each
                            for a freedom, and 600 bytes for a pair; 0: TFA_DEFAULT_TIPS */
    const struct tfa_specialised *specialised; /**< specialised kernel of the model, outlives the
                           workspace; answers the requests that it supports, in TFA_F64 with
                           TFA_RESIDUAL_SAME only; NULL: none */
    int round_sincos; /**< TFA_F128 only. 1: rounds sine and cosine of each joint angle to double;
                           the difference from the answer with 0 is the error that no computation
                           in double can avoid */
} tfa_workspace_options;

/** Size of a workspace of this model in bytes; 0 for a NULL model or options that
 *  tfa_workspace_init does not support. options NULL: all defaults. Memory by robot size:
 *  docs/real-time.md. Any thread. */
TFA_API size_t tfa_workspace_size(const tfa_model *model, const tfa_workspace_options *options);

/**
 * Initialises a workspace in memory of the caller. The model must outlive it. Cost: O(size). Any
 * thread.
 *
 * @param memory     64-byte aligned, at least tfa_workspace_size() bytes
 * @param size       of memory, bytes
 * @param model      outlives the workspace
 * @param options    NULL: all defaults
 * @param workspace  lies in memory
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL, or options->specialised is for another model);
 *         TFA_E_UNSUPPORTED (no such precision or instruction set, a residual of lower precision
 *         than the factors, more than TFA_MAX_TIPS tips); TFA_E_MEMORY (too small or not aligned).
 *         *workspace is NULL on error.
 */
TFA_API TFA_CHECKED int tfa_workspace_init(void *memory, size_t size, const tfa_model *model,
                                           const tfa_workspace_options *options,
                                           tfa_workspace **workspace);

/** As tfa_workspace_init, in memory that it allocates; TFA_E_MEMORY: the allocation failed. Release
 *  with tfa_workspace_free. */
TFA_API TFA_CHECKED int tfa_workspace_create(const tfa_model *model,
                                             const tfa_workspace_options *options,
                                             tfa_workspace **workspace);

/** Methods that the workspace has memory for: TFA_METHOD_BITs. */
TFA_API uint32_t tfa_workspace_methods(const tfa_workspace *workspace);

/** Tips of a request that the workspace has memory for. */
TFA_API uint32_t tfa_workspace_max_tips(const tfa_workspace *workspace);

/** Releases a workspace of tfa_workspace_create. NULL is allowed. */
TFA_API void tfa_workspace_free(tfa_workspace *workspace);

/**
 * Checks a request against the model without computing: sizes, indices, finiteness, quaternions.
 * Sets status, field, index, state and model of the reply. Cost: one read of the inputs. Any
 * thread.
 * @return reply->status as tfa_compute, except TFA_E_SINGULAR, TFA_E_NOT_COMPUTED, TFA_E_RANK
 */
TFA_API int tfa_request_check(const tfa_model *model, const tfa_request *request, tfa_reply *reply);

/**
 * Answers one request: tfa_request_check, method, refinement, estimate, fallback.
 *
 * Reads the arrays of the request and writes the buffers of the reply. No allocation, no lock, no
 * system call, no output. Cost: TFA_METHOD_LIST. Thread rule: one call per workspace at a time. The
 * answer depends on model, options and request only: not on the machine's load, the batch or the
 * number of threads; between instruction sets it differs by rounding. Subnormal numbers count as
 * zero: the floating-point mode is changed meanwhile and put back.
 *
 * @return reply->status:
 *   TFA_OK              every state is answered (fallbacks: answers[k].flags);
 *   TFA_E_ARGUMENT      a required pointer is NULL; an op, flag, frame, policy, kind of rows or
 *                       number of refinement steps does not exist; a payload's mass or inertia is
 *                       negative; the rank threshold is not between 0 and 1;
 *   TFA_E_SIZE          count 0; too many tips, wrenches, payloads or locked joints; no tip for
 *                       operational inertia, task torques or a flag that needs one;
 *   TFA_E_VALUE         an input is NaN or infinite: field, state and index name it;
 *   TFA_E_QUATERNION    the norm of base_pose's or a floating joint's quaternion differs from 1 by
 *                       more than 1e-3;
 *   TFA_E_LINK          a tip, wrench or payload has a frame index that does not exist;
 *   TFA_E_JOINT         a locked joint index does not exist;
 *   TFA_E_METHOD        the method does not exist, does not answer the op, or refuses the request
 *                       (tfa_method_info.refuses): locked joints, armature on a main chain,
 *                       projected mimics, followers without mass of their own;
 *   TFA_E_UNSUPPORTED   the answer needs M, which has more than 4 Mi entries (a chain of 2895
 *                       bodies); the workspace has no memory for the method
 *                       (tfa_workspace_options.methods) or for so many tips (max_tips);
 *                       hessenberg on a main chain of more than 130 bodies; locked joints with the
 *                       mass matrix, or with followers without mass of their own; spectrum, lambda,
 *                       mu or p of an op without lambda_inv; a payload on a link between fused
 *                       joints; derivatives of more than 256 freedoms. Of a limit `index` is the
 *                       number, and tfa_limit_text the sentence; of memory the method or the tips;
 *   TFA_E_SINGULAR      the method cannot invert the inertia of a main-chain body: index is the
 *                       frame of the link that names it;
 *   TFA_E_NOT_COMPUTED  an answer is not finite or has no certain digit: M is singular at this q,
 *                       or nearly, or a number overflows. Answers of other states are valid;
 *   TFA_E_RANK          lambda_inv has rank `index`, less than its rows, and the request refuses
 *                       that (TFA_RANK_REFUSE): lambda, mu, p and the torques of the task are
 *                       NaN. Other answers are valid.
 */
TFA_API int tfa_compute(tfa_workspace *workspace, const tfa_request *request, tfa_reply *reply);

/**
 * As tfa_compute, for states first .. first + count - 1 of a request that tfa_request_check has
 * accepted: for callers that do other work between the states of a batch. Do not change the request
 * in between; first + count may not exceed request->count. Writes the buffers of the reply at the
 * places of these states; `status` and the failed field stay those of the first failure since the
 * check.
 * @return reply->status as tfa_compute
 */
TFA_API int tfa_compute_states(tfa_workspace *workspace, const tfa_request *request, uint32_t first,
                               uint32_t count, tfa_reply *reply);

/** A request of which all but its numbers is fixed */
typedef struct tfa_prepared tfa_prepared;

/**
 * Prepares requests like this one: checks it whole, chooses method and code, and copies op, method,
 * options, sizes, frames, payloads and locked joints. tfa_compute does the same by itself for a
 * request that differs from the last one of its op in arrays and their numbers only; a prepared
 * request also keeps payloads and locked joints, and is not forgotten when others come between.
 *
 * @param workspace  outlives the prepared request
 * @param request    valid, with numbers as for tfa_compute
 * @param reply      status and failed field, as tfa_compute
 * @param prepared   release with tfa_prepared_free; NULL on error
 * @return reply->status as tfa_compute, TFA_OK where that answers; TFA_E_MEMORY: the allocation
 *         failed. Thread rule: that of tfa_compute.
 */
TFA_API TFA_CHECKED int tfa_prepare(tfa_workspace *workspace, const tfa_request *request,
                                    tfa_reply *reply, tfa_prepared **prepared);

/**
 * Answers a prepared request, with the bits of tfa_compute. Of `request` it reads `count` and the
 * arrays of numbers but `payloads`: these are checked as by tfa_compute. No allocation, no lock, no
 * system call. Thread rule: one call per workspace at a time.
 * @return reply->status as tfa_compute
 */
TFA_API int tfa_run(tfa_prepared *prepared, const tfa_request *request, tfa_reply *reply);

/** Releases a prepared request. NULL is allowed. */
TFA_API void tfa_prepared_free(tfa_prepared *prepared);

/** Upper bound of the stack that any request uses (`test_stack`; docs/real-time.md). */
#define TFA_STACK_BYTES ((size_t)256 * 1024)

/**
 * Writes to the TFA_STACK_BYTES below the caller's frame, so that no later request of this thread
 * causes a page fault there. A real-time thread calls it once before its first request; the threads
 * of a tfa_batch_pool have done so. Cost: one page fault for each page not yet mapped. Not for a
 * thread with a smaller stack.
 */
TFA_API void tfa_stack_prepare(void);

/** Instruction set of the kernels: "avx512", "avx2" or "base", the best that library and processor
 *  have unless TFA_ISA in the environment forces one. "none" if TFA_ISA names no such one: creating
 *  a workspace is then TFA_E_UNSUPPORTED. Static storage. Any thread. */
TFA_API const char *tfa_isa_name(void);
/** Writes the instruction sets that library and processor have, the best first: "avx2, base".
 *  Terminated; as much as fits; size > 0. Any thread. */
TFA_API void tfa_isa_names(char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
