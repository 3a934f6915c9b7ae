/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Modes of flexible links: which bodies have them, and what rides on their handles.
 */
#include <math.h>
#include <string.h>
#include <totalforce/text.h>

#include "model/draft/draft.h"

#define REFUSE(text, ...)                                                                          \
    TFA_REFUSE(report, TFA_E_MODEL, 0, "modes", "link '%s': " text, __VA_ARGS__)

/* A pivot of the mass matrix that is lower, beside its diagonal, is negative and no rounding. */
#define PIVOT_MIN (-1e-9)

static const char *name_of_link(const void *description, size_t index)
{
    return ((const tfa_description *)description)->links[index].name;
}

static const tfa_link_modes *modes_of(const struct draft *d, const char *link)
{
    const tfa_scene *scene = d->options->scene;
    for (size_t k = 0; scene && k < scene->modes_count; k++)
        if (scene->modes[k].link && strcmp(scene->modes[k].link, link) == 0)
            return &scene->modes[k];
    return NULL;
}

/* ---- what the side file states ---- */

/* Whether `count` numbers are there and finite */
static int are_finite(const double *x, size_t count)
{
    for (size_t k = 0; x && k < count; k++)
        if (!isfinite(x[k]))
            return 0;
    return x != NULL;
}

static int is_symmetric(const double *A, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            if (fabs(A[n * i + j] - A[n * j + i]) >
                1e-9 * (fabs(A[n * i + i]) + fabs(A[n * j + j])))
                return 0;
    return 1;
}

/* Error of the numbers, for a message; NULL: none */
static const char *fault(const tfa_link_modes *x)
{
    const size_t n = x->mode_count;
    if (n < 1 || n > TFA_MAX_LINK_MODES)
        return "a link has 1 to 12 modes; leave out those of high frequency";
    if (!are_finite(x->momentum, 6 * n))
        return "momentum is not 6 finite numbers a mode";
    if (!are_finite(x->mass, n * n) || !is_symmetric(x->mass, n))
        return "the modal mass is not a symmetric matrix of finite numbers";
    if (!are_finite(x->stiffness, n * n) || !is_symmetric(x->stiffness, n))
        return "the stiffness is not a symmetric matrix of finite numbers";
    if (x->damping && (!are_finite(x->damping, n * n) || !is_symmetric(x->damping, n)))
        return "the damping is not a symmetric matrix of finite numbers";
    for (size_t k = 0; x->limit && k < n; k++)
        if (!(x->limit[k] > 0))
            return "a limit is not above 0";
    return NULL;
}

static int check_links(const struct draft *d, tfa_report *report)
{
    const tfa_scene *scene = d->options->scene;
    const tfa_description *s = d->description;
    for (size_t k = 0; scene && k < scene->modes_count; k++) {
        const char *name = scene->modes[k].link ? scene->modes[k].link : "(none)";
        const char *wrong = fault(&scene->modes[k]);
        size_t link = 0;
        char nearest[200];
        while (link < s->link_count && strcmp(s->links[link].name, name) != 0)
            link++;
        tfa_suggest(name, s, s->link_count, name_of_link, nearest, sizeof nearest);
        if (link == s->link_count)
            return REFUSE("it has modes, but the robot has no such link; nearest: %s", name,
                          nearest);
        if (wrong)
            return REFUSE("%s", name, wrong);
        if (modes_of(d, name) != &scene->modes[k])
            return REFUSE("its modes are given twice; remove one", name);
    }
    return TFA_OK;
}

/* ---- the link on its body ---- */

void tfa_draft_momentum(const struct draft *d, const struct draft_flexible *x, size_t mode,
                        ext a[3], ext l[3])
{
    static const ext none[3];
    const struct draft_frame *f = &d->frame[x->link];
    const double *p = x->modes->momentum + 6 * mode;
    ext linear[3], angular[3];
    ext_from_double(linear, p, 3);
    ext_from_double(angular, p + 3, 3);
    ext_apply(l, f->R, linear, none);
    ext_apply(a, f->R, angular, none);
    ext_add_cross(a, f->p, l);
}

/* The mass matrix of the link with its modes, body axes, LDL^T with pivots on the diagonal. Returns
 * 0 where a pivot is negative, of the modes alone (they come first) or of all. */
static int is_physical(const struct draft *d, const struct draft_flexible *x)
{
    const size_t n = x->modes->mode_count, all = n + 6;
    struct tfa_mass_properties m = {0};
    long double A[TFA_MAX_LINK_MODES + 6][TFA_MAX_LINK_MODES + 6] = {{0}};
    tfa_draft_add_link(d, x->link, &m);
    for (size_t i = 0; i < n; i++) {
        ext a[3], l[3];
        tfa_draft_momentum(d, x, i, a, l);
        for (size_t j = 0; j < n; j++)
            A[i][j] = x->modes->mass[n * i + j];
        for (int e = 0; e < 3; e++) {
            A[n + (size_t)e][i] = (long double)a[e];
            A[n + 3 + (size_t)e][i] = (long double)l[e];
        }
    }
    for (int e = 0; e < 6; e++)
        A[n + (size_t)ext_col[e]][n + (size_t)ext_row[e]] = (long double)m.I[e];
    for (size_t e = 0; e < 3; e++) {
        A[n + 3 + e][n + 3 + e] = (long double)m.mass;
        A[n + 3 + e][n + (e + 1) % 3] = (long double)m.h[(e + 2) % 3];
        A[n + 3 + e][n + (e + 2) % 3] = -(long double)m.h[(e + 1) % 3];
    }
    for (size_t k = 0; k < all; k++) {
        const long double whole = fabsl(A[k][k]);
        for (size_t j = 0; j < k; j++)
            A[k][k] -= A[k][j] * A[k][j] * A[j][j];
        if (k < n ? !(A[k][k] > 1e-12L * whole) : A[k][k] < (long double)PIVOT_MIN * whole)
            return 0;
        for (size_t i = k + 1; i < all; i++) {
            for (size_t j = 0; j < k; j++)
                A[i][k] -= A[i][j] * A[k][j] * A[j][j];
            A[i][k] = A[k][k] > 1e-12L * whole ? A[i][k] / A[k][k] : 0;
        }
    }
    return 1;
}

static int add_flexible(struct draft *d, size_t link, tfa_report *report)
{
    const char *name = d->description->links[link].name;
    const tfa_link_modes *modes = d->link[link].present ? modes_of(d, name) : NULL;
    const struct draft_frame *f = &d->frame[link];
    if (!modes)
        return TFA_OK;
    if (f->body < 0)
        return REFUSE("it has modes, but does not move; put a joint before it", name);
    if (f->part)
        return REFUSE("it has modes, but is inside a body of several joints", name);
    if (d->body[f->body].flexible >= 0)
        return REFUSE("it is fixed to another flexible link; put a joint between them", name);
    if (d->link[link].loaded)
        return REFUSE("it has modes and a payload; put the payload on a link behind a fixed joint",
                      name);
    struct draft_flexible *x = &d->flexible[d->flexible_bodies];
    *x = (struct draft_flexible){modes, (uint32_t)link, (uint32_t)f->body};
    if (!is_physical(d, x))
        return REFUSE("its mass and its modes are not those of a body: the modal mass, or the "
                      "mass matrix with its momenta, is not positive; check units and inertia",
                      name);
    d->body[f->body].flexible = (int32_t)d->flexible_bodies++;
    d->modes += (uint32_t)modes->mode_count;
    return TFA_OK;
}

/* ---- handles ---- */

/* A child joint of a flexible link is a handle; what hangs from links on one rides on it. */
static int find_handle(struct draft *d, uint32_t j, int32_t *handle, tfa_report *report)
{
    const tfa_joint *joint = &d->description->joints[j];
    const int32_t body = d->frame[joint->parent].body;
    const int32_t flexible = body < 0 ? -1 : d->body[body].flexible;
    *handle = d->link[joint->parent].handle;
    if (flexible < 0 || d->flexible[flexible].link != joint->parent)
        return TFA_OK;
    const tfa_link_modes *x = d->flexible[flexible].modes;
    for (size_t k = 0; k < x->shape_count; k++)
        if (x->shapes[k].joint && strcmp(x->shapes[k].joint, joint->name) == 0) {
            if (!are_finite(x->shapes[k].shape, 6 * x->mode_count))
                return REFUSE("the shape at joint '%s' is not 6 finite numbers a mode", x->link,
                              joint->name);
            *handle = (int32_t)d->handles;
            d->handle[d->handles++] =
                (struct draft_handle){(uint32_t)flexible, j, x->shapes[k].shape};
            return TFA_OK;
        }
    return REFUSE("its modes have no shape at its child joint '%s'; give one, 0 if it "
                  "stands where the link is clamped",
                  x->link, joint->name);
}

/* Whether this is the handle of flexible link i at the joint of that name */
static int is_handle(const struct draft *d, const struct draft_handle *h, uint32_t i,
                     const char *name)
{
    return h->flexible == i && name && strcmp(d->description->joints[h->joint].name, name) == 0;
}

static int check_shapes(const struct draft *d, tfa_report *report)
{
    for (uint32_t i = 0; i < d->flexible_bodies; i++) {
        const struct draft_flexible *x = &d->flexible[i];
        for (size_t k = 0; k < x->modes->shape_count; k++) {
            const char *name = x->modes->shapes[k].joint;
            uint32_t handle = 0;
            while (handle < d->handles && !is_handle(d, &d->handle[handle], i, name))
                handle++;
            for (size_t j = 0; name && j < k; j++)
                if (x->modes->shapes[j].joint && strcmp(x->modes->shapes[j].joint, name) == 0)
                    return REFUSE("it has two shapes at joint '%s'; remove one", x->modes->link,
                                  name);
            if (handle == d->handles)
                return REFUSE("it has a shape at joint '%s', which is no child of "
                              "it in the scene; correct the name or remove it",
                              x->modes->link, name ? name : "(none)");
        }
    }
    return TFA_OK;
}

int tfa_draft_modes(struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    int status = check_links(d, report);
    for (size_t k = 0; k < s->link_count; k++)
        d->link[k].handle = -1;
    for (uint32_t i = 0; i < d->bodies; i++)
        d->body[i].flexible = d->body[i].handle = -1;
    for (size_t k = 0; status == TFA_OK && k < s->link_count; k++)
        status = add_flexible(d, k, report);
    for (size_t k = 0; status == TFA_OK && d->modes && k < s->joint_count; k++) {
        const uint32_t j = d->order[k];
        int32_t handle;
        if (d->joint[j].fate == TFA_FATE_ABSENT)
            continue;
        if (d->joint[j].fate == TFA_FATE_FOLLOWS)
            return REFUSE("it has modes, and joint '%s' follows another joint; leave it free",
                          d->flexible[0].modes->link, s->joints[j].name);
        status = find_handle(d, j, &handle, report);
        if (!draft_moves(d, j))
            d->link[s->joints[j].child].handle = handle;
        else if (handle >= 0)
            d->body[d->joint[j].body].handle = handle;
    }
    return status == TFA_OK ? check_shapes(d, report) : status;
}
