/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random robots with random scenes. See reductions.h.
 */
#include "reductions.h"

#include "models.h"
#include "support/fixture.h"
#include "test.h"

static bool chance(random_source *s, double probability)
{
    return random_uniform(s, 0, 1) < probability;
}

static void *must(void *memory)
{
    assert_non_null(memory);
    return memory;
}

/* ---- the robot, and what the root of the scene leaves of it ---- */

/* hangs[k]: link k is `root` or hangs from it. */
static void mark_below(const tfa_description *d, uint32_t root, bool *is_attached)
{
    for (size_t k = 0; k < d->link_count; k++)
        is_attached[k] = k == root;
    for (size_t pass = 0; pass < d->joint_count; pass++)
        for (size_t j = 0; j < d->joint_count; j++)
            is_attached[d->joints[j].child] |= is_attached[d->joints[j].parent];
}

/* A link of the robot from which two joints or more hang; UINT32_MAX: none was met. */
static uint32_t choose_root(random_source *s, const tfa_description *d, bool massive)
{
    bool *is_attached = must(calloc(d->link_count, sizeof *is_attached));
    uint32_t found = UINT32_MAX;
    for (int attempt = 0; attempt < 20 && found == UINT32_MAX; attempt++) {
        uint32_t link = random_below(s, (uint32_t)d->link_count), moving = 0;
        mark_below(d, link, is_attached);
        for (size_t j = 0; j < d->joint_count; j++)
            moving += is_attached[d->joints[j].parent] && d->joints[j].type != TFA_JOINT_FIXED;
        if (moving >= 2 && !(massive && d->links[link].mass == 0))
            found = link;
    }
    free(is_attached);
    return found;
}

/* A copy of the links that `hang`, with their joints; mimics that leave the copy are cut in
 * both. */
static tfa_description *copy_below(tfa_description *d, uint32_t root)
{
    bool *is_attached = must(calloc(d->link_count, sizeof *is_attached));
    uint32_t *link = must(calloc(d->link_count, sizeof *link));
    int32_t *joint = must(calloc(d->joint_count + 1, sizeof *joint));
    tfa_description *c = must(calloc(1, sizeof *c));
    mark_below(d, root, is_attached);
    c->name = d->name;
    c->links = must(calloc(d->link_count, sizeof *c->links));
    c->joints = must(calloc(d->joint_count + 1, sizeof *c->joints));
    for (size_t k = 0; k < d->link_count; k++) {
        link[k] = (uint32_t)c->link_count;
        if (is_attached[k])
            c->links[c->link_count++] = d->links[k];
    }
    for (size_t j = 0; j < d->joint_count; j++) {
        joint[j] = is_attached[d->joints[j].parent] ? (int32_t)c->joint_count : -1;
        if (joint[j] >= 0)
            c->joints[c->joint_count++] = d->joints[j];
    }
    for (size_t j = 0; j < d->joint_count; j++) {
        int32_t leader = d->joints[j].mimic;
        if (leader >= 0 && (joint[j] < 0) != (joint[leader] < 0))
            d->joints[j].mimic = leader = -1;
        if (joint[j] >= 0)
            c->joints[joint[j]].mimic = leader < 0 ? -1 : joint[leader];
    }
    for (size_t j = 0; j < c->joint_count; j++) {
        c->joints[j].parent = link[c->joints[j].parent];
        c->joints[j].child = link[c->joints[j].child];
    }
    free(joint);
    free(link);
    free(is_attached);
    return c;
}

static void make_robot(reduction *r, random_source *s)
{
    const random_robot_options options = {.shape = (random_shape)random_below(s, 3),
                                          .joints = 3 + random_below(s, 7),
                                          .all_types = chance(s, 0.5),
                                          .fixed_fraction = r->kinds & REDUCE_FIXED ? 0.5 : 0,
                                          .armature_chance = 0.6,
                                          .shuffled = chance(s, 0.5)};
    r->file = must(random_robot_create(random_bits(s), &options));
    random_source rubbing = {r->seed};
    for (size_t j = 0; j < r->file->joint_count; j++) {
        r->file->joints[j].damping = random_uniform(s, 0, 1);
        r->file->joints[j].friction = random_uniform(&rubbing, 0, 2);
    }
    if (r->kinds & REDUCE_MASSLESS)
        random_robot_empty_links(s, r->file, 0.5);
    if (r->kinds & REDUCE_MIMICS)
        random_robot_add_mimics(s, r->file, 0.4);
    uint32_t root = UINT32_MAX;
    if (r->kinds & REDUCE_ROOT)
        root = choose_root(s, r->file, r->base == TFA_BASE_FLOATING);
    if (root != UINT32_MAX)
        r->scene.root = r->file->links[root].name;
    else
        root = description_root(r->file);
    r->whole = copy_below(r->file, root);
    for (size_t j = 0; r->options.rotor_inertia && j < r->whole->joint_count; j++)
        r->whole->joints[j].armature += r->whole->joints[j].rotor;
}

/* ---- what should become of the joints ---- */

static void place_joints(reduction *r)
{
    static const uint32_t widths[] = {0, 1, 1, 1, 3, 7}, freedoms[] = {0, 1, 1, 1, 3, 6};
    r->joint = must(calloc(r->whole->joint_count + 1, sizeof *r->joint));
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const tfa_joint *j = &r->whole->joints[k];
        r->joint[k].q_count = widths[j->type];
        r->joint[k].v_count = freedoms[j->type];
        r->joint[k].leader = r->joint[k].index = -1;
        r->joint[k].multiplier = 1;
    }
    for (uint32_t v = 0, q = 0, within; v < r->whole_nv; v++) {
        reduced_joint *j = &r->joint[oracle_joint_of_freedom(r->o, v, &within)];
        if (within > 0)
            continue;
        j->q = q;
        j->v = v;
        q += j->q_count;
    }
}

/* Follows the chain of mimics to the joint that follows none. */
static void resolve(reduction *r, size_t k)
{
    reduced_joint *f = &r->joint[k];
    for (int32_t up = (int32_t)k; r->whole->joints[up].mimic >= 0; up = f->leader) {
        const tfa_joint *j = &r->whole->joints[up];
        f->offset += f->multiplier * j->offset;
        f->multiplier *= j->multiplier;
        f->leader = j->mimic;
    }
}

static void choose_locks(reduction *r, random_source *s)
{
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        const tfa_joint *j = &r->whole->joints[k];
        const bool follows = j->mimic >= 0 && r->options.mimic != TFA_MIMIC_FREE;
        if (j->type == TFA_JOINT_FIXED || follows || r->scene.lock_count == REDUCTION_LOCKS ||
            !chance(s, 0.35))
            continue;
        tfa_lock *lock = &r->locks[r->scene.lock_count++];
        lock->joint = j->name;
        random_coordinates(s, j->type, lock->q);
        r->joint[k].locked = true;
        memcpy(r->joint[k].at, lock->q, sizeof lock->q);
    }
}

/* Mimics that do not follow: their leader is locked, or the policy locks them where they stand with
 * their leader at 0. */
static void settle_mimics(reduction *r)
{
    if (r->options.mimic == TFA_MIMIC_FREE)
        return;
    for (size_t k = 0; k < r->whole->joint_count; k++) {
        if (r->whole->joints[k].mimic < 0)
            continue;
        resolve(r, k);
        reduced_joint *f = &r->joint[k];
        const reduced_joint *leader = &r->joint[f->leader];
        f->locked = leader->locked || r->options.mimic == TFA_MIMIC_LOCK;
        f->at[0] = f->offset + (leader->locked ? f->multiplier * leader->at[0] : 0);
        r->coupled |= !f->locked;
    }
}

static bool moves(const reduction *r, size_t k)
{
    return r->whole->joints[k].type != TFA_JOINT_FIXED && !r->joint[k].locked &&
           !r->joint[k].absent;
}

/* The joint that starts the tree of a link: the uppermost one that moves; -1: fixed to the root. */
static int32_t tree_of(const reduction *r, uint32_t link)
{
    int32_t tree = -1;
    for (size_t pass = 0; pass <= r->whole->joint_count; pass++)
        for (size_t j = 0; j < r->whole->joint_count; j++)
            if (r->whole->joints[j].child == link) {
                tree = moves(r, j) ? (int32_t)j : tree;
                link = r->whole->joints[j].parent;
                break;
            }
    return tree;
}

/* Trees without a tip are absent, unless something couples them to one that has: marks spread from
 * the tips' trees until nothing changes. */
static void leave_out_trees(reduction *r, random_source *s)
{
    const size_t joints = r->whole->joint_count, links = r->whole->link_count;
    int32_t *tree = must(calloc(joints + 1, sizeof *tree));
    bool *kept = must(calloc(joints + 1, sizeof *kept));
    for (size_t j = 0; j < joints; j++)
        tree[j] = tree_of(r, r->whole->joints[j].child);
    r->scene.tips = r->tips;
    r->scene.tip_count = 1 + random_below(s, 2);
    for (size_t t = 0; t < r->scene.tip_count; t++) {
        uint32_t link = random_below(s, (uint32_t)links);
        r->tips[t] = r->whole->links[link].name;
        if (tree_of(r, link) >= 0)
            kept[tree_of(r, link)] = true;
    }
    for (size_t pass = 0; pass < joints; pass++)
        for (size_t j = 0; j < joints; j++) {
            const reduced_joint *f = &r->joint[j];
            if (f->leader < 0 || f->locked)
                continue;
            bool *ends[2] = {&kept[tree[j]], &kept[tree[f->leader]]};
            *ends[0] = *ends[1] = *ends[0] || *ends[1];
        }
    for (size_t j = 0; j < joints && r->base == TFA_BASE_FIXED; j++)
        r->joint[j].absent = tree[j] >= 0 && !kept[tree[j]];
    free(kept);
    free(tree);
}

static bool is_absent(const reduction *r, uint32_t link)
{
    for (size_t j = 0; j < r->whole->joint_count; j++)
        if (r->whole->joints[j].child == link)
            return r->joint[j].absent;
    return false;
}

/* Public joints in the order of the whole robot, and what every freedom is tied to. */
static void number_joints(reduction *r)
{
    const uint32_t base = r->base == TFA_BASE_FLOATING ? 6 : 0;
    uint32_t *first = must(calloc(r->whole->joint_count + 1, sizeof *first)); /* row */
    uint32_t own = 0, row = base, within;
    for (uint32_t v = 0; v < r->whole_nv; v++) {
        uint32_t k = oracle_joint_of_freedom(r->o, v, &within);
        if (within > 0 || !moves(r, k) || r->joint[k].leader >= 0)
            continue;
        r->joint[k].index = (int32_t)own++;
        first[k] = row;
        row += r->joint[k].v_count;
        r->nq += r->joint[k].q_count;
    }
    r->n = row;
    r->nv = row - base;
    r->tie = must(calloc(base + r->whole_nv + 1, sizeof *r->tie));
    for (uint32_t k = 0; k < base; k++)
        r->tie[k] = (oracle_tie){k, 1};
    for (uint32_t v = 0; v < r->whole_nv; v++) {
        uint32_t k = oracle_joint_of_freedom(r->o, v, &within);
        const reduced_joint *j = &r->joint[k];
        uint32_t leader = j->leader >= 0 ? (uint32_t)j->leader : k;
        r->tie[base + v] = moves(r, k) ? (oracle_tie){first[leader] + within, j->multiplier}
                                       : (oracle_tie){ORACLE_STILL, 0};
    }
    free(first);
}

/* ---- payloads, model ---- */

static void choose_payloads(reduction *r, random_source *s)
{
    r->payload_count = 1 + random_below(s, REDUCTION_PAYLOADS);
    for (uint32_t k = 0; k < r->payload_count; k++) {
        double *x = r->payloads + k * TFA_PAYLOAD_NUMBERS;
        uint32_t link;
        do /* of an absent link it would be left out */
            link = random_below(s, (uint32_t)r->whole->link_count);
        while (is_absent(r, link));
        random_payload(s, x);
        r->payload_links[k] = link;
        tfa_payload *p = &r->scene_payloads[k];
        p->link = r->whole->links[link].name;
        p->mass = x[0];
        memcpy(p->com, x + 1, sizeof p->com);
        memcpy(p->inertia, x + 4, sizeof p->inertia);
    }
}

static void check_status(const reduction *r, int status, const tfa_report *report)
{
    if (status == TFA_OK)
        return;
    for (size_t k = 0; k < report->count; k++) {
        char text[300];
        tfa_report_format(report, k, text, sizeof text);
        print_message("%s\n", text);
    }
    fail_msg("%s: %s", r->name, tfa_status_text(status));
}

static void open_workspaces(reduction *r)
{
    r->f64 = fixture_workspace(r->model, TFA_F64);
    r->f128 = fixture_workspace(r->model, TFA_F128);
    r->mixed = fixture_mixed(r->model, TFA_F32, TFA_RESIDUAL_F64);
}

/* The payloads and the gravity come with the model itself or with one that is derived from it. */
static void make_model(reduction *r, bool derived)
{
    tfa_report report = {0};
    r->options.scene = &r->scene;
    r->scene.locks = r->locks;
    if (!derived) {
        r->options.gravity = r->gravity;
        r->scene.payloads = r->scene_payloads;
        r->scene.payload_count = r->payload_count;
    }
    int status = tfa_model_create(r->file, &r->options, &report, &r->model);
    check_status(r, status, &report);
    if (derived) {
        r->undivided = r->model;
        r->model = NULL;
        status = tfa_model_derive(r->undivided, r->gravity, r->scene_payloads, r->payload_count,
                                  &report, &r->model);
        check_status(r, status, &report);
    }
    tfa_report_free(&report);
    open_workspaces(r);
}

/* A payload that is added later must find a body that has mass: a fused one has none inside. */
static bool can_be_derived(const reduction *r)
{
    return !(r->kinds & REDUCE_MASSLESS);
}

double reduction_friction_velocity(const tfa_model_options *options)
{
    const double v = options->friction_velocity;
    return !options->friction ? 0 : v > 0 ? v : TFA_FRICTION_VELOCITY;
}

static void open_oracle(reduction *r)
{
    r->o = must(oracle_create(r->whole, r->base));
    oracle_use_damping(r->o, r->options.damping);
    oracle_use_friction(r->o, reduction_friction_velocity(&r->options));
    r->whole_nq = oracle_q_count(r->o);
    r->whole_nv = oracle_v_count(r->o);
    place_joints(r);
}

void reduction_open(reduction *r, uint64_t seed, uint32_t kinds, tfa_base base)
{
    random_source s = {seed * 0x51ed2701u + kinds};
    memset(r, 0, sizeof *r);
    r->seed = seed;
    r->base = base;
    r->kinds = kinds == REDUCE_ANYTHING ? 1 + random_below(&s, 127) : kinds;
    if (base == TFA_BASE_FLOATING)
        r->kinds &= ~(uint32_t)REDUCE_TIPS;
    snprintf(r->name, sizeof r->name, "seed %u, kinds %u, %s base", (unsigned)seed,
             (unsigned)r->kinds, base == TFA_BASE_FLOATING ? "floating" : "fixed");
    r->options.base = base;
    r->options.rotor_inertia = chance(&s, 0.5);
    r->options.damping = chance(&s, 0.5);
    r->options.friction = seed % 2;
    r->options.friction_velocity = seed % 4 == 1 ? 0.3 : 0;
    const tfa_mimic_policy policies[4] = {TFA_MIMIC_PROJECT, TFA_MIMIC_PROJECT, TFA_MIMIC_LOCK,
                                          TFA_MIMIC_FREE};
    r->options.mimic = policies[random_below(&s, 4)];
    for (int i = 0; i < 3; i++)
        r->gravity[i] = random_uniform(&s, -10, 10);
    make_robot(r, &s);
    open_oracle(r);
    if (r->kinds & REDUCE_LOCKED)
        choose_locks(r, &s);
    settle_mimics(r);
    if (r->kinds & REDUCE_TIPS)
        leave_out_trees(r, &s);
    number_joints(r);
    if (r->kinds & REDUCE_PAYLOADS)
        choose_payloads(r, &s);
    make_model(r, can_be_derived(r) && chance(&s, 0.5));
}

/* What the library locked because no mass moves with it stands at 0. */
static void mark_locked_leaves(reduction *r)
{
    for (uint32_t k = 0; k < tfa_model_declared_count(r->model); k++) {
        const tfa_declared_joint d = tfa_model_declared(r->model, k);
        for (size_t j = 0; d.fate == TFA_FATE_LOCKED && j < r->whole->joint_count; j++)
            if (strcmp(r->whole->joints[j].name, d.name) == 0)
                r->joint[j].locked = true;
    }
}

bool reduction_open_robot(reduction *r, const char *name, tfa_description *d,
                          const tfa_model_options *options)
{
    *r = (reduction){.as_it_is = true,
                     .base = options->base,
                     .file = d,
                     .options = *options,
                     .gravity = {1, -2, -9}};
    snprintf(r->name, sizeof r->name, "%s", name);
    if (tfa_model_create(d, options, NULL, &r->model) != TFA_OK)
        return false;
    r->whole = copy_below(d, description_root(d));
    open_oracle(r);
    settle_mimics(r);
    mark_locked_leaves(r);
    number_joints(r);
    assert_int_equal(tfa_model_v_count(r->model), r->nv);
    open_workspaces(r);
    return true;
}

void reduction_close(reduction *r)
{
    tfa_workspace_free(r->mixed);
    tfa_workspace_free(r->f128);
    tfa_workspace_free(r->f64);
    tfa_model_free(r->model);
    tfa_model_free(r->undivided);
    oracle_free(r->o);
    free(r->tie);
    free(r->joint);
    free(r->whole->joints);
    free(r->whole->links);
    free(r->whole);
    if (!r->as_it_is)
        random_robot_free(r->file);
}

tfa_model *reduction_compile(const reduction *r, const tfa_description *d,
                             const tfa_model_options *options)
{
    tfa_model *model = NULL;
    const int status = tfa_model_create(d, options, NULL, &model);
    if (status != TFA_OK)
        fail_msg("%s: %s", r->name, tfa_status_text(status));
    return model;
}

void reduction_for_seeds(uint64_t first, uint64_t last, void (*law)(reduction *r, uint64_t seed))
{
    for (uint64_t seed = first; seed <= last; seed++)
        for (int base = 0; base < 2; base++) {
            reduction r;
            reduction_open(&r, seed, REDUCE_ANYTHING, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
            if (r.n > 0)
                law(&r, seed);
            reduction_close(&r);
        }
}

/* Whether the table says that the method refuses what this status can stand for. Followers without
 * mass are only in robots that are taken as they are. */
static bool may_refuse(const reduction *r, const tfa_method_info *row, int status, tfa_field field)
{
    const unsigned massless = r->as_it_is ? TFA_REFUSES_MASSLESS_FOLLOWER : 0;
    const unsigned method = TFA_REFUSES_ARMATURE | TFA_REFUSES_MIMICS | massless;
    return (status == TFA_E_NOT_COMPUTED && field == TFA_FIELD_BODY && row->refuses & massless) ||
           (status == TFA_E_METHOD && field == TFA_FIELD_METHOD && row->refuses & method) ||
           (status == TFA_E_METHOD && field == TFA_FIELD_TIPS && row->refuses & TFA_REFUSES_TIPS) ||
           (status == TFA_E_SINGULAR && field == TFA_FIELD_BODY &&
            row->refuses & TFA_REFUSES_NO_INVERSE) ||
           (status == TFA_E_UNSUPPORTED && row->refuses & (TFA_REFUSES_LENGTH | TFA_REFUSES_SIZE));
}

bool reduction_ask(const reduction *r, tfa_workspace *w, const tfa_request *q, tfa_reply *reply)
{
    const int status = tfa_compute(w, q, reply);
    if (status != TFA_OK && !may_refuse(r, tfa_method_describe(q->method), status, reply->field))
        fail_msg("%s: op %d, method %s: %s (%s %u)", r->name, (int)q->op,
                 tfa_method_name((uint32_t)q->method), tfa_status_text(status),
                 tfa_field_name(reply->field), (unsigned)reply->index);
    return status == TFA_OK;
}
