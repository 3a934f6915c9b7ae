/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce model`: what the loader made of a URDF.
 */
#include "commands.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

typedef struct model_options {
    const char *file;
    tfa_model_options model;
    int json;
} model_options;

enum { KEY_BASE = 256, KEY_JSON, KEY_ROTOR };

static const struct argp_option option_table[] = {
    {.name = "base", .key = KEY_BASE, .arg = "fixed|floating", .doc = "The root link (fixed)"},
    {.name = "rotor-inertia",
     .key = KEY_ROTOR,
     .doc = "Apply drake:rotor_inertia of the file (left out unless asked for)"},
    {.name = "json", .key = KEY_JSON, .doc = "Print the report as JSON"},
    {0}};

static error_t parse(int key, char *text, struct argp_state *state)
{
    model_options *options = state->input;
    switch (key) {
    case KEY_BASE:
        options->model.base = option_base(state, text);
        return 0;
    case KEY_ROTOR:
        options->model.rotor_inertia = 1;
        return 0;
    case KEY_JSON:
        options->json = 1;
        return 0;
    case ARGP_KEY_ARG:
        option_argument(state, &options->file, text);
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "which URDF file?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const char *joint_type_name(tfa_joint_type type)
{
    static const char *const names[] = {"fixed",     "revolute", "continuous",
                                        "prismatic", "planar",   "floating"};
    return (unsigned)type < sizeof names / sizeof names[0] ? names[type] : "unknown";
}

static const char *base_name(tfa_base base)
{
    return base == TFA_BASE_FLOATING ? "floating" : "fixed";
}

/* Strings of a URDF may hold any bytes: what is not UTF-8 is shown as such, not lost. */
static json_t *json_text(const char *text)
{
    json_t *string = json_string(text);
    return string ? string : json_string("(not UTF-8)");
}

static json_t *json_messages(const tfa_report *report)
{
    static const char *const severities[] = {"note", "warning", "error"};
    json_t *list = json_array();
    for (size_t i = 0; i < report->count; i++) {
        const tfa_message *message = &report->messages[i];
        json_array_append_new(list,
                              json_pack("{ss si ss so}", "severity", severities[message->severity],
                                        "line", (int)message->line, "code", message->code, "text",
                                        json_text(message->text)));
    }
    return list;
}

/* Bodies with the links that became part of them; the last entry is the world. Names stand
 * grouped by body, those of body b from first[b] to first[b + 1]. */
typedef struct merges {
    uint32_t bodies;
    uint32_t *first;
    const char **names;
} merges;

static int merges_init(merges *m, const tfa_model *model, uint32_t bodies)
{
    uint32_t frames = tfa_model_frame_count(model);
    *m = (merges){.bodies = bodies,
                  .first = calloc((size_t)bodies + 3, sizeof *m->first),
                  .names = calloc((size_t)frames + 1, sizeof *m->names)};
    if (!m->first || !m->names)
        return TFA_E_MEMORY;
    /* a counting sort: count two places on, so that filling leaves the starts in place */
    for (uint32_t i = 0; i < frames; i++) {
        int32_t body = tfa_model_frame(model, i).body;
        m->first[(body < 0 ? bodies : (uint32_t)body) + 2]++;
    }
    for (uint32_t b = 2; b < bodies + 3; b++)
        m->first[b] += m->first[b - 1];
    for (uint32_t i = 0; i < frames; i++) {
        tfa_frame_info frame = tfa_model_frame(model, i);
        uint32_t body = frame.body < 0 ? bodies : (uint32_t)frame.body;
        m->names[m->first[body + 1]++] = frame.name;
    }
    return TFA_OK;
}

static void merges_free(merges *m)
{
    free(m->first);
    free(m->names);
}

static json_t *json_links(const merges *m, uint32_t body)
{
    json_t *links = json_array();
    for (uint32_t i = m->first[body]; i < m->first[body + 1]; i++)
        json_array_append_new(links, json_text(m->names[i]));
    return links;
}

static json_t *json_bodies(const tfa_model *model, const merges *m)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < m->bodies; i++) {
        int32_t parent = tfa_model_body_parent(model, i);
        json_array_append_new(
            list, json_pack("{so si so so}", "name", json_text(tfa_model_body_name(model, i)),
                            "index", (int)i, "parent",
                            parent < 0 ? json_null()
                                       : json_text(tfa_model_body_name(model, (uint32_t)parent)),
                            "links", json_links(m, i)));
    }
    return list;
}

static void add_joints(json_t *root, const tfa_model *model)
{
    json_t *names = json_array(), *details = json_array();
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++) {
        tfa_joint_info joint = tfa_model_joint(model, i);
        json_array_append_new(names, json_text(joint.name));
        json_array_append_new(
            details,
            json_pack("{so ss si si si si si sf}", "name", json_text(joint.name), "type",
                      joint_type_name(joint.type), "q_index", (int)joint.q_index, "q_count",
                      (int)joint.q_count, "v_index", (int)joint.v_index, "v_count",
                      (int)joint.v_count, "body", (int)joint.body, "armature", joint.armature));
    }
    json_object_set_new(root, "joints", names);
    json_object_set_new(root, "joint_details", details);
}

static json_t *json_plan(const tfa_model *model, const tfa_model_summary *s)
{
    return json_pack(
        "{si si so}", "main_chain", (int)s->main_chain, "depth", (int)s->depth, "singular_body",
        s->singular_body < 0 ? json_null()
                             : json_text(tfa_model_body_name(model, (uint32_t)s->singular_body)));
}

static json_t *json_frames(const tfa_model *model)
{
    json_t *frames = json_array();
    for (uint32_t i = 0; i < tfa_model_frame_count(model); i++)
        json_array_append_new(frames, json_text(tfa_model_frame(model, i).name));
    return frames;
}

static int print_json(const model_options *options, const tfa_report *report,
                      const tfa_model *model, const merges *m)
{
    json_t *root = json_pack("{so ss so}", "file", json_text(options->file), "status",
                             model ? "ok" : "error", "messages", json_messages(report));
    if (model) {
        tfa_model_summary s = tfa_model_summarise(model);
        json_object_set_new(root, "robot", json_text(tfa_model_name(model)));
        json_object_set_new(root, "base", json_string(base_name(s.base)));
        add_joints(root, model);
        json_object_set_new(root, "q_count", json_integer(s.q_count));
        json_object_set_new(root, "v_count", json_integer(s.v_count));
        json_object_set_new(root, "link_count", json_integer(s.links));
        json_object_set_new(root, "joint_count", json_integer(s.joints));
        json_object_set_new(root, "body_count", json_integer(s.bodies));
        json_object_set_new(root, "bodies", json_bodies(model, m));
        json_object_set_new(root, "world_links", json_links(m, m->bodies));
        json_object_set_new(root, "frames", json_frames(model));
        json_object_set_new(root, "moving_mass", json_real(s.moving_mass));
        json_object_set_new(root, "total_mass", json_real(s.total_mass));
        json_object_set_new(root, "gravity",
                            json_pack("[f,f,f]", s.gravity[0], s.gravity[1], s.gravity[2]));
        json_object_set_new(root, "plan", json_plan(model, &s));
        json_object_set_new(root, "hash", json_string(tfa_model_hash_text(model)));
        json_object_set_new(root, "isa", json_string(tfa_isa_name()));
        json_object_set_new(root, "version", json_string(TFA_VERSION));
    }
    int failed = json_dumpf(root, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) != 0;
    putchar('\n');
    json_decref(root);
    return failed;
}

/* The links a body swallowed, on one line; nothing when it is a single link. */
static void print_merged(const merges *m, uint32_t body, const char *name)
{
    int merged = 0;
    for (uint32_t i = m->first[body]; i < m->first[body + 1]; i++) {
        if (strcmp(m->names[i], name) == 0)
            continue;
        if (merged++ == 0)
            printf("    %s <-", name);
        printf(" %s", m->names[i]);
    }
    if (merged)
        putchar('\n');
}

static void print_joints(const tfa_model *model)
{
    printf("  joints (order of q, v, tau, qdd)\n");
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++) {
        tfa_joint_info joint = tfa_model_joint(model, i);
        printf("    %3" PRIu32 "  %-10s %-24s moves %s", joint.v_index, joint_type_name(joint.type),
               joint.name, tfa_model_body_name(model, joint.body));
        if (joint.armature > 0)
            printf("  armature %g", joint.armature);
        putchar('\n');
    }
}

static int print_text(const model_options *options, const tfa_model *model, const merges *m)
{
    tfa_model_summary s = tfa_model_summarise(model);
    printf("%s: robot '%s', base %s\n", options->file, tfa_model_name(model), base_name(s.base));
    printf("  links %" PRIu32 ", joints %" PRIu32 " -> bodies %" PRIu32 ", coordinates %" PRIu32
           ", freedoms %" PRIu32 "\n",
           s.links, s.joints, s.bodies, s.q_count, s.v_count + tfa_model_base_freedoms(model));
    printf("  mass %.6g kg moving, %.6g kg in all\n", s.moving_mass, s.total_mass);
    printf("  gravity %g %g %g m/s^2\n", s.gravity[0], s.gravity[1], s.gravity[2]);
    printf("  plan: main chain %" PRIu32 " of %" PRIu32 " bodies, depth %" PRIu32 "\n",
           s.main_chain, s.bodies, s.depth);
    if (s.singular_body >= 0)
        printf("  plan: tfa is refused, body '%s' has an inertia without inverse; auto avoids it\n",
               tfa_model_body_name(model, (uint32_t)s.singular_body));
    printf("  kernels %s\n  hash %s\n", tfa_isa_name(), tfa_model_hash_text(model));
    print_joints(model);
    printf("  merged (body <- links kept as frames)\n");
    print_merged(m, m->bodies, "(world)");
    for (uint32_t i = 0; i < m->bodies; i++)
        print_merged(m, i, tfa_model_body_name(model, i));
    return ferror(stdout);
}

int command_model(int argc, char **argv)
{
    static const struct argp argp = {
        .options = option_table,
        .parser = parse,
        .args_doc = "FILE.urdf",
        .doc = "Loads a URDF and reports what became of it: bodies before and after, masses, what "
               "was merged, the order of the joints, the plan.\v"
               "Errors, warnings and notes go to standard error as FILE:LINE: severity: text; with "
               "--json they are in \"messages\" instead."};
    model_options options = {0};
    error_t error = argp_parse(&argp, argc, argv, 0, NULL, &options);
    if (error) {
        fprintf(stderr, "totalforce model: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    tfa_report report = {0};
    tfa_model *model = load_model(options.file, &options.model,
                                  options.json ? (tfa_severity)(TFA_ERROR + 1) : TFA_NOTE, &report);
    merges m = {0};
    int failed = model && merges_init(&m, model, tfa_model_summarise(model).bodies) != TFA_OK;
    if (failed)
        fprintf(stderr, "totalforce model: %s\n", tfa_status_text(TFA_E_MEMORY));
    else if (options.json)
        failed = print_json(&options, &report, model, &m);
    else if (model)
        failed = print_text(&options, model, &m);
    if (fflush(stdout) != 0 || failed) {
        perror("totalforce model: standard output");
        failed = 1;
    }
    merges_free(&m);
    tfa_report_free(&report);
    tfa_model_free(model);
    return model && !failed ? EXIT_GOOD : EXIT_FAILED;
}
