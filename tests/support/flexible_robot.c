/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "flexible_robot.h"

#include "models.h"
#include "test.h"

static const struct {
    const char *name;
    random_robot_options options;
} kinds[] = {
    /* shape, joints, all types, fixed joints, armature, shuffled */
    {"one joint", {RANDOM_CHAIN, 1, true, 0, 0, false}},
    {"arm of two links", {RANDOM_CHAIN, 2, false, 0.5, 0, false}},
    {"chain of 7", {RANDOM_CHAIN, 7, false, 0.4, 0.5, false}},
    {"mixed chain of 6", {RANDOM_CHAIN, 6, true, 0.4, 0.3, true}},
    {"star of 15", {RANDOM_STAR, 15, false, 0.3, 0.3, true}},
    {"tree of 12", {RANDOM_BRANCHING, 12, false, 0.5, 0, true}},
    {"mixed tree of 16", {RANDOM_BRANCHING, 16, true, 0.5, 0.3, true}},
};
#define KINDS (sizeof kinds / sizeof *kinds)

static double *numbers(random_source *s, size_t count, double reach)
{
    double *x = calloc(count + 1, sizeof *x);
    assert_non_null(x);
    for (size_t k = 0; k < count; k++)
        x[k] = random_uniform(s, -reach, reach);
    return x;
}

/* Momentum of a rigid motion (u, w) of the link, linear first, about its origin */
static void momentum(const tfa_description *d, uint32_t link, const double *twist, double *p)
{
    const double pose[7] = {0, 0, 0, 0, 0, 0, 1}, gravity[3] = {0};
    const tfa_request rest = {.base_pose = pose, .gravity = gravity};
    const tfa_description alone = {.name = "link", .links = &d->links[link], .link_count = 1};
    oracle *o = oracle_create(&alone, TFA_BASE_FLOATING);
    oracle_set_state(o, &rest, 0);
    oracle_inverse(o, NULL, twist, NULL, p);
    oracle_free(o);
}

/* With p_k = I xi_k of random rigid motions xi_k, M = xi^T I xi + a positive definite matrix. */
tfa_link_modes flexible_modes(random_source *s, const tfa_description *d, uint32_t link,
                              uint32_t count)
{
    const double mass = d->links[link].mass;
    const size_t n = count;
    double *xi = numbers(s, n * 6, 0.5), *p = numbers(s, n * 6, 0), *W = numbers(s, n * n, 0.5);
    double *M = numbers(s, n * n, 0), *K = numbers(s, n * n, 0), *D = numbers(s, n * n, 0);
    double *limit = numbers(s, n, 0);
    for (size_t k = 0; k < n; k++) {
        momentum(d, link, xi + 6 * k, p + 6 * k);
        limit[k] = 1;
    }
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            double own = i == j ? 0.1 : 0, rigid = 0;
            for (size_t k = 0; k < n; k++)
                own += W[i * n + k] * W[j * n + k];
            for (size_t e = 0; e < 6; e++)
                rigid += (xi[6 * i + e] * p[6 * j + e] + xi[6 * j + e] * p[6 * i + e]) / 2;
            M[i * n + j] = M[j * n + i] = rigid + mass * own;
            K[i * n + j] = K[j * n + i] = 1e3 * own;
            D[i * n + j] = D[j * n + i] = 3 * own;
        }
    tfa_mode_shape *shapes = calloc(d->joint_count + 1, sizeof *shapes);
    tfa_link_modes modes = {.link = d->links[link].name,
                            .mode_count = n,
                            .momentum = p,
                            .mass = M,
                            .stiffness = K,
                            .damping = D,
                            .limit = limit,
                            .shapes = shapes};
    for (size_t j = 0; j < d->joint_count; j++)
        if (d->joints[j].parent == link)
            shapes[modes.shape_count++] = (tfa_mode_shape){d->joints[j].name, numbers(s, n * 6, 3)};
    free(W);
    free(xi);
    return modes;
}

void flexible_modes_free(const tfa_link_modes *m)
{
    const void *all[] = {m->momentum, m->mass, m->stiffness, m->damping, m->limit};
    for (size_t k = 0; k < m->shape_count; k++)
        free((void *)(uintptr_t)m->shapes[k].shape);
    free((void *)(uintptr_t)m->shapes);
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        free((void *)(uintptr_t)all[k]);
}

/* To the oracle a payload on a link without mass is that link's mass. */
static void load_link(tfa_description *d, const tfa_payload *payload)
{
    for (size_t k = 0; k < d->link_count; k++)
        if (d->links[k].name == payload->link) {
            tfa_link *link = &d->links[k];
            *link = (tfa_link){.name = link->name, .mass = payload->mass, .quat = {0, 0, 0, 1}};
            memcpy(link->com, payload->com, sizeof link->com);
            memcpy(link->inertia, payload->inertia, sizeof link->inertia);
        }
}

/* A joint that the scene locks at 0 is fixed to the oracle. */
static void set_locked(const flexible_robot *f, const tfa_description *d, tfa_joint_type type)
{
    for (size_t j = 0; f->scene.lock_count && j < d->joint_count; j++)
        if (d->joints[j].name == f->lock.joint)
            d->joints[j].type = type;
}

void flexible_open(flexible_robot *f, tfa_description *d, tfa_link_modes *modes, size_t links,
                   bool with_oracle)
{
    test_robot *r = &f->robot;
    f->modes = modes;
    f->links = links;
    f->scene.modes = modes;
    f->scene.modes_count = links;
    f->scene.payloads = f->payload;
    f->scene.locks = &f->lock;
    const tfa_model_options options = {.base = r->base, .scene = &f->scene};
    r->random = true;
    r->description = d;
    set_locked(f, d, f->locked);
    r->model = compiled(d, &options);
    set_locked(f, d, TFA_JOINT_FIXED);
    r->f64 = fixture_workspace(r->model, TFA_F64);
    r->f128 = fixture_workspace(r->model, TFA_F128);
    for (size_t k = 0; k < f->scene.payload_count; k++)
        load_link(d, &f->payload[k]);
    f->scene.payload_count = f->scene.lock_count = 0;
    r->o = oracle_create(d, r->base);
    r->n = oracle_freedoms(r->o);
    r->nv = oracle_v_count(r->o);
    r->nq = oracle_q_count(r->o);
    f->mode_count = tfa_model_mode_count(r->model);
    f->n = r->n + f->mode_count;
    f->o = with_oracle ? oracle_modes_create(d, r->base, modes, links) : NULL;
    if (f->o)
        assert_int_equal(oracle_modes_freedoms(f->o), f->n);
}

void flexible_close(flexible_robot *f)
{
    oracle_modes_free(f->o);
    for (size_t k = 0; k < f->links; k++)
        flexible_modes_free(&f->modes[k]);
    free(f->modes);
    fixture_close(&f->robot);
}

void flexible_open_chain(flexible_robot *f, uint32_t links, uint64_t seed, bool with_oracle)
{
    random_source s = {seed};
    *f = (flexible_robot){.robot = {.seed = seed}};
    snprintf(f->robot.name, sizeof f->robot.name, "flexible chain of %u", (unsigned)links);
    tfa_description *d = chain_create(CHAIN_RANDOM, links, seed);
    tfa_link_modes *modes = calloc(links, sizeof *modes);
    for (uint32_t k = 0; k < links; k++)
        modes[k] = flexible_modes(&s, d, d->joints[k].child, 4);
    flexible_open(f, d, modes, links, with_oracle);
}

/* The link at which the body of this one begins */
static uint32_t body_of(const tfa_description *d, uint32_t link)
{
    for (size_t j = 0; j < d->joint_count; j++)
        if (d->joints[j].child == link && d->joints[j].type == TFA_JOINT_FIXED)
            return body_of(d, d->joints[j].parent);
    return link;
}

/* Two bodies of three get modes on one of their links, and the last one if there is none yet. */
static size_t random_flexible_links(random_source *s, const tfa_description *d, tfa_base base,
                                    tfa_link_modes *modes)
{
    const uint32_t n = (uint32_t)d->link_count, root = description_root(d);
    uint32_t last = UINT32_MAX;
    size_t links = 0;
    for (uint32_t body = 0; body < n; body++) {
        uint32_t chosen = UINT32_MAX, seen = 0;
        if (body_of(d, body) != body || (body == root && base == TFA_BASE_FIXED))
            continue;
        for (uint32_t k = 0; k < n; k++)
            if (body_of(d, k) == body && d->links[k].mass > 0 && random_below(s, ++seen) == 0)
                chosen = k;
        if (chosen == UINT32_MAX)
            continue;
        last = chosen;
        if (random_below(s, 3))
            modes[links++] = flexible_modes(s, d, chosen, 1 + random_below(s, 4));
    }
    if (links == 0)
        modes[links++] = flexible_modes(s, d, last, 3);
    return links;
}

/* Locks the last joint, if it has one freedom. */
static void random_lock(flexible_robot *f, tfa_description *d)
{
    tfa_joint *j = &d->joints[d->joint_count - 1];
    if (j->type == TFA_JOINT_FIXED || j->type >= TFA_JOINT_PLANAR)
        return;
    f->lock.joint = j->name;
    f->locked = j->type;
    f->scene.lock_count = 1;
    j->type = TFA_JOINT_FIXED;
}

/* Payloads on links that hang on a flexible link by a fixed joint, and have no mass */
static void random_payloads(random_source *s, flexible_robot *f, const tfa_description *d,
                            const tfa_link_modes *modes, size_t links)
{
    for (size_t j = 0; j < d->joint_count; j++)
        for (size_t k = 0; k < links; k++) {
            const tfa_link *link = &d->links[d->joints[j].child];
            if (strcmp(modes[k].link, d->links[d->joints[j].parent].name) != 0 || link->mass > 0 ||
                f->scene.payload_count == 2)
                continue;
            double x[TFA_PAYLOAD_NUMBERS];
            tfa_payload *payload = &f->payload[f->scene.payload_count++];
            random_payload(s, x);
            payload->link = link->name;
            payload->mass = x[0];
            memcpy(payload->com, x + 1, sizeof payload->com);
            memcpy(payload->inertia, x + 4, sizeof payload->inertia);
        }
}

void for_every_flexible_robot(void (*law)(flexible_robot *f))
{
    for (uint32_t kind = 0; kind < KINDS; kind++)
        for (uint64_t seed = 1; seed <= TEST_ROUNDS(test_extent(2, 8)); seed++)
            for (int floating = 0; floating < 2; floating++) {
                const tfa_base base = floating ? TFA_BASE_FLOATING : TFA_BASE_FIXED;
                flexible_robot f = {.robot = {.seed = seed, .base = base}};
                random_source s = {seed * 1000 + kind};
                snprintf(f.robot.name, sizeof f.robot.name, "flexible %s, seed %u, %s base",
                         kinds[kind].name, (unsigned)seed, floating ? "floating" : "fixed");
                tfa_description *d = random_robot_create(s.state, &kinds[kind].options);
                tfa_link_modes *modes = calloc(d->link_count, sizeof *modes);
                if (seed % 2 == 0)
                    random_robot_empty_links(&s, d, 0.3);
                if (seed % 2 == 0 && kind > 0)
                    random_lock(&f, d);
                const size_t links = random_flexible_links(&s, d, base, modes);
                random_payloads(&s, &f, d, modes, links);
                flexible_open(&f, d, modes, links, true);
                law(&f);
                flexible_close(&f);
            }
}

flexible_states flexible_states_make(const flexible_robot *f, uint64_t salt, uint32_t count,
                                     uint32_t wrenches)
{
    random_source s = {f->robot.seed + salt};
    return (flexible_states){fixture_states(&f->robot, salt, count, wrenches),
                             numbers(&s, (size_t)count * f->mode_count, FLEXIBLE_ETA),
                             numbers(&s, (size_t)count * f->mode_count, 1)};
}

void flexible_states_free(flexible_states *s)
{
    random_states_free(s->x);
    free(s->modes);
    free(s->rates);
}

tfa_request flexible_request(const flexible_robot *f, const flexible_states *s)
{
    tfa_request r = fixture_request(&f->robot, s->x);
    r.modes = s->modes;
    r.mode_velocities = s->rates;
    return r;
}

void flexible_forward(const flexible_robot *f, tfa_workspace *w, const tfa_request *r, double *x,
                      tfa_answer *answers)
{
    const size_t nv = f->robot.nv, six = f->robot.n - nv, modes = f->mode_count, count = r->count;
    double *base = calloc(count * 6, sizeof *base), *qdd = calloc(count * nv + 1, sizeof *qdd);
    double *eta = calloc(count * modes + 1, sizeof *eta);
    tfa_reply reply = {.base_acceleration = base, .qdd = qdd, .modes = eta, .answers = answers};
    compute_ok(&f->robot, w, r, &reply);
    for (size_t k = 0; k < count; k++) {
        memcpy(x + k * f->n, base + 6 * k, six * sizeof *x);
        memcpy(x + k * f->n + six, qdd + k * nv, nv * sizeof *x);
        memcpy(x + k * f->n + six + nv, eta + k * modes, modes * sizeof *x);
    }
    free(eta);
    free(qdd);
    free(base);
}
