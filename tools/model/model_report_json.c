/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The load report as JSON. Keys are added, never renamed.
 */
#include "model_report.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <totalforce/totalforce.h>

/* Strings of a URDF may hold any bytes: bytes that are not UTF-8 are shown escaped. */
static json_t *text_of(const char *text)
{
    json_t *string = json_string(text);
    return string ? string : json_string("(not UTF-8)");
}

/* null for infinite or unknown numbers */
static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *vector(const double *v)
{
    return json_pack("[o,o,o]", number(v[0]), number(v[1]), number(v[2]));
}

static json_t *message(tfa_severity severity, uint32_t line, const char *code, uint32_t count,
                       const char *text)
{
    return json_pack("{ss si ss si so}", "severity", tfa_word(TFA_WORDS_SEVERITY, severity), "line",
                     (int)line, "code", code, "count", (int)count, "text", text_of(text));
}

/* Those of the check of loops, behind the others */
static void add_loops(const model_report *r, json_t *list)
{
    char text[1024];
    for (uint32_t k = 0; k < TFA_MAX_CONSTRAINTS; k++)
        if (r->loops.open >> k & 1) {
            (void)model_loops_text(r->model, &r->loops, k, text, sizeof text);
            json_array_append_new(list, message(TFA_WARNING, 0, MODEL_LOOP_CODE, 1, text));
        }
}

static json_t *messages(const model_report *r)
{
    json_t *list = json_array();
    for (size_t i = 0; i < r->messages->count; i++) {
        const tfa_message *m = &r->messages->messages[i];
        json_array_append_new(list, message(m->severity, m->line, m->code, m->count, m->text));
    }
    add_loops(r, list);
    return list;
}

static json_t *codes(const model_report *r)
{
    json_t *list = json_array();
    for (size_t k = 0; k < r->code_count; k++)
        json_array_append_new(list, json_pack("{ss ss sI}", "code", r->codes[k].code, "severity",
                                              tfa_word(TFA_WORDS_SEVERITY, r->codes[k].severity),
                                              "count", (json_int_t)r->codes[k].count));
    if (r->loops.open)
        json_array_append_new(list, json_pack("{ss ss si}", "code", MODEL_LOOP_CODE, "severity",
                                              tfa_word(TFA_WORDS_SEVERITY, TFA_WARNING), "count",
                                              __builtin_popcount(r->loops.open)));
    return list;
}

static json_t *selected(const model_report *r, int (*selects)(const char *))
{
    json_t *list = json_array();
    for (size_t i = 0; i < r->messages->count; i++) {
        const tfa_message *m = &r->messages->messages[i];
        if (selects(m->code))
            json_array_append_new(list, json_pack("{so si si so}", "name", text_of(m->entity),
                                                  "count", (int)m->count, "line", (int)m->line,
                                                  "text", text_of(m->text)));
    }
    return list;
}

static json_t *links(const model_report *r, uint32_t body)
{
    json_t *list = json_array();
    for (uint32_t i = r->first_link[body]; i < r->first_link[body + 1]; i++)
        json_array_append_new(list, text_of(r->link_names[i]));
    return list;
}

static json_t *body_name(const tfa_model *model, int32_t body)
{
    return body < 0 ? json_null() : text_of(tfa_model_body_name(model, (uint32_t)body));
}

static json_t *bodies(const model_report *r)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < r->bodies; i++) {
        const tfa_body_info b = tfa_model_body(r->model, i);
        json_array_append_new(
            list, json_pack("{so si so so si so so so so so sb}", "name", text_of(b.name), "index",
                            (int)i, "parent", body_name(r->model, b.parent), "links", links(r, i),
                            "freedoms", (int)b.freedoms, "mass", number(b.mass), "centre_of_mass",
                            vector(b.com), "gyration_min", number(b.gyration_min), "gyration_max",
                            number(b.gyration_max), "condition", number(b.condition), "regular",
                            (int)b.regular));
    }
    return list;
}

static void add_joints(json_t *root, const tfa_model *model)
{
    json_t *names = json_array(), *details = json_array();
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++) {
        tfa_joint_info joint = tfa_model_joint(model, i);
        json_array_append_new(names, text_of(joint.name));
        json_array_append_new(
            details,
            json_pack("{so ss si si si si si sf sf sf}", "name", text_of(joint.name), "type",
                      tfa_joint_type_describe(joint.type).name, "q_index", (int)joint.q_index,
                      "q_count", (int)joint.q_count, "v_index", (int)joint.v_index, "v_count",
                      (int)joint.v_count, "body", (int)joint.body, "armature", joint.armature,
                      "damping", joint.damping, "friction", joint.friction));
    }
    json_object_set_new(root, "joints", names);
    json_object_set_new(root, "joint_details", details);
}

static json_t *modes(const tfa_model *model)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < tfa_model_mode_count(model); i++) {
        const tfa_mode_info mode = tfa_model_mode(model, i);
        json_array_append_new(list, json_pack("{so si so}", "link", text_of(mode.link), "index",
                                              (int)mode.index, "limit", number(mode.limit)));
    }
    return list;
}

/* null: a contact, which is no loop */
static json_t *open_by(const model_loops *loops, uint32_t index)
{
    return loops->checked >> index & 1 ? json_pack("{sf sf}", "position", loops->error[index][0],
                                                   "rotation", loops->error[index][1])
                                       : json_null();
}

/* null: no loop is open where all joints are at 0 */
static json_t *closing(const tfa_model *model, const model_loops *loops)
{
    if (!loops->open)
        return json_null();
    return json_pack("{ss si so so so}", "status", tfa_status_name(loops->status), "iterations",
                     (int)loops->iterations, "left", number(loops->left), "joint",
                     text_of(tfa_model_joint(model, loops->joint).name), "change",
                     number(loops->change));
}

static json_t *constraint(const model_report *r, uint32_t index)
{
    const tfa_model *model = r->model;
    const tfa_constraint_info c = tfa_model_constraint(model, index);
    const char *words[6];
    const size_t count = model_constraint_words(c.rows, words);
    json_t *hold = json_array(), *ends = json_array();
    for (size_t k = 0; k < count; k++)
        json_array_append_new(hold, json_string(words[k]));
    for (int side = 0; side < 2; side++) {
        const char *link = model_constraint_link(model, &c, side);
        json_array_append_new(ends, link ? text_of(link) : json_null());
    }
    return json_pack("{so so so sb so}", "name", text_of(c.name), "links", ends, "hold", hold,
                     "unilateral", (int)c.unilateral, "open", open_by(&r->loops, index));
}

static json_t *constraints(const model_report *r)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < tfa_model_constraint_count(r->model); i++)
        json_array_append_new(list, constraint(r, i));
    return list;
}

/* null: all joints have a motor */
static json_t *actuated(const tfa_model *model)
{
    if (!model_names_actuated(model))
        return json_null();
    json_t *list = json_array();
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++)
        if (tfa_model_joint(model, i).actuated)
            json_array_append_new(list, text_of(tfa_model_joint(model, i).name));
    return list;
}

/* Every joint of the file and its fate */
static json_t *declared(const tfa_model *model)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < tfa_model_declared_count(model); i++) {
        const tfa_declared_joint j = tfa_model_declared(model, i);
        json_t *joint = json_pack(
            "{so ss ss so}", "name", text_of(j.name), "type", tfa_joint_type_describe(j.type).name,
            "fate", tfa_word(TFA_WORDS_FATE, j.fate), "body", body_name(model, j.body));
        if (j.fate == TFA_FATE_FOLLOWS && j.leader >= 0) {
            json_object_set_new(joint, "leader",
                                text_of(tfa_model_joint(model, (uint32_t)j.leader).name));
            json_object_set_new(joint, "multiplier", number(j.multiplier));
            json_object_set_new(joint, "offset", number(j.offset));
        }
        json_array_append_new(list, joint);
    }
    return list;
}

static json_t *fates(const tfa_model_summary *s)
{
    uint32_t counts[TFA_FATE_ABSENT + 1];
    json_t *object = json_object();
    model_count_fates(s, counts);
    for (uint32_t fate = 0; fate <= TFA_FATE_ABSENT; fate++)
        json_object_set_new(object, tfa_word(TFA_WORDS_FATE, fate), json_integer(counts[fate]));
    return object;
}

static json_t *plan(const tfa_model *model, const tfa_model_summary *s)
{
    long_branch branch;
    const bool is_long = model_find_long_branch(model, &branch);
    return json_pack("{si si so so}", "main_chain", (int)s->main_chain, "depth", (int)s->depth,
                     "singular_body", body_name(model, s->singular_body), "long_branch",
                     body_name(model, is_long ? (int32_t)branch.body : -1));
}

static json_t *policies(const tfa_model_options *o)
{
    return json_pack("{ss ss sb sb sb sf sb sf}", "mimic", tfa_word(TFA_WORDS_MIMIC, o->mimic),
                     "inertia", tfa_word(TFA_WORDS_INERTIA, o->inertia), "rotor_inertia",
                     (int)o->rotor_inertia, "damping", (int)o->damping, "lock_massless_leaves",
                     (int)o->lock_massless_leaves, "snap", o->snap, "friction", (int)o->friction,
                     "friction_velocity",
                     o->friction_velocity > 0 ? o->friction_velocity : TFA_FRICTION_VELOCITY);
}

static json_t *scene(const tfa_scene *s)
{
    if (!s)
        return json_null();
    json_t *tips = json_array(), *locks = json_array(), *payloads = json_array(),
           *flexible = json_array();
    for (size_t i = 0; i < s->tip_count; i++)
        json_array_append_new(tips, text_of(s->tips[i]));
    for (size_t i = 0; i < s->lock_count; i++)
        json_array_append_new(locks, text_of(s->locks[i].joint));
    for (size_t i = 0; i < s->payload_count; i++)
        json_array_append_new(payloads, json_pack("{so sf}", "link", text_of(s->payloads[i].link),
                                                  "mass", s->payloads[i].mass));
    for (size_t i = 0; i < s->modes_count; i++)
        json_array_append_new(flexible, text_of(s->modes[i].link));
    return json_pack("{so so so so so}", "root", s->root ? text_of(s->root) : json_null(), "tips",
                     tips, "locks", locks, "payloads", payloads, "flexible_links", flexible);
}

static json_t *frames(const tfa_model *model)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < tfa_model_frame_count(model); i++)
        json_array_append_new(list, text_of(tfa_model_frame(model, i).name));
    return list;
}

static void add_model(json_t *root, const model_report *r)
{
    const tfa_model *model = r->model;
    const tfa_model_summary s = tfa_model_summarise(model);
    json_object_set_new(root, "robot", text_of(tfa_model_name(model)));
    json_object_set_new(root, "base", json_string(tfa_word(TFA_WORDS_BASE, s.base)));
    json_object_set_new(root, "policies", policies(&r->options->model));
    json_object_set_new(root, "scene", scene(r->options->model.scene));
    add_joints(root, model);
    json_object_set_new(root, "modes", modes(model));
    json_object_set_new(root, "constraints", constraints(r));
    json_object_set_new(root, "closing", closing(model, &r->loops));
    json_object_set_new(root, "actuated", actuated(model));
    json_object_set_new(root, "q_count", json_integer(s.q_count));
    json_object_set_new(root, "v_count", json_integer(s.v_count));
    json_object_set_new(root, "link_count", json_integer(s.links));
    json_object_set_new(root, "joint_count", json_integer(s.joints));
    json_object_set_new(root, "body_count", json_integer(s.bodies));
    json_object_set_new(root, "fates", fates(&s));
    json_object_set_new(root, "declared_joints", declared(model));
    json_object_set_new(root, "bodies", bodies(r));
    json_object_set_new(root, "world_links", links(r, r->bodies));
    json_object_set_new(root, "frames", frames(model));
    json_object_set_new(root, "moving_mass", number(s.moving_mass));
    json_object_set_new(root, "total_mass", number(s.total_mass));
    json_object_set_new(root, "centre_of_mass", vector(s.com));
    json_object_set_new(root, "gravity", vector(s.gravity));
    json_object_set_new(root, "plan", plan(model, &s));
    json_object_set_new(root, "kernel", text_of(r->kernel));
    json_object_set_new(root, "hash", json_string(tfa_model_hash_text(model)));
    json_object_set_new(root, "isa", json_string(tfa_isa_name()));
    json_object_set_new(root, "version", json_string(TFA_VERSION));
}

int model_report_print_json(const model_report *r)
{
    json_t *root = json_pack("{so ss so so so so}", "file", text_of(r->file), "status",
                             r->model ? "ok" : "error", "messages", messages(r), "message_counts",
                             codes(r), "ignored", selected(r, model_code_is_ignored), "repaired",
                             selected(r, model_code_is_repaired));
    if (r->model)
        add_model(root, r);
    int failed = json_dumpf(root, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) != 0;
    putchar('\n');
    json_decref(root);
    return failed;
}
