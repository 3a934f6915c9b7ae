/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads policies and scenes off the command line.
 */
#include "scene_options.h"

#include "commands.h"
#include "load_model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    KEY_BASE = 1024,
    KEY_GRAVITY,
    KEY_MIMIC,
    KEY_INERTIA,
    KEY_ROTOR,
    KEY_DAMPING,
    KEY_FRICTION,
    KEY_FRICTION_VELOCITY,
    KEY_MASSLESS,
    KEY_LOCK,
    KEY_ROOT,
    KEY_TIP,
    KEY_PAYLOAD,
    KEY_ROTORS,
    KEY_ARMATURE,
    KEY_SNAP,
    KEY_MODES,
    KEY_CONSTRAINTS,
};

static const struct argp_option option_table[] = {
    {.doc = "How the file becomes a model:"},
    {.name = "base", .key = KEY_BASE, .arg = "fixed|floating", .doc = "The root link (fixed)"},
    {.name = "gravity",
     .key = KEY_GRAVITY,
     .arg = "X,Y,Z",
     .doc = "Gravity in the world, m/s^2 (0,0,-9.80665)"},
    {.name = "mimic",
     .key = KEY_MIMIC,
     .arg = "free|project|lock",
     .doc = "Joints that mimic others are ordinary joints, follow exactly, or stand still (free)"},
    {.name = "inertia",
     .key = KEY_INERTIA,
     .arg = "strict|warn|repair|strict-physical",
     .doc = "An inertia that no body can have: strict refuses negative eigenvalues, "
            "strict-physical a broken triangle inequality, too; warn uses it as written; repair "
            "makes negative eigenvalues 0 (strict)"},
    {.name = "rotor-inertia",
     .key = KEY_ROTOR,
     .doc = "Apply drake:rotor_inertia of the file (left out unless asked for)"},
    {.name = "damping",
     .key = KEY_DAMPING,
     .doc = "Apply the damping of the file (left out unless asked for)"},
    {.name = "friction",
     .key = KEY_FRICTION,
     .doc = "Apply the friction of the file (left out unless asked for)"},
    {.name = "friction-velocity",
     .key = KEY_FRICTION_VELOCITY,
     .arg = "SPEED",
     .doc = "Below this speed, rad/s or m/s, friction fades to 0 at rest (0.01)"},
    {.name = "lock-massless-leaves",
     .key = KEY_MASSLESS,
     .doc = "Lock joints that move nothing with mass (an error unless asked for)"},
    {.name = "snap",
     .key = KEY_SNAP,
     .arg = "ANGLE",
     .doc = "Rotations within ANGLE rad of right angles become exactly that; a note says what the "
            "largest change was (as in the file)"},
    {.doc = "Parts of it that are modelled:"},
    {.name = "lock",
     .key = KEY_LOCK,
     .arg = "JOINT=VALUE",
     .doc = "Joint that stands still at this coordinate (several: x,y,..), as if it were fixed"},
    {.name = "root", .key = KEY_ROOT, .arg = "LINK", .doc = "Only the subtree of this link"},
    {.name = "tip",
     .key = KEY_TIP,
     .arg = "LINK",
     .doc = "Only the trees that carry one of these links (fixed base)"},
    {.name = "payload",
     .key = KEY_PAYLOAD,
     .arg = "LINK:MASS[,X,Y,Z[,IXX,IXY,IXZ,IYY,IYZ,IZZ]]",
     .doc = "Load on a link: kg, its centre of mass in m, its inertia about that in kg m^2"},
    {.name = "rotor",
     .key = KEY_ROTORS,
     .arg = "JOINT=INERTIA",
     .doc = "Inertia of a motor's rotor, kg m^2, times the square of the joint's reduction in the "
            "file added to its armature"},
    {.name = "armature",
     .key = KEY_ARMATURE,
     .arg = "JOINT=INERTIA",
     .doc = "Reflected inertia of a joint's rotor, kg m^2 or kg, in place of the file's armature"},
    {.name = "modes",
     .key = KEY_MODES,
     .arg = "FILE",
     .doc = "Modes of flexible links, as YAML (`totalforce beam` writes those of a beam)"},
    {.name = "constraints",
     .key = KEY_CONSTRAINTS,
     .arg = "FILE",
     .doc = "Closed loops, contacts and joints with a motor, as YAML"},
    {.doc = "--lock, --tip, --payload, --rotor, --armature, --modes and --constraints may be given "
            "several times."},
    {0}};

/* One more of a list; ends the program without memory. */
static void *grow(struct argp_state *state, void *list, uint32_t count, size_t size)
{
    void *grown = reallocarray(list, (size_t)count + 1, size);
    if (!grown)
        argp_failure(state, EXIT_FAILED, 0, "%s", tfa_status_text(TFA_E_MEMORY));
    return grown;
}

/* Ends the name before the last `mark` and returns the text behind it. Names may hold the mark,
 * numbers do not. */
static const char *split(struct argp_state *state, const char *name, char *text, char mark,
                         const char *form)
{
    char *at = strrchr(text, mark);
    if (!at || at == text)
        argp_error(state, "--%s: '%s' is not %s", name, text, form);
    *at = '\0';
    return at + 1;
}

int scene_options_lock(scene_options *o, const scene_lock *lock)
{
    scene_lock *locks = reallocarray(o->locks, (size_t)o->lock_count + 1, sizeof *locks);
    o->locks = locks ? locks : o->locks;
    tfa_lock *list = reallocarray(o->lock_list, (size_t)o->lock_count + 1, sizeof *list);
    o->lock_list = list ? list : o->lock_list;
    if (!locks || !list)
        return TFA_E_MEMORY;
    o->locks[o->lock_count] = *lock;
    o->lock_list[o->lock_count++] = lock->lock;
    return TFA_OK;
}

static void add_lock(struct argp_state *state, scene_options *o, char *text)
{
    const char *numbers = split(state, "lock", text, '=', "JOINT=VALUE");
    scene_lock lock = {.lock.joint = text};
    lock.numbers = option_numbers(state, "lock", numbers, lock.lock.q, 7);
    if (scene_options_lock(o, &lock) != TFA_OK)
        argp_failure(state, EXIT_FAILED, 0, "%s", tfa_status_text(TFA_E_MEMORY));
}

static void add_name(struct argp_state *state, const char ***names, uint32_t *count,
                     const char *text)
{
    *names = grow(state, *names, *count, sizeof **names);
    (*names)[(*count)++] = text;
}

static void add_payload(struct argp_state *state, scene_options *o, char *text)
{
    static const char form[] = "LINK:MASS[,X,Y,Z[,IXX,IXY,IXZ,IYY,IYZ,IZZ]]";
    double n[10] = {0};
    o->payloads = grow(state, o->payloads, o->payload_count, sizeof *o->payloads);
    tfa_payload *payload = &o->payloads[o->payload_count++];
    const char *numbers = split(state, "payload", text, ':', form);
    const uint32_t count = option_numbers(state, "payload", numbers, n, 10);
    if (count != 1 && count != 4 && count != 10)
        argp_error(state, "--payload %s: %u numbers, must be 1, 4 or 10: %s", text, count, form);
    if (n[0] < 0)
        argp_error(state, "--payload %s: mass %g must not be negative", text, n[0]);
    *payload = (tfa_payload){.link = text, .mass = n[0]};
    memcpy(payload->com, n + 1, sizeof payload->com);
    memcpy(payload->inertia, n + 4, sizeof payload->inertia);
}

static void add_inertia(struct argp_state *state, const char *name, tfa_rotor **list,
                        uint32_t *count, char *text)
{
    const char *number = split(state, name, text, '=', "JOINT=INERTIA");
    *list = grow(state, *list, *count, sizeof **list);
    (*list)[(*count)++] = (tfa_rotor){text, option_double(state, name, number)};
}

static double read_friction_velocity(struct argp_state *state, const char *text)
{
    const double v = option_double(state, "friction-velocity", text);
    if (v < TFA_FRICTION_VELOCITY_MIN)
        argp_error(state, "--friction-velocity: %s is no velocity from %g rad/s or m/s on", text,
                   TFA_FRICTION_VELOCITY_MIN);
    return v;
}

void scene_options_finish(scene_options *o)
{
    o->scene.locks = o->lock_list;
    o->scene.lock_count = o->lock_count;
    o->scene.tips = o->tips;
    o->scene.tip_count = o->tip_count;
    o->scene.payloads = o->payloads;
    o->scene.payload_count = o->payload_count;
    o->scene.rotors = o->rotors;
    o->scene.rotor_count = o->rotor_count;
    o->scene.modes = o->modes.links;
    o->scene.modes_count = o->modes.count;
    o->scene.constraints = o->constraints.list;
    o->scene.constraint_count = o->constraints.count;
    o->scene.actuated = o->constraints.actuated;
    o->scene.actuated_count = o->constraints.actuated_count;
    if (o->scene.root || o->lock_count || o->tip_count || o->payload_count || o->rotor_count ||
        o->modes.count || o->constraints.count || o->constraints.actuated_count)
        o->model.scene = &o->scene;
}

/* How the file becomes a model. @return 0, or ARGP_ERR_UNKNOWN */
static error_t parse_policy(int key, char *text, struct argp_state *state)
{
    scene_options *o = state->input;
    switch (key) {
    case KEY_BASE:
        o->model.base = (tfa_base)option_enum(state, "base", text, TFA_WORDS_BASE);
        return 0;
    case KEY_GRAVITY:
        option_vector3(state, "gravity", text, o->gravity);
        o->model.gravity = o->gravity;
        return 0;
    case KEY_MIMIC:
        o->model.mimic = (tfa_mimic_policy)option_enum(state, "mimic", text, TFA_WORDS_MIMIC);
        return 0;
    case KEY_INERTIA:
        o->model.inertia =
            (tfa_inertia_policy)option_enum(state, "inertia", text, TFA_WORDS_INERTIA);
        return 0;
    case KEY_ROTOR:
        o->model.rotor_inertia = 1;
        return 0;
    case KEY_DAMPING:
        o->model.damping = 1;
        return 0;
    case KEY_FRICTION:
        o->model.friction = 1;
        return 0;
    case KEY_FRICTION_VELOCITY:
        o->model.friction_velocity = read_friction_velocity(state, text);
        return 0;
    case KEY_MASSLESS:
        o->model.lock_massless_leaves = 1;
        return 0;
    case KEY_SNAP:
        o->model.snap = option_double(state, "snap", text);
        if (o->model.snap < 0 || o->model.snap > TFA_SNAP_MAX)
            argp_error(state, "--snap: %s is not an angle from 0 to %g rad", text, TFA_SNAP_MAX);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    scene_options *o = state->input;
    switch (key) {
    case KEY_LOCK:
        add_lock(state, o, text);
        return 0;
    case KEY_ROOT:
        if (o->scene.root)
            argp_error(state, "--root: given twice, '%s' and '%s'", o->scene.root, text);
        o->scene.root = text;
        return 0;
    case KEY_TIP:
        add_name(state, &o->tips, &o->tip_count, text);
        return 0;
    case KEY_PAYLOAD:
        add_payload(state, o, text);
        return 0;
    case KEY_ROTORS:
        add_inertia(state, "rotor", &o->rotors, &o->rotor_count, text);
        return 0;
    case KEY_ARMATURE:
        add_inertia(state, "armature", &o->armature, &o->armature_count, text);
        return 0;
    case KEY_MODES:
        add_name(state, &o->modes_files, &o->modes_count, text);
        return 0;
    case KEY_CONSTRAINTS:
        add_name(state, &o->constraints_files, &o->constraints_count, text);
        return 0;
    case ARGP_KEY_END:
        scene_options_finish(o);
        return 0;
    default:
        return parse_policy(key, text, state);
    }
}

const struct argp scene_argp = {.options = option_table, .parser = parse_option};

/* The joints exist, or there were no model. */
static int locks_fit(const scene_options *o, const tfa_model *model)
{
    const uint32_t joints = tfa_model_declared_count(model);
    int fit = 1;
    for (uint32_t k = 0; k < o->lock_count; k++)
        for (uint32_t j = 0; j < joints; j++) {
            const tfa_declared_joint joint = tfa_model_declared(model, j);
            if (strcmp(joint.name, o->locks[k].lock.joint) != 0)
                continue;
            const uint32_t wanted = tfa_joint_type_describe(joint.type).coordinates;
            if (o->locks[k].numbers == wanted)
                break;
            fprintf(stderr, "--lock %s: %u numbers; the joint has %u coordinate%s\n", joint.name,
                    o->locks[k].numbers, wanted, wanted == 1 ? "" : "s: x,y,..");
            fit = 0;
            break;
        }
    return fit;
}

/* @return 1; 0 after an error message about the file */
static int has_loaded(int status, const char *file, tfa_severity lowest, const tfa_report *report)
{
    if (status == TFA_OK)
        return 1;
    print_messages(report, lowest);
    if (report->errors == 0)
        fprintf(stderr, "%s: error: %s\n", file, tfa_status_text(status));
    return 0;
}

/* Side files that are not read yet */
static int load_side_files(scene_options *o, tfa_severity lowest, tfa_report *report)
{
    for (; o->modes_read < o->modes_count; o->modes_read++) {
        const char *file = o->modes_files[o->modes_read];
        if (!has_loaded(tfa_modes_load(file, &o->modes, report), file, lowest, report))
            return 0;
    }
    for (; o->constraints_read < o->constraints_count; o->constraints_read++) {
        const char *file = o->constraints_files[o->constraints_read];
        if (!has_loaded(tfa_constraints_load(file, &o->constraints, report), file, lowest, report))
            return 0;
    }
    return 1;
}

tfa_model *load_scene(const char *path, scene_options *options, tfa_severity lowest,
                      tfa_report *report)
{
    report->syntax = TFA_SYNTAX_COMMAND_LINE;
    if (!load_side_files(options, lowest, report))
        return NULL;
    scene_options_finish(options);
    tfa_model *model = load_model(path, &options->model, options->armature, options->armature_count,
                                  lowest, report);
    if (!model || locks_fit(options, model))
        return model;
    tfa_model_free(model);
    return NULL;
}

void scene_options_free(scene_options *options)
{
    free(options->locks);
    free(options->lock_list);
    free(options->tips);
    free(options->payloads);
    free(options->rotors);
    free(options->armature);
    free(options->modes_files);
    tfa_modes_free(&options->modes);
    free(options->constraints_files);
    tfa_constraints_free(&options->constraints);
    *options = (scene_options){0};
}
