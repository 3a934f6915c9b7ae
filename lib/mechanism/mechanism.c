/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Test mechanisms. They are written as URDF and read back, so that a mechanism in memory and one
 * in a file are the same numbers.
 */
#include "mechanism.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[] = {
#define MECHANISM_ROW(name, text, what) text,
    MECHANISM_LIST(MECHANISM_ROW)
#undef MECHANISM_ROW
};

const char *mechanism_name(mechanism_kind kind)
{
    return (unsigned)kind < MECHANISM_COUNT ? names[kind] : "unknown";
}

const char *mechanism_word(size_t index)
{
    return index < MECHANISM_COUNT ? names[index] : NULL;
}

int mechanism_find(const char *name)
{
    for (int i = 0; i < MECHANISM_COUNT; i++)
        if (strcmp(names[i], name) == 0)
            return i;
    return -1;
}

uint64_t mechanism_random_bits(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double mechanism_random_uniform(uint64_t *state, double low, double high)
{
    return low + (high - low) * (double)(mechanism_random_bits(state) >> 11) * 0x1p-53;
}

double mechanism_random_normal(uint64_t *state)
{
    double sum = -6.0;
    for (int i = 0; i < 12; i++)
        sum += mechanism_random_uniform(state, 0.0, 1.0);
    return sum;
}

mechanism_options mechanism_defaults(mechanism_kind kind, uint32_t bodies)
{
    return (mechanism_options){.kind = kind,
                               .bodies = bodies,
                               .radius = kind == MECHANISM_THIN                             ? 1e-4
                                         : kind == MECHANISM_COIL || kind == MECHANISM_DILL ? 0.01
                                                                                            : 0.1,
                               .ratio = 1e6,
                               .taper = 0.01,
                               .curl = 1.0,
                               .seed = 1};
}

int mechanism_check(const mechanism_options *options, char *text, size_t size)
{
    static const char *const positive[] = {"radius", "ratio", "taper"};
    const double values[] = {options->radius, options->ratio, options->taper};
    snprintf(text, size, "%s", "");
    if ((unsigned)options->kind >= MECHANISM_COUNT)
        return snprintf(text, size, "kind: %d, there are 0 to %d", (int)options->kind,
                        MECHANISM_COUNT - 1),
               -1;
    if (options->bodies < 1 || options->bodies > MECHANISM_BODIES_MAX)
        return snprintf(text, size, "bodies: %" PRIu32 ", must be 1 to %d", options->bodies,
                        MECHANISM_BODIES_MAX),
               -1;
    for (int i = 0; i < 3; i++)
        if (!(values[i] >= 1e-15 && values[i] <= 1e15))
            return snprintf(text, size, "%s: %g, must be 1e-15 to 1e15", positive[i], values[i]),
                   -1;
    if (!(options->curl >= 0.0 && options->curl <= 1.0))
        return snprintf(text, size, "curl: %g, must be 0 (straight) to 1 (curled)", options->curl),
               -1;
    return 0;
}

/* One moving body: a rod along z, or x, and the joint that carries it. */
typedef struct body {
    uint32_t parent;     /* 0: the base; otherwise body number parent, counted from 1 */
    int along_x;
    double length;       /* m */
    double xyz[3];       /* of the joint frame in the parent link frame */
    double rpy[3];       /* the same */
    double axis[3];      /* in the joint frame */
    double mass, radius; /* radius 0: an ideal rod */
    int point;           /* all mass in the middle of the link */
} body;

/* Bends and twists, rad: wide enough that no two links are parallel, narrow enough that a chain
 * stays stretched out. Wider bends curl it up and make it benign: with +-pi about any axis the
 * errors of 1024 bodies are 20 to 50 times smaller. */
#define RANDOM_ANGLE 0.9
#define HELIX_BEND 0.6
#define HELIX_TWIST 0.1

/* Joint frame and axis of body `i`, counted from 1. The frame is that of the parent's end, twisted
 * about the link and then bent about its x. */
static void place_joint_frame(const mechanism_options *options, uint32_t i, uint64_t *state,
                              body *b)
{
    double *bend = &b->rpy[0], *twist = &b->rpy[2];
    b->axis[(i - 1) % 2] = 1.0; /* across the link, x and y by turns */
    switch (options->kind) {
    case MECHANISM_STRAIGHT:
        return;
    case MECHANISM_ZIGZAG:
        b->rpy[1] = i % 2 ? -1.0 : 1.0;
        break;
    case MECHANISM_HELIX:
        *bend = HELIX_BEND;
        *twist = HELIX_TWIST;
        break;
    default: /* a revolute joint across the link, bent about its own axis */
        memcpy(b->axis, (const double[3]){1.0, 0.0, 0.0}, sizeof b->axis);
        *bend = mechanism_random_uniform(state, -RANDOM_ANGLE, RANDOM_ANGLE);
        if (options->kind != MECHANISM_PLANAR)
            *twist = mechanism_random_uniform(state, -RANDOM_ANGLE, RANDOM_ANGLE);
    }
    for (int k = 0; k < 3; k++)
        b->rpy[k] *= options->curl;
}

/* Mass and thickness of body `i`, counted from 1. */
static void set_mass(const mechanism_options *options, uint32_t i, body *b)
{
    uint32_t count = options->bodies;
    b->mass = 1.0;
    b->radius = options->radius;
    switch (options->kind) {
    case MECHANISM_TAPER:
        b->mass = count > 1 ? pow(options->taper, (i - 1.0) / (count - 1.0)) : 1.0;
        b->radius *= sqrt(b->mass); /* of one material, as long as the others */
        break;
    case MECHANISM_HEAVY_TIP:
        b->mass = i == count ? options->ratio : 1.0;
        break;
    case MECHANISM_ALTERNATING:
        b->mass = i % 2 ? 1.0 : options->ratio;
        break;
    case MECHANISM_LIGHT_HEAVY:
        b->mass = i > count / 2 ? options->ratio : 1.0;
        break;
    case MECHANISM_MASSLESS:
        b->mass = (count - i) % 2 ? 0.0 : 1.0;
        break;
    case MECHANISM_RANK_DEFICIENT: /* by turns from the tip: ordinary, ideal rod, point */
        b->point = (count - i) % 3 == 2;
        b->radius = (count - i) % 3 ? 0.0 : options->radius;
        break;
    default:
        break;
    }
}

/* Groups of four: two bodies of the main chain, then two that hang from the first of them. */
static uint32_t parent_of(const mechanism_options *options, uint32_t i)
{
    if (options->kind != MECHANISM_SIDE_BRANCHES || i == 1)
        return i - 1;
    switch ((i - 1) % 4) {
    case 0:
        return i - 3; /* past the side branch to the main chain */
    case 2:
        return i - 2;
    default:
        return i - 1;
    }
}

static void write_body(const body *b, uint32_t i, FILE *out)
{
    const double l = b->length, middle[2] = {l / 2, 0};
    double across = b->point ? 0.0 : b->mass * (3.0 * b->radius * b->radius + l * l) / 12.0;
    double along = b->point ? 0.0 : b->mass * b->radius * b->radius / 2.0;
    fprintf(out, "  <link name=\"link%" PRIu32 "\">\n", i);
    if (b->mass > 0.0)
        fprintf(out,
                "    <inertial>\n      <origin xyz=\"%.17g 0 %.17g\" rpy=\"0 0 0\"/>\n"
                "      <mass value=\"%.17g\"/>\n"
                "      <inertia ixx=\"%.17g\" ixy=\"0\" ixz=\"0\" iyy=\"%.17g\" iyz=\"0\" "
                "izz=\"%.17g\"/>\n    </inertial>\n",
                middle[!b->along_x], middle[b->along_x], b->mass, b->along_x ? along : across,
                across, b->along_x ? across : along);
    fprintf(out, "  </link>\n  <joint name=\"joint%" PRIu32 "\" type=\"continuous\">\n", i);
    if (b->parent == 0)
        fputs("    <parent link=\"base\"/>\n", out);
    else
        fprintf(out, "    <parent link=\"link%" PRIu32 "\"/>\n", b->parent);
    fprintf(out,
            "    <child link=\"link%" PRIu32 "\"/>\n"
            "    <origin xyz=\"%.17g %.17g %.17g\" rpy=\"%.17g %.17g %.17g\"/>\n"
            "    <axis xyz=\"%.17g %.17g %.17g\"/>\n  </joint>\n",
            i, b->xyz[0], b->xyz[1], b->xyz[2], b->rpy[0], b->rpy[1], b->rpy[2], b->axis[0],
            b->axis[1], b->axis[2]);
}

/* A rod along x whose joint frame is given by Denavit and Hartenberg's a, alpha and d */
static body rod_along_x(uint32_t parent, double length, double a, double alpha, double d)
{
    return (body){.parent = parent,
                  .along_x = 1,
                  .length = length,
                  .xyz = {a, -sin(alpha) * d, cos(alpha) * d},
                  .rpy = {alpha, 0, 0},
                  .axis = {0, 0, 1}};
}

static void write_coil(const mechanism_options *options, FILE *out)
{
    const double n = options->bodies;
    for (uint32_t i = 1; i <= options->bodies; i++) {
        body b = rod_along_x(i - 1, 1 / n, 1 / n, options->curl * 5 * M_PI / n, 0);
        b.mass = 1 / n;
        b.radius = options->radius;
        write_body(&b, i, out);
    }
}

/* A dill of a level, the k-th on a parent of this size; the first `options->bodies` bodies only */
static void write_dill(const mechanism_options *options, FILE *out, uint32_t level, uint32_t parent,
                       double size, uint32_t k, uint32_t *bodies)
{
    if (*bodies == options->bodies)
        return;
    const uint32_t own = ++*bodies;
    const double s = level ? level : 1, d = level + 1.0 == size ? 0 : 0.01 * size;
    body b = rod_along_x(parent, 0.1 * s, 0.1 * k, options->curl * k * M_PI / 3, parent ? d : 0);
    b.mass = 0.1 * s * s * s;
    b.radius = options->radius * s;
    write_body(&b, own, out);
    for (uint32_t child = 1; child <= level; child++)
        write_dill(options, out, child - 1, own, level, child, bodies);
}

static void write_dills(const mechanism_options *options, FILE *out)
{
    uint32_t level = 0, bodies = 0;
    while ((UINT32_C(1) << level) < options->bodies)
        level++;
    write_dill(options, out, level, 0, 0, 0, &bodies);
}

static void write_chain(const mechanism_options *options, FILE *out)
{
    uint64_t state = options->seed;
    for (uint32_t i = 1; i <= options->bodies; i++) {
        body b = {.parent = parent_of(options, i), .length = 1};
        b.xyz[2] = b.parent > 0;
        place_joint_frame(options, i, &state, &b);
        set_mass(options, i, &b);
        write_body(&b, i, out);
    }
}

void mechanism_write(const mechanism_options *options, FILE *out)
{
    /* short options: a comment must not hold two hyphens in a row */
    fprintf(out, "<?xml version=\"1.0\"?>\n<!-- totalforce chain %s -n %" PRIu32,
            mechanism_name(options->kind), options->bodies);
    fprintf(out, " -r %.17g -m %.17g -t %.17g -c %.17g -s %" PRIu64 " -->\n", options->radius,
            options->ratio, options->taper, options->curl, options->seed);
    fprintf(out, "<robot name=\"%s-%" PRIu32 "\">\n  <link name=\"base\"/>\n",
            mechanism_name(options->kind), options->bodies);
    if (options->kind == MECHANISM_COIL)
        write_coil(options, out);
    else if (options->kind == MECHANISM_DILL)
        write_dills(options, out);
    else
        write_chain(options, out);
    fputs("</robot>\n", out);
}

tfa_description *mechanism_make(const mechanism_options *options)
{
    char why[128];
    char *text = NULL;
    size_t length = 0;
    tfa_description *description = NULL;
    tfa_report report = {0};
    if (mechanism_check(options, why, sizeof why) != 0)
        return NULL;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return NULL;
    mechanism_write(options, out);
    int broken = ferror(out);
    broken |= fclose(out) != 0;
    if (!broken && tfa_urdf_parse(text, length, mechanism_name(options->kind), &description,
                                  &report) != TFA_OK)
        description = NULL;
    tfa_report_free(&report);
    free(text);
    return description;
}

void mechanism_free(tfa_description *description)
{
    tfa_description_free(description);
}
