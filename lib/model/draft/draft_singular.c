/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots whose mass matrix is singular at every q. Elimination from the leaves inward gives for
 * each freedom the inertia D = H^T IA H + R that it moves when all freedoms outboard are free
 * (Featherstone 2008, 7.2); M is singular if a D is zero. In quadruple precision such a D is about
 * 1e-30 of the inertia of the subtree. D is analytic in q: zero at three arbitrary configurations
 * means zero everywhere.
 *
 * Freedoms coupled by mimics count as locked: M of the others is a principal submatrix of the
 * projected M, which is singular if that is.
 */
#include <math.h>
#include <stdlib.h>

#include "model/draft/draft.h"
#include "model/payload.h"

#define CONFIGURATIONS 3
/* Ratio below which D is zero, relative to the inertia with all outboard freedoms locked */
#define ZERO_RATIO 1e-24L
/* Ratio of a body's own inertia that suffices without its subtree */
#define SUFFICIENT_RATIO 1e-10L

/* Spatial vectors: angular, then linear. An articulated inertia is dense. */
struct singularity_check {
    struct draft *d;
    struct tfa_mass_properties *inertia; /* of each body, payloads included */
    ext *rounding;                       /* of each body: rounding of moments stated as products */
    ext (*IA)[36], (*IC)[36];            /* of each body: articulated, composite */
    uint8_t *coupled;                    /* of each joint: it follows or leads */
    uint8_t *singular_count; /* of each body: configurations with a freedom without inertia */
};

/* Pose of a frame in the parent's coordinates: axes E (rows), origin r */
struct pose {
    ext E[9], r[3];
};

struct motion {
    ext H[6][6]; /* one row for each freedom */
    ext R[6];    /* armature */
    uint32_t n;  /* freedoms that are not coupled */
    struct pose X;
};

/* ---- motions ---- */

/* A number in -2 .. 2, the same on every machine */
static ext random_number(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (ext)(int32_t)*seed / 0x40000000;
}

/* y = X m */
static void transform_motion(ext y[6], const struct pose *X, const ext m[6])
{
    const ext *r = X->r;
    const ext v[3] = {m[3] - (r[1] * m[2] - r[2] * m[1]), m[4] - (r[2] * m[0] - r[0] * m[2]),
                      m[5] - (r[0] * m[1] - r[1] * m[0])};
    for (int i = 0; i < 3; i++) {
        y[i] = X->E[3 * i] * m[0] + X->E[3 * i + 1] * m[1] + X->E[3 * i + 2] * m[2];
        y[3 + i] = X->E[3 * i] * v[0] + X->E[3 * i + 1] * v[1] + X->E[3 * i + 2] * v[2];
    }
}

/* Moves the frame along its axes, then turns it about its z. */
static void move_frame(struct pose *X, const ext shift[3], ext angle)
{
    ext s, c, moved[3];
    ext_apply_transposed(moved, X->E, shift);
    TFA_QUAD_SINCOS(angle, &s, &c);
    for (int k = 0; k < 3; k++) {
        const ext x = X->E[k], y = X->E[3 + k];
        X->r[k] += moved[k];
        X->E[k] = c * x + s * y;
        X->E[3 + k] = c * y - s * x;
    }
}

/* Adds a freedom along component `axis` of the latest frame. */
static void add_freedom(const struct singularity_check *l, struct motion *m, int axis,
                        int32_t joint)
{
    if (joint >= 0 && l->coupled[joint])
        return;
    memset(m->H[m->n], 0, sizeof m->H[m->n]);
    m->H[m->n][axis] = 1;
    m->R[m->n++] = joint >= 0 ? draft_armature(l->d, (size_t)joint) : 0;
}

/* Adds a joint of one freedom and transforms the previous motions across it. */
static void add_single(const struct singularity_check *l, struct motion *m, const ext *E,
                       const ext *r, int prismatic, uint32_t joint, uint32_t *seed)
{
    struct pose X;
    const ext q = random_number(seed), shift[3] = {0, 0, prismatic ? q : 0};
    ext rotated[9], moved[3];
    memcpy(X.E, E, sizeof X.E);
    memcpy(X.r, r, sizeof X.r);
    move_frame(&X, shift, prismatic ? 0 : q);
    for (uint32_t k = 0; k < m->n; k++) {
        ext y[6];
        transform_motion(y, &X, m->H[k]);
        memcpy(m->H[k], y, sizeof y);
    }
    ext_mul(rotated, X.E, m->X.E);
    ext_apply_transposed(moved, m->X.E, X.r);
    memcpy(m->X.E, rotated, sizeof rotated);
    for (int e = 0; e < 3; e++)
        m->X.r[e] += moved[e];
    add_freedom(l, m, prismatic ? 5 : 2, (int32_t)joint);
}

/* Motions of the body's joint at an arbitrary q. A free joint has all six. */
static void joint_motion(const struct singularity_check *l, uint32_t i, uint32_t configuration,
                         struct motion *m)
{
    const struct draft_body *b = &l->d->body[i];
    uint32_t seed = 7919u * (i + 1) + 104729u * configuration;
    memset(m, 0, sizeof *m);
    ext_identity(m->X.E);
    for (uint32_t k = 0; is_fused(b->kind) && k < b->n; k++) {
        const struct draft_part *p = &l->d->part[b->first + k];
        add_single(l, m, p->E, p->r, is_prismatic(p->kind), p->joint, &seed);
    }
    if (joint_types[b->kind].freedoms == 1)
        add_single(l, m, b->E, b->r, is_prismatic(b->kind), (uint32_t)b->joint, &seed);
    if (!has_constant_axes(b->kind))
        return;
    ext shift[3];
    for (uint32_t k = 0; k < 3; k++) {
        const ext x = random_number(&seed);
        shift[k] = freedom_rotates(b->kind, k) ? 0 : x;
    }
    memcpy(m->X.E, b->E, sizeof b->E);
    memcpy(m->X.r, b->r, sizeof b->r);
    move_frame(&m->X, shift, random_number(&seed));
    for (int k = 0; k < b->n; k++)
        add_freedom(l, m, joint_types[b->kind].axis[k], b->joint);
}

/* ---- inertias ---- */

/* [I hx; -hx m], the rigid inertia about the frame's origin */
static void rigid_inertia(ext S[36], const struct tfa_mass_properties *b)
{
    const ext *h = b->h;
    const ext hx[9] = {0, -h[2], h[1], h[2], 0, -h[0], -h[1], h[0], 0};
    memset(S, 0, 36 * sizeof *S);
    for (int k = 0; k < 6; k++)
        S[6 * ext_row[k] + ext_col[k]] = S[6 * ext_col[k] + ext_row[k]] = b->I[k];
    for (int i = 0; i < 3; i++) {
        S[6 * (3 + i) + 3 + i] = b->mass;
        for (int j = 0; j < 3; j++)
            S[6 * i + 3 + j] = S[6 * (3 + j) + i] = hx[3 * i + j];
    }
}

/* u = S x; returns x^T S x */
static ext product(const ext S[36], const ext x[6], ext u[6])
{
    ext sum = 0;
    for (int i = 0; i < 6; i++) {
        u[i] = 0;
        for (int j = 0; j < 6; j++)
            u[i] += S[6 * i + j] * x[j];
        sum += x[i] * u[i];
    }
    return sum;
}

/* up += X^T S X */
static void add_to_parent(ext up[36], const struct pose *X, const ext S[36])
{
    ext columns[6][6], u[6][6];
    for (int k = 0; k < 6; k++) {
        const ext unit[6] = {k == 0, k == 1, k == 2, k == 3, k == 4, k == 5};
        transform_motion(columns[k], X, unit);
        (void)product(S, columns[k], u[k]);
    }
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            for (int e = 0; e < 6; e++)
                up[6 * i + j] += columns[i][e] * u[j][e];
}

/* Eliminates the freedoms, those with the largest remaining inertia first: IA <- IA - u u^T / D.
 * `size`: inertia with everything locked. Returns how many have none left. */
static uint32_t eliminate(const struct motion *m, ext IA[36], const ext IC[36], ext least,
                          ext rounding)
{
    uint8_t done[6] = {0};
    for (uint32_t left = m->n; left > 0; left--) {
        uint32_t best = 0;
        ext most = -1, D = 0, u[6], unused[6], taken[6] = {0};
        for (uint32_t k = 0; k < m->n; k++) {
            if (done[k])
                continue;
            const ext *H = m->H[k], size = ext_abs(product(IC, H, unused)) + m->R[k];
            const ext angular = H[0] * H[0] + H[1] * H[1] + H[2] * H[2];
            const ext inertia = product(IA, H, u) + m->R[k];
            const ext ratio =
                ext_abs(inertia) > rounding * angular && size > 0 ? ext_abs(inertia) / size : 0;
            if (ratio <= most)
                continue;
            most = ratio;
            best = k;
            D = inertia;
            memcpy(taken, u, sizeof taken);
        }
        if (!(most > least))
            return left;
        done[best] = 1;
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++)
                IA[6 * i + j] -= taken[i] * taken[j] / D;
    }
    return 0;
}

/* 1: the body's own inertia suffices for all its freedoms */
static int has_sufficient_inertia(const struct singularity_check *l, uint32_t i)
{
    const struct draft_body *b = &l->d->body[i];
    const struct tfa_mass_properties *inertia = &l->inertia[i];
    if (is_prismatic(b->kind))
        return inertia->mass > 0 || b->armature > 0;
    if (is_revolute(b->kind))
        return inertia->I[5] > SUFFICIENT_RATIO * (inertia->I[0] + inertia->I[3]) ||
               b->armature > 0;
    struct motion m;
    ext S[36], IA[36];
    joint_motion(l, i, 0, &m);
    rigid_inertia(S, inertia);
    memcpy(IA, S, sizeof IA);
    return eliminate(&m, IA, S, SUFFICIENT_RATIO, l->rounding[i]) == 0;
}

/* Counts singular bodies of a configuration. Returns whether one was singular in all so far. */
static int mark_singular_bodies(struct singularity_check *l, uint32_t configuration)
{
    int any = 0;
    for (uint32_t i = 0; i < l->d->bodies; i++) {
        rigid_inertia(l->IC[i], &l->inertia[i]);
        memcpy(l->IA[i], l->IC[i], sizeof l->IA[i]);
    }
    for (uint32_t i = l->d->bodies; i-- > 0;) {
        struct motion m;
        const int32_t up = l->d->body[i].parent;
        joint_motion(l, i, configuration, &m);
        if (eliminate(&m, l->IA[i], l->IC[i], ZERO_RATIO, l->rounding[i]) > 0)
            l->singular_count[i]++;
        any |= l->singular_count[i] == configuration + 1;
        if (up < 0)
            continue;
        add_to_parent(l->IA[up], &m.X, l->IA[i]);
        add_to_parent(l->IC[up], &m.X, l->IC[i]);
    }
    return any;
}

/* ---- mass properties ---- */

static void sum_mass_properties(struct singularity_check *l)
{
    const tfa_description *s = l->d->description;
    const tfa_scene *scene = l->d->options->scene;
    for (uint32_t i = 0; i < l->d->bodies; i++)
        l->inertia[i] = l->d->body[i].sum;
    for (size_t k = 0; k < s->link_count; k++) {
        const double *I = s->links[k].inertia;
        const int32_t body = l->d->frame[k].body;
        if (l->d->link[k].present && body >= 0 && (I[1] != 0 || I[2] != 0 || I[4] != 0))
            l->rounding[body] += 0x1p-51 * (fabs(I[0]) + fabs(I[3]) + fabs(I[5]));
    }
    for (size_t p = 0; scene && p < scene->payload_count; p++)
        for (size_t k = 0; k < s->link_count; k++) {
            const struct draft_frame *f = &l->d->frame[k];
            if (!l->d->link[k].present || f->body < 0 ||
                strcmp(s->links[k].name, scene->payloads[p].link) != 0)
                continue;
            struct tfa_xform_quad at;
            memcpy(at.E, f->R, sizeof at.E);
            memcpy(at.r, f->p, sizeof at.r);
            tfa_mass_properties_add_payload(&l->inertia[f->body], &at, &scene->payloads[p]);
        }
}

static void mark_coupled(struct singularity_check *l)
{
    for (size_t j = 0; j < l->d->description->joint_count; j++)
        if (l->d->joint[j].fate == TFA_FATE_FOLLOWS)
            l->coupled[j] = l->coupled[l->d->joint[j].leader] = 1;
}

/* ---- messages ---- */

/* Joint of the first child of body i, or of body i itself */
static uint32_t first_outboard_joint(const struct draft *d, uint32_t i)
{
    for (uint32_t k = i + 1; k < d->bodies; k++)
        if (d->body[k].parent == (int32_t)i)
            return is_fused(d->body[k].kind) ? d->part[d->body[k].first].joint
                                             : (uint32_t)d->body[k].joint;
    return (uint32_t)d->body[i].joint;
}

static void refuse(const struct draft *d, uint32_t i, tfa_report *report)
{
    const tfa_description *s = d->description;
    const struct draft_body *b = &d->body[i];
    const char *link = s->links[b->link].name;
    if (b->base) {
        tfa_report_add(report, TFA_ERROR, s->links[b->link].line, "singular-mass",
                       "link '%s': nothing resists one of the six freedoms of the floating base, "
                       "so the mass matrix is singular at every q; give the link an inertia about "
                       "all axes, or let another link be the root",
                       link);
        return;
    }
    const tfa_joint *joint = &s->joints[b->joint];
    const tfa_joint *beyond = &s->joints[first_outboard_joint(d, i)];
    if (is_fused(b->kind))
        tfa_report_add(
            report, TFA_ERROR, joint->line, "singular-mass",
            "joint '%s': between it and joint '%s' nothing has mass, and these %u joints move in "
            "fewer ways, so the mass matrix is singular at every q; give a link between them mass "
            "or one of the joints armature, or lock one of them",
            joint->name, s->joints[d->part[b->first].joint].name, b->n);
    else if (!(b->sum.mass > 0) && beyond != joint)
        tfa_report_add(report, TFA_ERROR, joint->line, "singular-mass",
                       "joint '%s': link '%s' has no mass, and joint '%s' moves what hangs from it "
                       "in the same way, so the mass matrix is singular at every q; give the link "
                       "mass or the joint armature, or lock one of the joints",
                       joint->name, link, beyond->name);
    else
        tfa_report_add(report, TFA_ERROR, joint->line, "singular-mass",
                       "joint '%s': link '%s' and what hangs from it have no inertia that resists "
                       "it, so the mass matrix is singular at every q; give the link an inertia "
                       "about the axis or the joint armature, or lock the joint",
                       joint->name, link);
}

static int check_configurations(struct singularity_check *l, tfa_report *report)
{
    int status = TFA_OK;
    for (uint32_t p = 0; p < CONFIGURATIONS; p++)
        if (!mark_singular_bodies(l, p))
            return TFA_OK;
    for (uint32_t i = 0; i < l->d->bodies; i++)
        if (l->singular_count[i] == CONFIGURATIONS) {
            refuse(l->d, i, report);
            status = TFA_E_NO_MASS;
        }
    return status;
}

int tfa_draft_singular(struct draft *d, tfa_report *report)
{
    const size_t n = d->bodies + 1u;
    struct singularity_check l = {.d = d,
                                  .inertia = calloc(n, sizeof *l.inertia),
                                  .rounding = calloc(n, sizeof *l.rounding),
                                  .IA = malloc(n * sizeof *l.IA),
                                  .IC = malloc(n * sizeof *l.IC),
                                  .coupled = calloc(d->description->joint_count + 1, 1),
                                  .singular_count = calloc(n, 1)};
    int status = TFA_E_MEMORY;
    if (l.inertia && l.rounding && l.IA && l.IC && l.coupled && l.singular_count) {
        int sufficient = 1;
        sum_mass_properties(&l);
        mark_coupled(&l);
        for (uint32_t i = 0; sufficient && i < d->bodies; i++)
            sufficient = has_sufficient_inertia(&l, i);
        status = sufficient ? TFA_OK : check_configurations(&l, report);
    }
    free(l.singular_count);
    free(l.coupled);
    free(l.IC);
    free(l.IA);
    free(l.rounding);
    free(l.inertia);
    return status;
}
