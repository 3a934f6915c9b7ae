/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The load report for people.
 */
#include "model_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/totalforce.h>

/* Names on one line before it says "...". */
enum { NAMES_LISTED_MAX = 20 };

static void print_policies(const model_report *r)
{
    const tfa_model_options *o = &r->options->model;
    const tfa_scene *scene = o->scene;
    printf("  policies: mimic %s, inertia %s%s%s%s%s\n", tfa_word(TFA_WORDS_MIMIC, o->mimic),
           tfa_word(TFA_WORDS_INERTIA, o->inertia), o->rotor_inertia ? ", rotor inertia" : "",
           o->damping ? ", damping" : "", o->friction ? ", friction" : "",
           o->lock_massless_leaves ? ", massless leaves locked" : "");
    if (o->snap > 0)
        printf("  right angles within %g rad are exact\n", o->snap);
    if (!scene)
        return;
    printf("  scene: root %s, tips %zu, locks %zu, payloads %zu, flexible links %zu\n",
           scene->root ? scene->root : "as in the file", scene->tip_count, scene->lock_count,
           scene->payload_count, scene->modes_count);
}

static void print_counts(const model_report *r, const tfa_model_summary *s)
{
    static const char *const words[] = {"move", "fixed", "locked", "fused", "follow", "absent"};
    uint32_t fates[TFA_FATE_ABSENT + 1];
    model_count_fates(s, fates);
    printf("  links %" PRIu32 ", joints %" PRIu32 " -> bodies %" PRIu32 ", coordinates %" PRIu32
           ", freedoms %" PRIu32 "\n",
           s->links, s->joints, s->bodies, s->q_count,
           s->v_count + tfa_model_base_freedoms(r->model));
    printf("  joints:");
    for (int fate = 0; fate <= TFA_FATE_ABSENT; fate++)
        printf("%s %" PRIu32 " %s", fate ? "," : "", fates[fate], words[fate]);
    printf("\n  mass %.6g kg moving, %.6g kg in all\n", s->moving_mass, s->total_mass);
    printf("  centre of mass %.6g %.6g %.6g m (root link's frame, all joints at 0)\n", s->com[0],
           s->com[1], s->com[2]);
    printf("  gravity %g %g %g m/s^2\n", s->gravity[0], s->gravity[1], s->gravity[2]);
}

static void print_plan(const model_report *r, const tfa_model_summary *s)
{
    printf("  plan: main chain %" PRIu32 " of %" PRIu32 " bodies, depth %" PRIu32 "\n",
           s->main_chain, s->bodies, s->depth);
    long_branch branch;
    if (model_find_long_branch(r->model, &branch))
        printf("  plan: side branch of %" PRIu32
               " bodies from '%s' on, more than log2 of its chain's "
               "%" PRIu32 ": parallel methods take as long as it\n",
               branch.bodies, tfa_model_body_name(r->model, branch.body), branch.chain);
    if (s->singular_body >= 0)
        printf("  plan: tfa is refused, body '%s' has an inertia without inverse; auto avoids it\n",
               tfa_model_body_name(r->model, (uint32_t)s->singular_body));
    printf("  kernels %s, %s\n  hash %s\n", tfa_isa_name(), r->kernel,
           tfa_model_hash_text(r->model));
}

static void print_joints(const tfa_model *model)
{
    printf("  joints (order of q, v, tau, qdd)\n");
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++) {
        tfa_joint_info joint = tfa_model_joint(model, i);
        printf("    %3" PRIu32 "  %-10s %-24s moves %s", joint.v_index,
               tfa_joint_type_describe(joint.type).name, joint.name,
               tfa_model_body_name(model, joint.body));
        if (joint.armature > 0)
            printf("  armature %g", joint.armature);
        if (joint.damping != 0)
            printf("  damping %g", joint.damping);
        if (joint.friction != 0)
            printf("  friction %g", joint.friction);
        putchar('\n');
    }
}

static void print_modes(const tfa_model *model)
{
    if (tfa_model_mode_count(model))
        printf("  modes (order of modal coordinates; bound of each)\n");
    for (uint32_t i = 0; i < tfa_model_mode_count(model); i++) {
        const tfa_mode_info mode = tfa_model_mode(model, i);
        printf("    %3" PRIu32 "  %-24s mode %" PRIu32, i, mode.link, mode.index + 1);
        if (isfinite(mode.limit))
            printf("  up to %g", mode.limit);
        putchar('\n');
    }
}

static void print_constraints(const tfa_model *model)
{
    if (tfa_model_constraint_count(model))
        printf("  constraints (order of their bits; rows held; links)\n");
    for (uint32_t i = 0; i < tfa_model_constraint_count(model); i++) {
        const tfa_constraint_info c = tfa_model_constraint(model, i);
        const char *words[6];
        const size_t count = model_constraint_words(c.rows, words);
        printf("    %3" PRIu32 "  %-24s", i, c.name);
        for (size_t k = 0; k < count; k++)
            printf(" %s", words[k]);
        for (int side = 0; side < 2; side++) {
            const char *link = model_constraint_link(model, &c, side);
            printf("%s%s", side ? " - " : "  ", link ? link : "(world)");
        }
        puts(c.unilateral ? "  unilateral" : "");
    }
}

/* At the zero posture, which most files mean to be closed */
static void print_loops(const model_report *r)
{
    const model_loops *x = &r->loops;
    if (x->checked)
        printf("  loops with all joints at 0 (open by m, rad)\n");
    for (uint32_t i = 0; i < tfa_model_constraint_count(r->model); i++)
        if (x->checked >> i & 1)
            printf("    %3" PRIu32 "  %-24s %.3g %.3g%s\n", i,
                   tfa_model_constraint(r->model, i).name, x->error[i][0], x->error[i][1],
                   x->open >> i & 1 ? "  open" : "");
    if (!x->open)
        return;
    const char *joint = tfa_model_joint(r->model, x->joint).name;
    if (x->status == TFA_OK)
        printf("    close in %" PRIu32 " iterations from there; joint '%s' changes most, by %.3g\n",
               x->iterations, joint, x->change);
    else if (x->status == TFA_E_OPEN)
        printf("    stay open by %.3g at best; joint '%s' changes most, by %.3g\n", x->left, joint,
               x->change);
    else
        printf("    closing them: %s\n", tfa_status_text(x->status));
}

static void print_actuated(const tfa_model *model)
{
    if (!model_names_actuated(model))
        return;
    printf("  actuated:");
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++)
        if (tfa_model_joint(model, i).actuated)
            printf(" %s", tfa_model_joint(model, i).name);
    putchar('\n');
}

static void print_bodies(const model_report *r)
{
    printf("  bodies (mass kg, centre of mass m, radii of gyration m, condition of the inertia)\n");
    for (uint32_t i = 0; i < r->bodies; i++) {
        const tfa_body_info b = tfa_model_body(r->model, i);
        printf("    %3" PRIu32 "  %-24s %10.6g  at %.4g %.4g %.4g", i, b.name, b.mass, b.com[0],
               b.com[1], b.com[2]);
        if (b.mass > 0)
            printf("  gyration %.3g..%.3g", b.gyration_min, b.gyration_max);
        if (!isnan(b.condition))
            printf("  condition %.3g", b.condition);
        puts(b.regular ? "" : "  no inverse");
    }
}

static const char *body_of(const tfa_model *model, const tfa_declared_joint *joint)
{
    return joint->body < 0 ? "(world)" : tfa_model_body_name(model, (uint32_t)joint->body);
}

static void print_joint_of_fate(const tfa_model *model, const tfa_declared_joint *joint)
{
    if (joint->fate == TFA_FATE_FOLLOWS)
        printf("    %s = %.10g * %s %c %.10g\n", joint->name, joint->multiplier,
               joint->leader < 0 ? "?" : tfa_model_joint(model, (uint32_t)joint->leader).name,
               joint->offset < 0 ? '-' : '+', fabs(joint->offset));
    else
        printf("    %s: part of %s\n", joint->name, body_of(model, joint));
}

/* Fate of the joints without a line of their own among the moving ones */
static void print_fates(const tfa_model *model, const tfa_model_summary *s)
{
    static const struct {
        tfa_fate fate;
        const char *title;
    } sections[] = {{TFA_FATE_LOCKED, "locked (as if fixed)"},
                    {TFA_FATE_FUSED, "fused (several joints of one body)"},
                    {TFA_FATE_FOLLOWS, "following (position of the leader, rad or m)"}};
    uint32_t counts[TFA_FATE_ABSENT + 1];
    model_count_fates(s, counts);
    for (size_t k = 0; k < sizeof sections / sizeof sections[0]; k++) {
        if (!counts[sections[k].fate])
            continue;
        printf("  %s\n", sections[k].title);
        for (uint32_t i = 0; i < tfa_model_declared_count(model); i++) {
            tfa_declared_joint joint = tfa_model_declared(model, i);
            if (joint.fate == sections[k].fate)
                print_joint_of_fate(model, &joint);
        }
    }
}

static void print_absent(const tfa_model *model, const tfa_model_summary *s)
{
    uint32_t shown = 0;
    if (!s->absent)
        return;
    printf("  absent from the scene (%" PRIu32 ")\n   ", s->absent);
    for (uint32_t i = 0; i < tfa_model_declared_count(model) && shown <= NAMES_LISTED_MAX; i++) {
        tfa_declared_joint joint = tfa_model_declared(model, i);
        if (joint.fate == TFA_FATE_ABSENT)
            printf(" %s", shown++ < NAMES_LISTED_MAX ? joint.name : "...");
    }
    putchar('\n');
}

/* The links a body swallowed, on one line; nothing when it is a single link. */
static void print_merged(const model_report *r, uint32_t body, const char *name)
{
    int merged = 0;
    for (uint32_t i = r->first_link[body]; i < r->first_link[body + 1]; i++) {
        if (strcmp(r->link_names[i], name) == 0)
            continue;
        if (merged++ == 0)
            printf("    %s <-", name);
        printf(" %s", r->link_names[i]);
    }
    if (merged)
        putchar('\n');
}

static void print_selected(const model_report *r, const char *title, int (*selects)(const char *))
{
    int printed = 0;
    for (size_t i = 0; i < r->messages->count; i++) {
        if (!selects(r->messages->messages[i].code))
            continue;
        if (printed++ == 0)
            printf("  %s\n", title);
        printf("    %s\n", r->messages->messages[i].text);
    }
}

static void print_codes(const model_report *r)
{
    printf("  messages:%s", r->code_count ? "" : " none");
    for (size_t k = 0; k < r->code_count; k++)
        printf("%s %zu %s%s [%s]", k ? "," : "", r->codes[k].count,
               tfa_word(TFA_WORDS_SEVERITY, r->codes[k].severity),
               r->codes[k].count == 1 ? "" : "s", r->codes[k].code);
    putchar('\n');
}

int model_report_print_text(const model_report *r)
{
    const tfa_model_summary s = tfa_model_summarise(r->model);
    printf("%s: robot '%s', base %s\n", r->file, tfa_model_name(r->model),
           tfa_word(TFA_WORDS_BASE, s.base));
    print_policies(r);
    print_counts(r, &s);
    print_plan(r, &s);
    print_joints(r->model);
    print_actuated(r->model);
    print_modes(r->model);
    print_constraints(r->model);
    print_loops(r);
    print_bodies(r);
    printf("  merged (body <- links kept as frames)\n");
    print_merged(r, r->bodies, "(world)");
    for (uint32_t i = 0; i < r->bodies; i++)
        print_merged(r, i, tfa_model_body_name(r->model, i));
    print_fates(r->model, &s);
    print_absent(r->model, &s);
    print_selected(r, "ignored", model_code_is_ignored);
    print_selected(r, "repaired", model_code_is_repaired);
    print_codes(r);
    return ferror(stdout);
}
