/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Functions of a compiled kernel for the rest of the library, and for another kernel
 * whose answers it refines.
 */
#ifndef TFA_INTERFACE_KERNEL_TABLE_H
#define TFA_INTERFACE_KERNEL_TABLE_H

#include "interface/resolved.h"

struct scan;
struct state;
struct segment_lanes;
struct tfa_executor;
struct tfa_inputs;
struct tfa_segment_boundary;
struct tfa_residual_kernel;
struct tfa_lane_schedule;

/* Where a kernel keeps the articulated-body factors of each body (state.h), in numbers of its
 * precision, for another that computes them: X, U and 1/D of joints with one freedom, 12, 6 and 1
 * numbers a body; and of joints with several, `joint_nd_bytes` apart. Of forward dynamics c and u,
 * 6 numbers and 1; motions and forces of inverse dynamics, v, a and f, 6 each; whether c and v
 * count. */
struct tfa_factor_buffers {
    void *X, *U, *Dinv, *c, *u, *v, *a, *f;
    int *moving;
    char *part, *H, *joint_nd_U, *L, *joint_nd_u;
    size_t joint_nd_bytes;
};

/* Above this estimate the answer of a method that lost too much is replaced
 * (over 180 cases nothing worse passed unnoticed). */
#define FALLBACK_ESTIMATE 1e-4
/* Above this an answer that the sentinel doubts is refined by default. */
#define SENTINEL_ESTIMATE_MAX 1e-7

/* Outcome of a state; sentinel: the sentinel tripped (sentinel.h), the error is to be
 * estimated. */
enum { TFA_NOT_ANSWERED = 0, TFA_ANSWERED = 1, TFA_ANSWERED_SENTINEL = 2 };

/* States of one batch at most */
#define TFA_BATCH_LANES_MAX 16

/* One compiled variant of the kernels: of one state at a time, or of a batch of states in lanes.
 * The members behind `set_residual_kernel` are of one state at a time only, NULL elsewhere. */
struct tfa_kernel {
    const char *isa;
    tfa_precision precision;
    uint32_t lanes;         /* states at a time */
    int (*supported)(void); /* every CPU feature that the flags allow is present */
    /* 1: forward dynamics by this method; a batch has no method of one state at a time */
    int (*solves)(tfa_method method);
    size_t (*size)(const tfa_model *model, struct tfa_reserved reserved);
    struct state *(*init)(const tfa_model *model, struct tfa_reserved reserved, void *memory);
    /* States k .. k + count - 1, at most `lanes`, of a checked request; fills as many answers, and
     * field/index of the reply on failure. Where several states do not go the same way, or one of
     * them has no answer, returns a status that is not TFA_OK, and nothing that was written
     * counts. */
    int (*answer)(struct state *s, const tfa_request *request, struct tfa_resolved by, uint32_t k,
                  uint32_t count, tfa_reply *reply, tfa_answer *answers);
    /* From now on refinement of single states in s has its residual from this kernel, which
     * outlives s. */
    void (*set_residual_kernel)(struct state *s, const struct tfa_residual_kernel *residual_kernel);

    /* inputs.h, by this instruction set */
    double (*zero_of_inputs)(const tfa_request *request, const struct tfa_inputs *inputs);

    struct tfa_factor_buffers (*factor_buffers)(struct state *s);
    /* What a state of a checked request, which changes nothing about the robot, asks of its tips,
     * with the factors of the bodies that carry them: of another kernel, written to its
     * factor_buffers: Lambda^-1, neither refined nor estimated, task torques, or wrenches of
     * constraints, which leave their u in factor_buffers. Returns 0 where the kernel of one state
     * must answer: some of it is not finite, or a direction is lost. */
    int (*answer_tips)(struct state *s, const tfa_request *request, struct tfa_resolved by,
                       uint32_t k, tfa_reply *reply, tfa_answer *answer);

    /* After wrenches of constraints: the residual of the accelerations in the reply. Returns
     * whether all of it is finite. */
    int (*constraint_residual)(struct state *s, uint32_t k, tfa_reply *reply);

    /* Answers of kinematics for state k of a checked request, those of its flags that are among
     * `flags`. Returns whether all of it is finite. */
    int (*answer_motion)(struct state *s, const tfa_request *request, struct tfa_resolved by,
                         uint32_t flags, uint32_t k, tfa_reply *reply);

    /* Forces across all joints for state k of a checked request, from the accelerations in the
     * reply or, of inverse dynamics, in the request; of what another kernel wrote to its
     * factor_buffers if `given`. Returns whether all of it is finite. */
    int (*answer_joint_forces)(struct state *s, const tfa_request *request, struct tfa_resolved by,
                               uint32_t k, int given, tfa_reply *reply);

    /* Estimates the error of the accelerations of state k, which stand in the reply, by the factors
     * of aba. Returns 0 where the estimate is above `limit` or not finite. */
    int (*estimate)(struct state *s, const tfa_request *request, uint32_t k, const tfa_reply *reply,
                    double limit, tfa_answer *answer);

    /* Sets the executor of solves in s; NULL: the caller alone. */
    void (*set_executor)(struct state *s, struct tfa_executor *executor);
    /* From now on sines and cosines are rounded to double, where numbers are wider. */
    void (*round_sincos)(struct state *s);

    /* The scan over segments in lanes, or the forces at their cuts (segment_boundary.h); `scan` is
     * memory of segment_scan_bytes(). */
    size_t (*segment_scan_bytes)(void);
    /* v_in from E, r, v_end (first); then dv_in from E, r, v_in and the v_end that came of it, so
     * that no velocity jumps where segments meet. Without, light bodies on long levers (links of
     * 1 mm, joints 1 m apart, 1024 bodies) had 5 times the error of aba, with it 1.0 (median of 7,
     * 2026-11-22); */
    void (*segment_scan_velocities)(struct tfa_segment_boundary *boundary, int first);
    /* the segments combined. Returns whether some cut has at least `max_ratio` (scan.h): `known` is
     * then the inertia outboard of the cut, with which all want to be computed again; -1: a segment
     * that floats has no inverse inertia; */
    int (*segment_scan_factor)(struct scan *scan, struct tfa_segment_boundary *boundary,
                               double max_ratio);
    /* a_in and f_out from a_end and g. */
    void (*segment_scan_solve)(struct scan *scan, struct tfa_segment_boundary *boundary,
                               const double gravity[3]);
    /* corrections of both, from the a_end that they led to. Returns 0 where the forces at the cuts
     * are of no use. */
    int (*segment_scan_correct)(struct scan *scan, struct tfa_segment_boundary *boundary);

    /* As the residual kernel of another: reads state k of a checked request; */
    void (*load)(struct state *s, const tfa_request *request, uint32_t k);
    /* x = dx (fresh) or x += dx, as follows for followers; */
    void (*add)(struct state *s, const double *dx, int fresh);
    /* residual = tau - RNEA(x), perturbed (rnea_perturbed) or not. Returns |x|; */
    double (*residual)(struct state *s, double *residual, int perturbed);
    /* writes x to the reply. Returns 1 when all of it is finite. */
    int (*unload)(const struct state *s, uint32_t k, tfa_reply *reply);
};

/* Another kernel with a state of the same model: where refinement takes its residual from, in
 * higher precision and where the solution is summed up. */
struct tfa_residual_kernel {
    const struct tfa_kernel *kernel;
    struct state *state;
};

/* Forward dynamics of one state of a long chain, its segments in lanes. For robots that
 * tfa_cut_segments takes. */
struct tfa_segment_lanes_kernel {
    /* `one` scans over the segments. */
    size_t (*size)(const tfa_model *model, const struct tfa_kernel *one);
    struct segment_lanes *(*init)(const tfa_model *model, const struct tfa_kernel *one,
                                  void *memory);
    /* State k of a checked request, which changes nothing about the robot, by the scans or, of
     * tfa-cr and cfa-cr, by the forces at the cuts. TFA_NOT_ANSWERED: some acceleration is not
     * finite. */
    int (*answer)(struct segment_lanes *s, struct tfa_executor *executor,
                  const tfa_request *request, uint32_t k, tfa_method method, tfa_reply *reply);
};

/* One state at a time, its independent branches in lanes: forward dynamics by aba, inverse
 * dynamics, and the factors that tips ask for. */
struct tfa_body_lanes_kernel {
    uint32_t lanes;
    double step; /* time for one step of the schedule, relative to one body of the scalar kernel */
    size_t (*size)(const tfa_model *model, const struct tfa_lane_schedule *schedule);
    struct state *(*init)(const tfa_model *model, const struct tfa_lane_schedule *schedule,
                          void *memory);
    /* State k of a checked request, which changes nothing about the robot and has no mimics: its
     * accelerations, where they are asked for, and its factors, of task torques no more; or its
     * forces. TFA_NOT_ANSWERED: some are not finite. */
    int (*answer)(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply);
    /* Of the accelerations that came last, as tfa_kernel.estimate */
    int (*estimate)(struct state *s, double limit, tfa_answer *answer);
    /* Of the state that came last, the factors of all bodies that carry a tip of the request or a
     * frame of its constraints, for task torques and these with c and u. Whether they are finite
     * is checked where they are used. */
    void (*copy_factors)(const struct state *s, const tfa_request *request,
                         const struct tfa_factor_buffers *to);
    /* Accelerations of the same state with the forces u of these bodies from there. Returns 1 when
     * all are finite. */
    int (*accelerate)(struct state *s, const tfa_request *request,
                      const struct tfa_factor_buffers *from, uint32_t k, tfa_reply *reply);
    /* Of the same state X, v, and a and f of inverse dynamics of the accelerations in the reply. No
     * answer of this state comes from it afterwards but factors. */
    void (*copy_forces)(struct state *s, const tfa_reply *reply,
                        const struct tfa_factor_buffers *to);
};

#define TFA_BODY_LANES_KERNELS_MAX 2

/* The kernels compiled for one instruction set: one row of the table in backend.c. */
struct tfa_backend {
    const char *isa;
    const struct tfa_kernel *f64, *batch_f64, *batch_f32;
    /* NULL behind the last */
    const struct tfa_body_lanes_kernel *body_lanes[TFA_BODY_LANES_KERNELS_MAX];
    const struct tfa_segment_lanes_kernel *segment_lanes;
};

/* The best instruction set that this processor supports, or the one that TFA_ISA in the environment
 * names; NULL where it names none of them. */
const struct tfa_backend *tfa_backend_select(void);

/* Quadruple precision, on every processor */
extern const struct tfa_kernel tfa_kernel_f128_base;

#endif
