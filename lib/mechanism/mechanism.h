/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Test mechanisms of any size: chains and trees that are easy or hard for a method, and known to
 * be so. The same options give the same numbers on every machine.
 */
#ifndef TFA_MECHANISM_MECHANISM_H
#define TFA_MECHANISM_MECHANISM_H

#include <stdint.h>
#include <stdio.h>
#include <totalforce/description.h>

/* X(NAME, name on the command line, description) */
#define MECHANISM_LIST(X)                                                                          \
    X(STRAIGHT, "straight", "a straight chain, axes across it by turns")                           \
    X(ZIGZAG, "zigzag", "bent by 1 rad to and fro, axes by turns in and across its plane")         \
    X(HELIX, "helix", "bent by 0.6 and twisted by 0.1 rad at every joint, axes by turns")          \
    X(RANDOM, "random", "hinges across the links, twisted and bent at random within 0.9 rad")      \
    X(TAPER, "taper", "random; masses fall by `taper` from root to tip, radii by its root")        \
    X(HEAVY_TIP, "heavy-tip", "random; the last body has `ratio` times the mass of the others")    \
    X(ALTERNATING, "alternating", "random; every second body has `ratio` times the mass")          \
    X(THIN, "thin", "random; rods of a very small radius")                                         \
    X(LIGHT_HEAVY, "light-heavy", "random; the outboard half has `ratio` times the mass")          \
    X(MASSLESS, "massless", "random; every second body, never the tip, is massless")               \
    X(RANK_DEFICIENT, "rank-deficient", "random; ideal rods and point masses among ordinary rods") \
    X(SIDE_BRANCHES, "side-branches", "random; half the bodies hang from a main chain in pairs")   \
    X(PLANAR, "planar", "as random, without the twists: all axes parallel")                        \
    X(COIL, "coil", "Featherstone 1999: 1 m of short rods, 2.5 turns about its axis")              \
    X(DILL, "dill", "Featherstone 1999: a fractal tree; a body of level L carries L dills below it")

typedef enum mechanism_kind {
#define MECHANISM_ENUM(name, text, what) MECHANISM_##name,
    MECHANISM_LIST(MECHANISM_ENUM)
#undef MECHANISM_ENUM
        MECHANISM_COUNT
} mechanism_kind;

enum { MECHANISM_BODIES_MAX = 16384 };

/** Options of a mechanism: start with mechanism_defaults(). All links are 1 m long along
 * their z, all joints revolute; an ordinary body is a uniform rod of 1 kg. A mechanism is what its
 * name says at q = 0: bends and twists stand in the joint frames.
 *
 * coil and dill are those of the accuracy study of the divide-and-conquer algorithm (Featherstone
 * 1999, part 2, as Bullet's btInverseDynamics has them), with frames of Denavit and Hartenberg and
 * rods along x. coil: N rods of 1/N kg, 1/N m and the radius; a = 1/N m, alpha = 5 pi / N. dill: a
 * body of level L and size s = max(L, 1) is a rod of 0.1 s^3 kg, 0.1 s m, s times the radius; it
 * carries dills of levels 0 .. L - 1, the i-th at a = 0.1 i m, alpha = i pi / 3 and d = 0.01 s m,
 * the last at d = 0. 2^L bodies; of other numbers the first, depth first.
 */
typedef struct mechanism_options {
    mechanism_kind kind;
    uint32_t bodies; /**< moving bodies, 1..MECHANISM_BODIES_MAX; the fixed base is one link more */
    double radius;   /**< m: 0.1; thin 1e-4; coil, dill 0.01 */
    double ratio;    /**< heavy over light mass: 1e6 where the kind uses it */
    double taper;    /**< mass of the tip over mass of the root: 0.01 where the kind uses it */
    double curl;     /**< scale of the bends that stand in the joint frames: at q = 0 the chain is
                          straight for 0 and as its kind says for 1; no effect on straight */
    uint64_t seed;
} mechanism_options;

mechanism_options mechanism_defaults(mechanism_kind kind, uint32_t bodies);

/** Kind of that name, or -1. */
int mechanism_find(const char *name);
const char *mechanism_name(mechanism_kind kind);
/** The same for command_line_values: NULL after the last. */
const char *mechanism_word(size_t index);

/**
 * The error in the options, in one sentence that names value and remedy.
 * @return 0 and "" if nothing, -1 otherwise
 */
int mechanism_check(const mechanism_options *options, char *text, size_t size);

/** Writes the mechanism as URDF, numbers with 17 digits. Options must pass mechanism_check. */
void mechanism_write(const mechanism_options *options, FILE *out);

/**
 * The mechanism as a description: exactly as loading the output of mechanism_write gives, since
 * that is how it is made. Release with mechanism_free.
 * @return NULL when out of memory or when the options are bad
 */
tfa_description *mechanism_make(const mechanism_options *options);

void mechanism_free(tfa_description *description);

/* splitmix64: any seed is a good seed, and the same numbers come out everywhere. */

uint64_t mechanism_random_bits(uint64_t *state);
/** Uniform in [low, high). */
double mechanism_random_uniform(uint64_t *state, double low, double high);
/** Normal, mean 0, variance 1: the sum of twelve uniform numbers, which needs no libm and so is
 *  the same on every machine; it never exceeds 6. */
double mechanism_random_normal(uint64_t *state);

#endif
