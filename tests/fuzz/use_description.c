/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Compiles a robot with random policies and a random scene, derives from it, and asks about it.
 */
#include "invariants.h"
#include "use.h"

#include <math.h>
#include <string.h>

enum { MOST = 4 };

/* Everything that the options point to. */
struct setup {
    tfa_model_options options;
    tfa_scene scene;
    double gravity[3];
    const char *tips[MOST];
    tfa_lock locks[MOST];
    tfa_payload payloads[MOST];
};

static const char *any_link(const tfa_description *d, struct random_source *c)
{
    return random_percent(c, 3) ? "nobody" : d->links[random_below(c, d->link_count)].name;
}

static const char *any_joint(const tfa_description *d, struct random_source *c)
{
    if (random_percent(c, 3) || d->joint_count == 0)
        return "nobody";
    return d->joints[random_below(c, d->joint_count)].name;
}

/* Mostly what a user would write. */
static double any_number(struct random_source *c)
{
    static const double odd[] = {0, -0.0, NAN, INFINITY, 1e308, -1e308, 1e-308, 5e-324, 1e16, -1};
    if (random_percent(c, 2))
        return odd[random_below(c, sizeof odd / sizeof *odd)];
    return 3 * random_signed(c);
}

static void choose_lock(tfa_lock *lock, const tfa_description *d, struct random_source *c)
{
    lock->joint = any_joint(d, c);
    for (int i = 0; i < 7; i++)
        lock->q[i] = any_number(c);
    double norm = sqrt(lock->q[3] * lock->q[3] + lock->q[4] * lock->q[4] + lock->q[5] * lock->q[5] +
                       lock->q[6] * lock->q[6]);
    for (int i = 3; i < 7 && norm > 0; i++)
        lock->q[i] /= norm;
}

static void choose_payload(tfa_payload *load, const tfa_description *d, struct random_source *c)
{
    *load = (tfa_payload){.link = any_link(d, c), .mass = fabs(any_number(c))};
    for (int i = 0; i < 3; i++)
        load->com[i] = any_number(c);
    double x = fabs(any_number(c)), z = fabs(any_number(c));
    load->inertia[0] = x;
    load->inertia[3] = random_percent(c, 90) ? x + z : any_number(c);
    load->inertia[5] = z;
}

static void choose_scene(struct setup *s, const tfa_description *d, struct random_source *c)
{
    tfa_scene *scene = &s->scene;
    if (random_percent(c, 20))
        scene->root = any_link(d, c);
    scene->tips = s->tips;
    scene->locks = s->locks;
    scene->payloads = s->payloads;
    scene->tip_count = random_percent(c, 25) ? 1 + random_below(c, MOST) : 0;
    scene->lock_count = random_percent(c, 40) ? 1 + random_below(c, MOST) : 0;
    scene->payload_count = random_percent(c, 30) ? 1 + random_below(c, MOST) : 0;
    for (size_t i = 0; i < scene->tip_count; i++)
        s->tips[i] = any_link(d, c);
    for (size_t i = 0; i < scene->lock_count; i++)
        choose_lock(&s->locks[i], d, c);
    for (size_t i = 0; i < scene->payload_count; i++)
        choose_payload(&s->payloads[i], d, c);
    s->options.scene = scene;
}

static void choose(struct setup *s, const tfa_description *d, struct random_source *c)
{
    memset(s, 0, sizeof *s);
    tfa_model_options *o = &s->options;
    o->base = random_percent(c, 2) ? (tfa_base)7 : (tfa_base)random_below(c, 2);
    if (random_percent(c, 30)) {
        for (int i = 0; i < 3; i++)
            s->gravity[i] = 5 * any_number(c);
        o->gravity = s->gravity;
    }
    o->rotor_inertia = (uint32_t)random_below(c, 2);
    o->damping = (uint32_t)random_below(c, 2);
    o->lock_massless_leaves = random_percent(c, 70);
    o->inertia = (tfa_inertia_policy)random_below(c, 4);
    o->mimic = (tfa_mimic_policy)random_below(c, 3);
    if (random_percent(c, 60))
        choose_scene(s, d, c);
}

/* Reads all that there is to read. */
static void ask(const tfa_model *m)
{
    const tfa_model_summary s = tfa_model_summarise(m);
    REQUIRE(strlen(tfa_model_hash_text(m)) == 64);
    REQUIRE(isfinite(s.total_mass) && isfinite(s.moving_mass));
    REQUIRE(s.v_count == tfa_model_v_count(m) && s.q_count == tfa_model_q_count(m));
    for (uint32_t j = 0; j < tfa_model_joint_count(m); j++) {
        const tfa_joint_info joint = tfa_model_joint(m, j);
        REQUIRE(joint.q_index + joint.q_count <= s.q_count);
        REQUIRE(joint.v_index + joint.v_count <= s.v_count);
        REQUIRE(tfa_model_find_joint(m, joint.name) == (int32_t)j);
    }
    for (uint32_t f = 0; f < tfa_model_frame_count(m); f++) {
        const tfa_frame_info frame = tfa_model_frame(m, f);
        REQUIRE(frame.body >= -1 && frame.body < (int32_t)s.bodies);
        REQUIRE(tfa_model_find_frame(m, frame.name) == (int32_t)f);
    }
    for (uint32_t k = 0; k < tfa_model_declared_count(m); k++) {
        const tfa_declared_joint joint = tfa_model_declared(m, k);
        REQUIRE(joint.name && joint.body >= -1 && joint.body < (int32_t)s.bodies);
        REQUIRE(joint.joint >= -1 && joint.joint < (int32_t)tfa_model_joint_count(m));
    }
    for (uint32_t i = 0; i < s.bodies; i++)
        REQUIRE(tfa_model_body(m, i).parent < (int32_t)i && tfa_model_body_name(m, i));
}

/* Another gravity, another payload: refused with a reason, or as good as any model. */
static void derive(const tfa_model *m, const tfa_description *d, struct random_source *c)
{
    struct setup s;
    choose(&s, d, c);
    tfa_report report = {0};
    tfa_model *derived = NULL;
    int status = tfa_model_derive(m, s.options.gravity, s.payloads, s.scene.payload_count, &report,
                                  &derived);
    REQUIRE((derived != NULL) == (status == TFA_OK));
    check_report(&report, report.errors > 0 ? TFA_E_MODEL : TFA_OK);
    if (derived) {
        ask(derived);
        use_model(derived, c);
    }
    tfa_model_free(derived);
    tfa_report_free(&report);
}

/* The size tells whether the description compiles, and the second time gives the same model. */
static void compile_again(const tfa_description *d, const struct setup *s, const tfa_model *model,
                          int status)
{
    bool bad_options = status == TFA_E_ARGUMENT || status == TFA_E_VALUE;
    REQUIRE(bad_options || (tfa_model_size(d, &s->options) > 0) == (model != NULL));
    tfa_model *again = NULL;
    REQUIRE(tfa_model_create(d, &s->options, NULL, &again) == status);
    REQUIRE(!model || memcmp(tfa_model_hash(model), tfa_model_hash(again), 32) == 0);
    tfa_model_free(again);
}

void use_description(const tfa_description *description, struct random_source *c)
{
    struct setup s;
    choose(&s, description, c);
    tfa_report report = {0};
    tfa_model *model = NULL;
    int status = tfa_model_create(description, &s.options, &report, &model);
    REQUIRE((model != NULL) == (status == TFA_OK));
    REQUIRE(status != TFA_OK || report.errors == 0);
    REQUIRE((status != TFA_E_MODEL && status != TFA_E_NO_MASS) || report.errors > 0);
    check_report(&report, report.errors > 0 ? status : TFA_OK);
    if (random_percent(c, 10))
        compile_again(description, &s, model, status);
    if (model) {
        ask(model);
        use_model(model, c);
        if (random_percent(c, 30))
            derive(model, description, c);
    }
    tfa_model_free(model);
    tfa_report_free(&report);
}
