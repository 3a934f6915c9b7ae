/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a compiled variant of the kernels offers to the rest of the library, and to another variant
 * whose answers it refines.
 */
#ifndef TFA_KERNEL_TABLE_H
#define TFA_KERNEL_TABLE_H

#include <totalforce/dynamics.h>

struct scan_segment;
struct state;
struct strips;
struct tfa_crew;
struct tfa_strip_ends;
struct tfa_wider;
struct tfa_packing;

/* Where a kernel keeps the articulated-body factors of each body (state.h), in numbers of its precision,
 * for another that computes them: X, U and 1/D of joints with one freedom, 12, 6 and 1 numbers a body;
 * and of joints with several, `multi_bytes` apart. */
struct tfa_factors {
    void *X, *U, *Dinv;
    char *part, *H, *multi_U, *L;
    size_t multi_bytes;
};

/* Above this estimate the answer of a method that lost too much is replaced
 * (methods.md section 4: over 180 cases nothing worse passed unnoticed). */
#define FALLBACK_ESTIMATE 1e-4

/* What became of a state; alarmed: the sentinel tripped (sentinel.h), the error is to be estimated. */
enum { TFA_NOT_ANSWERED = 0, TFA_ANSWERED = 1, TFA_ANSWERED_ALARMED = 2 };

/* States of one batch at most */
#define TFA_LANES_MAX 16

/* The methods that answer a request, never TFA_METHOD_AUTO: its op, and lambda_inv where that is asked
 * for besides qdd. */
struct tfa_resolved {
    tfa_method method, osim;
};

/* One compiled variant of the kernels: of one state at a time, or of a batch of states in lanes. The
 * members behind `set_residual_kernel` are of one state at a time only, NULL elsewhere. */
struct tfa_kernel {
    const char *isa;
    tfa_precision precision;
    uint32_t lanes;         /* states at a time */
    int (*supported)(void); /* every CPU feature that the flags allow is present */
    /* With memory for these methods: bits 1u << tfa_method */
    size_t (*size)(const tfa_model *model, uint32_t methods);
    struct state *(*init)(const tfa_model *model, uint32_t methods, void *memory);
    /* States k .. k + count - 1, at most `lanes`, of a checked request; fills as many answers, and
     * field/index of the reply on failure. Where several states do not go the same way, or one of them
     * has no answer, returns a status that is not TFA_OK, and nothing that was written counts. */
    int (*answer)(struct state *s, const tfa_request *request, struct tfa_resolved by, uint32_t k,
                  uint32_t count, tfa_reply *reply, tfa_answer *answers);
    /* From now on refinement of single states in s has its residual from `wider`, which outlives s. */
    void (*widen)(struct state *s, const struct tfa_wider *wider);

    /* Sines and cosines of `count` doubles, written by the vector (variants/sincos.h): what the kernels of
     * one robot's own call. */
    void (*sincos)(const double *x, double *sine, double *cosine, size_t count);

    struct tfa_factors (*lend)(struct state *s);
    /* What a state of a checked request, which changes nothing about the robot, asks of its tips, with
     * the factors of the bodies that carry them: of another kernel, written where lend said. Lambda^-1
     * is neither refined nor estimated. Returns whether all of it is finite. */
    int (*answer_tips)(struct state *s, const tfa_request *request, struct tfa_resolved by,
                       uint32_t k, tfa_reply *reply, tfa_answer *answer);

    /* Estimates the error of the accelerations of state k, which stand in the reply, by the factors of aba.
     * Returns 0 where they are in doubt: the estimate is above `limit`, 1e-4, or not finite. */
    int (*estimate)(struct state *s, const tfa_request *request, uint32_t k, const tfa_reply *reply,
                    double limit, tfa_answer *answer);

    /* From now on this crew works on a solve in s, until another is named; NULL: the caller alone. */
    void (*employ)(struct state *s, struct tfa_crew *crew);
    /* From now on sines and cosines are rounded to double, where numbers are wider. */
    void (*round_sincos)(struct state *s);

    /* The scan over segments in lanes (strips.h); `segments` is memory of strips_bytes(). */
    size_t (*strips_bytes)(void);
    /* v_in from E, r, v_end (first); then dv_in from E, r, v_in and the v_end that came of it, so
     * that no velocity jumps where segments meet. Without, light bodies on long levers (links of
     * 1 mm, joints 1 m apart, 1024 bodies) had 5 times the error of aba, with it 1.0 (median of 7,
     * 2026-11-22); */
    void (*strips_travel)(struct tfa_strip_ends *ends, int first);
    /* the segments joined. Returns whether some cut is `light` or lighter (scan.h): `known` is then
     * what hangs there, with which all want to be computed again; */
    int (*strips_join)(struct scan_segment *segments, struct tfa_strip_ends *ends, double light);
    /* a_in and f_out from a_end and g. */
    void (*strips_pass)(struct scan_segment *segments, struct tfa_strip_ends *ends,
                        const double gravity[3]);
    /* what is to be added to both, from the a_end that they led to. */
    void (*strips_close)(struct scan_segment *segments, struct tfa_strip_ends *ends);

    /* As the residual kernel of another: reads state k of a checked request; */
    void (*load)(struct state *s, const tfa_request *request, uint32_t k);
    /* x = dx (fresh) or x += dx, as follows for followers; */
    void (*add)(struct state *s, const double *dx, int fresh);
    /* residual = tau - RNEA(x), perturbed (rnea_perturbed) or not. Returns |x|; */
    double (*residual)(struct state *s, double *residual, int perturbed);
    /* writes x to the reply. Returns 1 when all of it is finite. */
    int (*unload)(const struct state *s, uint32_t k, tfa_reply *reply);
};

/* Another kernel with a state of the same model: where refinement has its residual from, in wider
 * arithmetic, and where the solution is summed up. */
struct tfa_wider {
    const struct tfa_kernel *kernel;
    struct state *state;
};

struct pieces;
struct tfa_crew;

/* Who solves M x = residual for an estimate, at the coordinates of the request; public order. Returns
 * whether all of x is finite. */
struct tfa_judge {
    int (*solve)(struct tfa_judge *judge, const double *residual, double *x);
};

/* One state of a long chain of revolute bodies, its pieces side by side: forward dynamics by tfa-cr
 * and cfa-cr. */
struct tfa_pieces {
    size_t (*size)(const tfa_model *model); /* 0: not a robot for it */
    struct pieces *(*init)(const tfa_model *model, void *memory);
    /* State k of a checked request which changes nothing about the robot, with refinement and
     * estimate. Returns 0 where the answer is in doubt: it is left to one number at a time. */
    int (*answer)(struct pieces *p, struct tfa_crew *crew, const tfa_request *request, uint32_t k,
                  struct tfa_judge *judge, tfa_reply *reply, tfa_answer *answer);
    /* Lambda^-1 of one tip, neither refined nor estimated. Returns 0 also where the tip is not on the
     * last body. */
    int (*answer_lambda)(struct pieces *p, struct tfa_crew *crew, const tfa_request *request,
                         uint32_t k, tfa_reply *reply, tfa_answer *answer);
};

/* Forward dynamics of one state of a long chain, its segments in lanes. For robots that
 * tfa_cut_strips takes. */
struct tfa_strips_kernel {
    /* `one` scans over the segments. */
    size_t (*size)(const tfa_model *model, const struct tfa_kernel *one);
    struct strips *(*init)(const tfa_model *model, const struct tfa_kernel *one, void *memory);
    /* State k of a checked request, which changes nothing about the robot. light: strips_join.
     * TFA_NOT_ANSWERED: some acceleration is not finite. */
    int (*answer)(struct strips *s, struct tfa_crew *crew, const tfa_request *request, uint32_t k,
                  double light, tfa_reply *reply);
};

/* One state at a time, its independent limbs side by side: forward dynamics by aba, and the factors that
 * tips ask for. */
struct tfa_limbs {
    uint32_t lanes;
    double step; /* time for one step of the packing, in bodies that go one by one */
    size_t (*size)(const tfa_model *model, const struct tfa_packing *packing);
    struct state *(*init)(const tfa_model *model, const struct tfa_packing *packing, void *memory);
    /* State k of a checked request, which changes nothing about the robot and has no mimics: its
     * accelerations, where they are asked for, and its factors. TFA_NOT_ANSWERED: some are not finite. */
    int (*answer)(struct state *s, const tfa_request *request, uint32_t k, tfa_reply *reply);
    /* Of the accelerations that came last, as tfa_kernel.estimate */
    int (*estimate)(struct state *s, double limit, tfa_answer *answer);
    /* Of the state that came last, the factors of all bodies that carry a tip of the request. Whether
     * they are finite is left to who uses them. */
    void (*give)(const struct state *s, const tfa_request *request, const struct tfa_factors *to);
};

#define TFA_LIMBS_MAX 2

/* The kernels compiled for one instruction set: one row of the table in backend.c. */
struct tfa_backend {
    const struct tfa_kernel *f64, *batch_f64, *batch_f32;
    const struct tfa_limbs *limbs[TFA_LIMBS_MAX]; /* NULL behind the last */
    const struct tfa_strips_kernel *strips;
    const struct tfa_pieces *pieces;
};

/* The best instruction set that this processor supports, or the one that TFA_ISA in the environment
 * names; NULL where it names none of them. */
const struct tfa_backend *tfa_backend_select(void);

/* Quadruple precision, on every processor */
extern const struct tfa_kernel tfa_kernel_f128_base;

#endif
