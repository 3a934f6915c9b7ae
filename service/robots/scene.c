/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scenes of the configuration: names checked against the robot, constants shared where they can be.
 */
#include "scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/constraints.h>
#include <totalforce/text.h>

#include "platform/log.h"

static const double standard_gravity[3] = {0, 0, -9.80665};
static const config_scene whole_robot = {.base = CONFIG_BASE_SAME};

static const config_scene *scene_of(const tfa_robot_source *s)
{
    return s->scene ? s->scene : &whole_robot;
}

static tfa_base base_of(const tfa_robot_source *s)
{
    const uint32_t base = scene_of(s)->base;
    return (tfa_base)(base == CONFIG_BASE_SAME ? s->robot->base : base);
}

static const double *gravity_of(const tfa_robot_source *s)
{
    if (scene_of(s)->gravity_count)
        return s->scene->gravity;
    return s->robot->gravity_count ? s->robot->gravity : standard_gravity;
}

/* ---- names ---- */

static const char *link_name(const void *description, size_t index)
{
    return ((const tfa_description *)description)->links[index].name;
}

static const char *joint_name(const void *description, size_t index)
{
    return ((const tfa_description *)description)->joints[index].name;
}

/* Logs an error about a key of the robot source, with its location. */
__attribute__((format(printf, 3, 4))) static void
log_key_error(const tfa_robot_source *s, const char *key, const char *format, ...)
{
    char path[160], location[160], what[200];
    va_list arguments;
    const size_t robot = (size_t)(s->robot - s->settings->robots);
    if (s->scene)
        snprintf(path, sizeof path, "robots[%zu].scenes[%zu].%s", robot,
                 (size_t)(s->scene - s->robot->scenes), key);
    else
        snprintf(path, sizeof path, "robots[%zu].%s", robot, key);
    config_location(s->settings, path, location, sizeof location);
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    tfa_log(TFA_LOG_ERROR, "%s: robot '%s'%s%s%s: %s", location, s->robot->name,
            s->scene ? ", scene '" : "", s->scene ? s->scene->name : "", s->scene ? "'" : "", what);
}

static int check_link(const tfa_robot_source *s, const tfa_description *d, const char *key,
                      const char *name)
{
    char suggestions[120];
    for (size_t i = 0; i < d->link_count; i++)
        if (strcmp(d->links[i].name, name) == 0)
            return TFA_OK;
    tfa_suggest(name, d, d->link_count, link_name, suggestions, sizeof suggestions);
    log_key_error(s, key, "no link '%s'; nearest: %s", name, suggestions);
    return TFA_E_LINK;
}

static tfa_joint *find_joint(const tfa_robot_source *s, const tfa_description *d, const char *key,
                             const char *name)
{
    char suggestions[120];
    for (size_t i = 0; i < d->joint_count; i++)
        if (strcmp(d->joints[i].name, name) == 0)
            return &d->joints[i];
    tfa_suggest(name, d, d->joint_count, joint_name, suggestions, sizeof suggestions);
    log_key_error(s, key, "no joint '%s'; nearest: %s", name, suggestions);
    return NULL;
}

int tfa_robot_source_set_armature(const tfa_robot_source *robot, tfa_description *description)
{
    char key[64];
    for (size_t i = 0; i < robot->robot->armature_count; i++) {
        const config_armature *a = &robot->robot->armature[i];
        snprintf(key, sizeof key, "armature[%zu].joint", i);
        tfa_joint *joint = find_joint(robot, description, key, a->joint);
        if (!joint)
            return TFA_E_JOINT;
        joint->armature = a->value;
    }
    return TFA_OK;
}

/* ---- a scene as the library takes it ---- */

/* The lists that a tfa_scene points to. */
typedef struct lists {
    tfa_lock *locks;
    tfa_payload *payloads;
    tfa_constraint *constraints;
    tfa_rotor *rotors;
} lists;

static void free_lists(lists *l)
{
    free(l->locks);
    free(l->payloads);
    free(l->constraints);
    free(l->rotors);
}

static int fill_lock(const tfa_robot_source *s, const tfa_description *d, size_t i, tfa_lock *lock)
{
    const config_lock *from = &s->scene->locked[i];
    char key[64];
    snprintf(key, sizeof key, "locked[%zu].joint", i);
    const tfa_joint *joint = find_joint(s, d, key, from->joint);
    if (!joint)
        return TFA_E_JOINT;
    const uint32_t coordinates = tfa_joint_type_describe(joint->type).coordinates;
    const size_t wanted = coordinates > 1 ? coordinates : 0;
    if (from->pose_count != wanted) {
        if (wanted)
            log_key_error(s, key, "joint '%s' stands at a `pose` of %zu numbers", joint->name,
                          wanted);
        else
            log_key_error(s, key, "joint '%s' stands at one `q`, not at a `pose`", joint->name);
        return TFA_E_VALUE;
    }
    *lock = (tfa_lock){.joint = from->joint, .q = {from->q}};
    if (wanted)
        memcpy(lock->q, from->pose, wanted * sizeof *lock->q);
    return TFA_OK;
}

static int fill_payload(const tfa_robot_source *s, const tfa_description *d, size_t i,
                        tfa_payload *payload)
{
    const config_payload *from = &s->scene->payload[i];
    char key[64];
    snprintf(key, sizeof key, "payload[%zu].link", i);
    *payload = (tfa_payload){.link = from->link, .mass = from->mass};
    if (from->com_count)
        memcpy(payload->com, from->com, sizeof payload->com);
    if (from->inertia_count)
        memcpy(payload->inertia, from->inertia, sizeof payload->inertia);
    return check_link(s, d, key, from->link);
}

static int fill_frame(const tfa_robot_source *s, const tfa_description *d, const char *key,
                      const config_frame *from, tfa_constraint *c, int side)
{
    char path[80];
    tfa_constraint_set_pose(c->pose[side], from->xyz_count ? from->xyz : NULL,
                            from->rpy_count ? from->rpy : NULL);
    if (!from->link || strcmp(from->link, "world") == 0)
        return TFA_OK;
    c->link[side] = from->link;
    snprintf(path, sizeof path, "%s.%s.link", key, side ? "second" : "first");
    return check_link(s, d, path, from->link);
}

static int fill_constraint(const tfa_robot_source *s, const tfa_description *d, size_t i,
                           tfa_constraint *c)
{
    const config_constraint *from = &s->scene->constraints[i];
    char key[64];
    snprintf(key, sizeof key, "constraints[%zu]", i);
    *c = (tfa_constraint){
        .name = from->name, .rows = config_constraint_rows(from), .unilateral = from->unilateral};
    const int status = fill_frame(s, d, key, &from->first, c, 0);
    return status == TFA_OK ? fill_frame(s, d, key, &from->second, c, 1) : status;
}

/* Of the robot, whose armature they are in each scene */
static int fill_rotors(const tfa_robot_source *s, const tfa_description *d, lists *l,
                       tfa_scene *scene)
{
    const config_robot *robot = s->robot;
    char key[64];
    l->rotors = calloc(robot->rotors_count + 1, sizeof *l->rotors);
    if (!l->rotors)
        return TFA_E_MEMORY;
    for (size_t i = 0; i < robot->rotors_count; i++) {
        snprintf(key, sizeof key, "rotors[%zu].joint", i);
        if (!find_joint(s, d, key, robot->rotors[i].joint))
            return TFA_E_JOINT;
        l->rotors[i] = (tfa_rotor){robot->rotors[i].joint, robot->rotors[i].value};
    }
    scene->rotors = l->rotors;
    scene->rotor_count = robot->rotors_count;
    return TFA_OK;
}

static int check_actuated(const tfa_robot_source *s, const tfa_description *d)
{
    const config_scene *scene = scene_of(s);
    char key[64];
    for (size_t i = 0; i < scene->actuated_count; i++) {
        snprintf(key, sizeof key, "actuated[%zu]", i);
        if (!find_joint(s, d, key, scene->actuated[i]))
            return TFA_E_JOINT;
    }
    return TFA_OK;
}

static int load_modes(const tfa_robot_source *s, tfa_modes *modes, tfa_report *report)
{
    const config_scene *from = scene_of(s);
    int status = TFA_OK;
    for (size_t i = 0; i < from->modes_count && status == TFA_OK; i++) {
        char *path = config_file_path(s->settings, from->modes[i]);
        status = path ? tfa_modes_load(path, modes, report) : TFA_E_MEMORY;
        free(path);
    }
    return status;
}

static int fill_scene(const tfa_robot_source *s, const tfa_description *d, lists *l,
                      const tfa_modes *modes, tfa_scene *scene)
{
    const config_scene *from = scene_of(s);
    int status = from->root ? check_link(s, d, "root", from->root) : TFA_OK;
    char key[64];
    l->locks = calloc(from->locked_count + 1, sizeof *l->locks);
    l->payloads = calloc(from->payload_count + 1, sizeof *l->payloads);
    l->constraints = calloc(from->constraints_count + 1, sizeof *l->constraints);
    if (!l->locks || !l->payloads || !l->constraints)
        return TFA_E_MEMORY;
    for (size_t i = 0; i < from->tips_count && status == TFA_OK; i++) {
        snprintf(key, sizeof key, "tips[%zu]", i);
        status = check_link(s, d, key, from->tips[i]);
    }
    for (size_t i = 0; i < from->locked_count && status == TFA_OK; i++)
        status = fill_lock(s, d, i, &l->locks[i]);
    for (size_t i = 0; i < from->payload_count && status == TFA_OK; i++)
        status = fill_payload(s, d, i, &l->payloads[i]);
    for (size_t i = 0; i < from->constraints_count && status == TFA_OK; i++)
        status = fill_constraint(s, d, i, &l->constraints[i]);
    if (status == TFA_OK)
        status = check_actuated(s, d);
    *scene = (tfa_scene){.root = from->root,
                         .tips = from->tips,
                         .tip_count = from->tips_count,
                         .locks = l->locks,
                         .lock_count = from->locked_count,
                         .payloads = l->payloads,
                         .payload_count = from->payload_count,
                         .modes = modes->links,
                         .modes_count = modes->count,
                         .constraints = l->constraints,
                         .constraint_count = from->constraints_count,
                         .actuated = from->actuated,
                         .actuated_count = from->actuated_count};
    return status == TFA_OK ? fill_rotors(s, d, l, scene) : status;
}

/* ---- sharing ---- */

static bool same_locks(const config_scene *a, const config_scene *b)
{
    if (a->locked_count != b->locked_count)
        return false;
    for (size_t i = 0; i < a->locked_count; i++) {
        const config_lock *x = &a->locked[i], *y = &b->locked[i];
        if (strcmp(x->joint, y->joint) != 0 || memcmp(&x->q, &y->q, sizeof x->q) != 0 ||
            x->pose_count != y->pose_count ||
            (x->pose_count && memcmp(x->pose, y->pose, x->pose_count * sizeof *x->pose) != 0))
            return false;
    }
    return true;
}

static bool same_tips(const config_scene *a, const config_scene *b)
{
    if (a->tips_count != b->tips_count)
        return false;
    for (size_t i = 0; i < a->tips_count; i++)
        if (strcmp(a->tips[i], b->tips[i]) != 0)
            return false;
    return true;
}

/* True with constants of its own, which deriving neither adds nor removes */
static bool has_own_constants(const config_scene *scene)
{
    return scene->modes_count || scene->constraints_count || scene->actuated_count;
}

/* Do two sources of one robot differ in gravity and payloads only, so that `s` can be derived of
 * `origin`? Deriving replaces payloads but cannot take them away. */
static bool can_derive(const tfa_robot_source *s, const tfa_robot_source *origin)
{
    const config_scene *a = scene_of(s), *b = scene_of(origin);
    if (base_of(s) != base_of(origin) || (b->payload_count && !a->payload_count) ||
        has_own_constants(a) || has_own_constants(b))
        return false;
    if ((a->root || b->root) && (!a->root || !b->root || strcmp(a->root, b->root) != 0))
        return false;
    return same_tips(a, b) && same_locks(a, b);
}

void tfa_shared_model_drop(tfa_shared_model *shared)
{
    while (shared && --shared->holders == 0) {
        tfa_shared_model *origin = shared->origin;
        tfa_model_free(shared->model);
        tfa_modes_free(&shared->modes);
        free(shared);
        shared = origin;
    }
}

/* ---- compiling ---- */

static int create(const tfa_robot_source *s, const tfa_description *d, const tfa_scene *scene,
                  tfa_report *report, tfa_model **model)
{
    const config_robot *robot = s->robot;
    const tfa_model_options options = {.base = base_of(s),
                                       .gravity = gravity_of(s),
                                       .rotor_inertia = robot->rotor_inertia,
                                       .damping = robot->damping,
                                       .friction = robot->friction,
                                       .friction_velocity = robot->friction_velocity,
                                       .lock_massless_leaves = robot->lock_massless_leaves,
                                       .snap = robot->snap,
                                       .inertia = (tfa_inertia_policy)robot->inertia,
                                       .mimic = (tfa_mimic_policy)robot->mimic,
                                       .scene = scene};
    return tfa_model_create(d, &options, report, model);
}

int tfa_robot_source_compile(const tfa_robot_source *source, const tfa_description *description,
                             const tfa_robot_source *before, tfa_shared_model *const *models,
                             size_t before_count, tfa_report *report, tfa_shared_model **made)
{
    lists l = {0};
    tfa_scene scene;
    size_t origin = 0;
    tfa_shared_model *shared = calloc(1, sizeof *shared);
    *made = NULL;
    int status = shared ? TFA_OK : TFA_E_MEMORY;
    if (status == TFA_OK) {
        shared->holders = 1;
        status = load_modes(source, &shared->modes, report);
    }
    if (status == TFA_OK)
        status = fill_scene(source, description, &l, &shared->modes, &scene);
    if (status != TFA_OK)
        goto done;
    while (origin < before_count && !can_derive(source, &before[origin]))
        origin++;
    if (origin < before_count)
        status = tfa_model_derive(models[origin]->model, gravity_of(source), scene.payloads,
                                  scene.payload_count, report, &shared->model);
    else
        status = create(source, description, &scene, report, &shared->model);
    if (status != TFA_OK)
        goto done;
    if (origin < before_count) {
        shared->origin = models[origin];
        shared->origin->holders++;
    }
    *made = shared;
    shared = NULL;
done:
    tfa_shared_model_drop(shared);
    free_lists(&l);
    return status;
}
