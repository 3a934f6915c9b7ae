/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The steps of the algorithms, one header for all of them, and the table each variant exports.
 *
 * A forward-dynamics method is a pair: factor (depends on q only) and solve (any right-hand side
 * with kept factors), so that refinement and Lambda^-1 reuse the factors.
 */
#ifndef TFA_KERNEL_KERNEL_H
#define TFA_KERNEL_KERNEL_H

#include "kernel/state.h"

/* --- pose.c, velocity.c: what every method needs ---------------------------------------- */

/* X_i = Z(q_i) T_i of the bodies in s->span, unless they are there. */
void TFA_V(pose)(struct state *s);

/* v_i, c_i and p_i = v_i x* I_i v_i - wrench_i, outward. Without velocity and wrench all are 0
 * and s->moving says so. */
void TFA_V(velocity)(struct state *s);

/* --- rnea.c ------------------------------------------------------------------------------ */

/* tau = M qdd + h (bias) or M qdd alone. Featherstone 2008, table 5.1. */
void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias);
/* The same with motions and forces perturbed by roundings (perturb.h): the difference
 * from rnea shows the effect of rounding on either. */
void TFA_V(rnea_perturbed)(struct state *s, const num *qdd, num *tau, int bias);

/* --- aba.c: Featherstone 2008, table 7.1 -------------------------------------------------- */

/* Forward dynamics in one go: factors and qdd = M^-1 (tau - h). */
void TFA_V(aba)(struct state *s, const num *tau, num *qdd);
/* IA, U, D only. Both use those that are there. */
void TFA_V(aba_factor)(struct state *s);
/* qdd = M^-1 tau with kept factors (no bias). */
void TFA_V(aba_solve)(struct state *s, const num *tau, num *qdd);

/* --- crba.c: Featherstone 2008, tables 6.2 and 6.3 ---------------------------------------- */

/* Rows of M by structure (see model->dof_row). */
void TFA_V(crba)(struct state *s);
/* M = L^T D L in place; with mimics, the factors of T^T M T. Needs crba. */
void TFA_V(ltdl_factor)(struct state *s);
/* x <- M^-1 x. */
void TFA_V(ltdl_solve)(struct state *s, num *x);
/* x <- L^-T x, half of the solve; and the entries of D. */
void TFA_V(ltdl_half)(const struct state *s, num *x, size_t stride);

/* --- mimic.c: freedoms that follow others ---------------------------------------------------- */

/* Freedom of T^T M T that inner freedom j belongs to, and how many times it moves with it. */
uint32_t TFA_V(reduced_freedom)(const struct tfa_model *m, uint32_t j, num *multiplier);
/* T^T M T from M, factored; x <- T (T^T M T)^-1 T^T x. */
void TFA_V(reduced_factor)(struct state *s);
void TFA_V(reduced_solve)(struct state *s, num *x);
/* Forces with the same T^T tau, all of them on leaders. */
void TFA_V(gather)(struct state *s, num *tau);
/* x, an acceleration that a method found without regard to mimics, becomes the one with. */
void TFA_V(follow)(struct state *s, tfa_method method, num *x);

/* --- tfa.c: Fijany & Featherstone 2013 ----------------------------------------------------- */

/* Constant terms, once for each workspace; and of one body whose constants changed. */
void TFA_V(tfa_bake)(struct state *s);
void TFA_V(tfa_bake_body)(struct state *s, uint32_t body);

/* --- lambda.c, lambda_tfa.c, lambda_efpa.c, lambda_pv.c ----------------------------------- */

/* J^T columns of the tips into s->psi (nv x 6m). Linear columns first. */
void TFA_V(jacobian)(struct state *s, tfa_reference_frame frame);
/* Lambda^-1 into s->lambda (6m x 6m). */
void TFA_V(lambda_propagation)(struct state *s, tfa_reference_frame frame);
void TFA_V(lambda_crba)(struct state *s, tfa_reference_frame frame);
int TFA_V(lambda_one_sided)(struct state *s, tfa_reference_frame frame);
/* Needs the articulated-body factors; leaves s->Ic spoilt, which only crba reads, after writing. */
void TFA_V(lambda_efpa)(struct state *s, tfa_reference_frame frame);
/* The same with the stretches of bodies that several tips share passed in one step. */
void TFA_V(lambda_pv)(struct state *s, tfa_reference_frame frame);
/* By columns: Lambda^-1 = J (M^-1 J^T) with kept factors and refinement steps. */
void TFA_V(lambda_columns)(struct state *s, tfa_reference_frame frame, tfa_method method,
                           uint32_t refine);

/* --- lambda_error.c -------------------------------------------------------------------------- */

/* Relative error of s->lambda, which came from the method's factors with so many refinement steps:
 * |error| / |Lambda^-1|, sums of squares of all entries. Needs the method's factors. */
num_doubles TFA_V(lambda_error)(struct state *s, tfa_reference_frame frame, tfa_method method,
                                uint32_t steps);

/* --- sentinel.c -------------------------------------------------------------------------------- */

/* Does the sentinel trip for the factors that the method left? Those of aba have seen it (s->margin). */
int TFA_V(sentinel_of)(struct state *s, tfa_method method);
/* It looks at the factors of M, and at those that the articulated-body recursion left. */
void TFA_V(sentinel_see_mass)(struct state *s);
void TFA_V(sentinel_see_articulated)(struct state *s);

/* --- method.c, refine.c ---------------------------------------------------------------------- */

/* qdd = M^-1 (tau - h), leaving the method's factors. TFA may refuse: TFA_E_SINGULAR, s->bad_body. */
int TFA_V(forward_dynamics)(struct state *s, tfa_method method);
/* Factors of a method, unless they are there. TFA may refuse as before. */
int TFA_V(factor)(struct state *s, tfa_method method);
/* x = M^-1 rhs with kept factors of the method; x may be rhs. */
void TFA_V(solve)(struct state *s, tfa_method method, const num *rhs, num *x);
/* The same without regard to mimics. */
void TFA_V(solve_free)(struct state *s, tfa_method method, const num *rhs, num *x);
/* Refinement of s->qdd; into the wider state where there is one, which has loaded the request. Steps
 * 0: one correction computed and not applied. `fully`: to the digits of the wider arithmetic, or it
 * is in doubt (s->wider only). `certified`: the estimate is that of the refined answer, from a perturbed residual; without
 * it steps are estimated by what the last of them changed. */
struct refined {
    num_doubles estimate; /* |dx|/|x| */
    uint16_t doubt; /* 0, or why the answer is not to be given (TFA_ANSWER_*), that of some lane */
};
struct refined TFA_V(refine)(struct state *s, tfa_method method, uint32_t steps, int fully,
                             int certified);
/* As the wider one of another kernel, see table.h. */
void TFA_V(wider_add)(struct state *s, const double *dx, int fresh);
double TFA_V(wider_residual)(struct state *s, double *residual, int perturbed);

/* --- scan_strips.c: see table.h ------------------------------------------------------------------ */

struct scan_segment;
struct tfa_factors;
struct tfa_strip_ends;
size_t TFA_V(strips_bytes)(void);
void TFA_V(strips_travel)(struct tfa_strip_ends *ends, int first);
int TFA_V(strips_join)(struct scan_segment *segments, struct tfa_strip_ends *ends, double light);
void TFA_V(strips_pass)(struct scan_segment *segments, struct tfa_strip_ends *ends,
                        const double gravity[3]);
void TFA_V(strips_close)(struct scan_segment *segments, struct tfa_strip_ends *ends);

/* --- answer.c, answer_forward.c, answer_lambda.c, answer_tips.c --------------------------------- */

/* States k .. k + count - 1 of a checked request, at most NUM_LANES, and as many answers. Several that
 * cannot go on together, or one of which has no answer, get none that counts: a status that is not
 * TFA_OK. */
int TFA_V(answer)(struct state *s, const tfa_request *request, struct tfa_resolved by, uint32_t k,
                  uint32_t count, tfa_reply *reply, tfa_answer *answer);
int TFA_V(answer_forward)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                          tfa_answer *out);
/* As a kernel offers it, see table.h. */
int TFA_V(estimate_forward)(struct state *s, const tfa_request *r, uint32_t k,
                            const tfa_reply *reply, double limit, tfa_answer *out);
/* Writes s->qdd out; returns 1 when all of it is finite. */
int TFA_V(unload_qdd)(const struct state *s, uint32_t k, tfa_reply *reply);
int TFA_V(answer_lambda)(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                         tfa_answer *out);
/* Poses of the tips, where they are wanted */
void TFA_V(answer_poses)(const struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply);
/* As a kernel offers them, see table.h. */
struct tfa_factors TFA_V(lend)(struct state *s);
int TFA_V(answer_tips)(struct state *s, const tfa_request *r, struct tfa_resolved by, uint32_t k,
                       tfa_reply *reply, tfa_answer *out);

#endif
