/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Conditions between a robot's ROS 2 configuration and its model. Needs no DDS.
 */
#include "dds/ros2/ros2.h"

#include "dds/ros2/ros2_names.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/text.h>

enum { GO_MOTORS = 20, HG_MOTORS = 35 };

typedef struct checker {
    const config_robot_ros2 *config;
    const tfa_model *model;
    gateway_error *error;
    uint32_t refused; /* bits 1u << CONFIG_REFUSE_x */
} checker;

/* @return `status`, for the caller to return */
__attribute__((format(printf, 4, 5))) static int fail(const checker *c, int status,
                                                      const char *path, const char *format, ...)
{
    va_list arguments;
    snprintf(c->error->path, sizeof c->error->path, "%s", path);
    va_start(arguments, format);
    vsnprintf(c->error->text, sizeof c->error->text, format, arguments);
    va_end(arguments);
    return status;
}

/* ---- names of ROS ---- */

static const char *name_space(const config_robot_ros2 *c)
{
    return c->namespace ? c->namespace : TFA_ROS2_DEFAULT_NAMESPACE;
}

static const char *node(const config_robot_ros2 *c)
{
    return c->node ? c->node : TFA_ROS2_DEFAULT_NODE;
}

static int check_topic(const checker *c, const char *key, const char *topic)
{
    char full[TFA_ROS2_NAME_MAX + 1];
    if (!topic || tfa_ros2_full_name(name_space(c->config), node(c->config), topic, full))
        return TFA_OK;
    return fail(c, TFA_E_ARGUMENT, key,
                "'%.80s' is no topic of ROS: letters, digits and '_' between single '/', not "
                "beginning with a digit",
                topic);
}

bool tfa_ros2_same_node(const config_robot_ros2 *a, const config_robot_ros2 *b)
{
    return strcmp(name_space(a), name_space(b)) == 0 && strcmp(node(a), node(b)) == 0;
}

/* Names of answers and of the service are below the node. */
static int check_node(const checker *c)
{
    const config_robot_ros2 *r = c->config;
    char full[TFA_ROS2_NAME_MAX + 1];
    if (!tfa_ros2_is_namespace(name_space(r)))
        return fail(c, TFA_E_ARGUMENT, "namespace",
                    "'%.80s' is no namespace of ROS; write it like /arm", r->namespace);
    if (!tfa_ros2_is_node_name(node(r)))
        return fail(c, TFA_E_ARGUMENT, "node",
                    "'%.80s' is no name of a node: letters, digits and '_', not beginning with a "
                    "digit",
                    r->node);
    if (!tfa_ros2_full_name(name_space(r), node(r), "~/" TFA_ROS2_LONGEST_NAME, full))
        return fail(c, TFA_E_ARGUMENT, r->node ? "node" : "namespace",
                    "too long: NAMESPACE/NODE/" TFA_ROS2_LONGEST_NAME " has more than %d bytes",
                    TFA_ROS2_NAME_MAX);
    return TFA_OK;
}

static int check_topics(const checker *c)
{
    const config_robot_ros2 *r = c->config;
    const struct {
        const char *key, *topic;
    } topics[] = {
        {"joint_states", r->joint_states},       {"odometry", r->odometry},
        {"effort_commands", r->effort_commands}, {"joint_efforts", r->joint_efforts},
        {"trajectory", r->trajectory},           {"robot_description", r->robot_description},
        {"unitree.topic", r->unitree.topic},     {"active_constraints", r->active_constraints},
    };
    char key[40];
    int status = check_node(c);
    for (size_t k = 0; k < sizeof topics / sizeof *topics && status == TFA_OK; k++)
        status = check_topic(c, topics[k].key, topics[k].topic);
    for (size_t k = 0; k < r->wrenches_count && status == TFA_OK; k++) {
        snprintf(key, sizeof key, "wrenches[%zu].topic", k);
        status = check_topic(c, key, r->wrenches[k].topic);
    }
    return status;
}

/* ---- names of the robot ---- */

static const char *name_of_frame(const void *model, size_t index)
{
    return tfa_model_frame(model, (uint32_t)index).name;
}

static const char *name_of_joint(const void *model, size_t index)
{
    return tfa_model_joint(model, (uint32_t)index).name;
}

static const char *name_of_constraint(const void *model, size_t index)
{
    return tfa_model_constraint(model, (uint32_t)index).name;
}

/* What the keys name. */
typedef struct part {
    const char *what;
    int status; /* there is none of that name */
    int32_t (*find)(const tfa_model *model, const char *name);
    uint32_t (*count)(const tfa_model *model);
    tfa_list_name name;
} part;

static const part a_link = {"link", TFA_E_LINK, tfa_model_find_frame, tfa_model_frame_count,
                            name_of_frame};
static const part a_joint = {"joint", TFA_E_JOINT, tfa_model_find_joint, tfa_model_joint_count,
                             name_of_joint};
static const part a_constraint = {"constraint", TFA_E_ARGUMENT, tfa_model_find_constraint,
                                  tfa_model_constraint_count, name_of_constraint};

static int check_name(const checker *c, const part *p, const char *path, const char *name)
{
    char nearest[160];
    if (!name || p->find(c->model, name) >= 0)
        return TFA_OK;
    tfa_suggest(name, c->model, p->count(c->model), p->name, nearest, sizeof nearest);
    return fail(c, p->status, path, "the robot has no %s '%.60s'; nearest: %s", p->what, name,
                nearest);
}

static int check_part(const checker *c, const part *p, const char *key, size_t index,
                      const char *more, const char *name)
{
    char path[48];
    snprintf(path, sizeof path, "%s[%zu]%s", key, index, more);
    return check_name(c, p, path, name);
}

static int check_parts(const checker *c, const part *p, const char *key, const char **names,
                       size_t count)
{
    int status = TFA_OK;
    for (size_t k = 0; k < count && status == TFA_OK; k++)
        status = check_part(c, p, key, k, "", names[k]);
    return status;
}

static int check_names(const checker *c)
{
    const config_robot_ros2 *r = c->config;
    int status = check_parts(c, &a_link, "tips", r->tips, r->tips_count);
    for (size_t k = 0; k < r->wrenches_count && status == TFA_OK; k++)
        status = check_part(c, &a_link, "wrenches", k, ".link", r->wrenches[k].link);
    if (status == TFA_OK)
        status = check_parts(c, &a_joint, "joints", r->joints, r->joints_count);
    for (size_t k = 0; k < r->unitree.motors_count && status == TFA_OK; k++)
        if (r->unitree.motors[k] && strcmp(r->unitree.motors[k], "-") != 0)
            status = check_part(c, &a_joint, "unitree.motors", k, "", r->unitree.motors[k]);
    if (status == TFA_OK)
        status = check_parts(c, &a_constraint, "constraints", r->constraints, r->constraints_count);
    return status;
}

/* ---- the observer ---- */

static int check_observer(const checker *c)
{
    const config_observer *o = &c->config->observer;
    if (!(o->gain > 0))
        return TFA_OK;
    if (tfa_model_mode_count(c->model))
        return fail(c, TFA_E_UNSUPPORTED, "observer",
                    "a robot with flexible links has none; leave out its modes or this key");
    if (tfa_model_base_freedoms(c->model) && c->config->unitree.type != CONFIG_UNITREE_NONE)
        return fail(c, TFA_E_ARGUMENT, "observer",
                    "it needs the linear velocity of the base, which a LowState does not have; "
                    "use joint_states and odometry");
    if (o->tip && c->refused >> CONFIG_REFUSE_LAMBDA & 1)
        return fail(c, TFA_E_ARGUMENT, "observer.tip",
                    "its wrench takes lambda, which the robot's key 'refuse' refuses; leave out "
                    "one of them");
    return check_name(c, &a_link, "observer.tip", o->tip);
}

/* ---- constraints ---- */

/* Messages part names by blanks. */
static int check_blanks(const checker *c)
{
    for (uint32_t k = 0; k < tfa_model_constraint_count(c->model); k++) {
        const char *name = tfa_model_constraint(c->model, k).name;
        if (name[strcspn(name, TFA_ROS2_BLANKS)])
            return fail(c, TFA_E_ARGUMENT, "active_constraints",
                        "constraint '%.60s' has a blank in its name, and messages have blanks "
                        "between names; rename it",
                        name);
    }
    return TFA_OK;
}

static int check_constraints(const checker *c)
{
    const config_robot_ros2 *r = c->config;
    const char *key = r->active_constraints ? "active_constraints" : "constraints";
    if (r->op == CONFIG_ROS2_CONSTRAINED_DYNAMICS && tfa_model_constraint_count(c->model) == 0)
        return fail(c, TFA_E_ARGUMENT, "op",
                    "%s has no constraints; give them to a scene of the robot and name it by "
                    "ros2.scene",
                    r->scene ? "the scene" : "the robot");
    if (r->op != CONFIG_ROS2_CONSTRAINED_DYNAMICS &&
        (r->active_constraints || r->constraints_count))
        return fail(c, TFA_E_ARGUMENT, key,
                    "forward_dynamics has no constraints; write op: constrained_dynamics");
    return r->active_constraints ? check_blanks(c) : TFA_OK;
}

/* No joint may be named twice: the second number would overwrite the first. */
static int check_distinct(const checker *c, const char *key, const char **names, size_t count)
{
    char path[48];
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < k; i++)
            if (names[k] && names[i] && strcmp(names[k], "-") != 0 &&
                strcmp(names[k], names[i]) == 0) {
                snprintf(path, sizeof path, "%s[%zu]", key, k);
                return fail(c, TFA_E_ARGUMENT, path, "'%.60s' is there twice, first as number %zu",
                            names[k], i);
            }
    return TFA_OK;
}

/* ---- kinds of robots ---- */

static int check_motors(const checker *c)
{
    const config_unitree *u = &c->config->unitree;
    const size_t most = u->type == CONFIG_UNITREE_GO ? GO_MOTORS : HG_MOTORS;
    if (u->type == CONFIG_UNITREE_NONE)
        return TFA_OK;
    if (u->motors_count == 0)
        return fail(c, TFA_E_ARGUMENT, "unitree.motors", "the joint of each motor is needed");
    if (u->motors_count > most)
        return fail(c, TFA_E_ARGUMENT, "unitree.motors",
                    "%zu motors; a LowState of this type has %zu", u->motors_count, most);
    if (c->config->joint_states)
        return fail(c, TFA_E_ARGUMENT, "joint_states",
                    "the state comes from unitree.topic; leave out one of them");
    if (c->config->odometry)
        return fail(c, TFA_E_ARGUMENT, "odometry",
                    "the base's orientation comes from unitree.topic; leave out one of them");
    return TFA_OK;
}

/* A joint without a motor would never have a position, and nothing would be answered. */
static int check_motors_of_joints(const checker *c)
{
    const config_unitree *u = &c->config->unitree;
    if (u->type == CONFIG_UNITREE_NONE)
        return TFA_OK;
    for (uint32_t j = 0; j < tfa_model_joint_count(c->model); j++) {
        const char *joint = tfa_model_joint(c->model, j).name;
        size_t k = 0;
        while (k < u->motors_count && (!u->motors[k] || strcmp(u->motors[k], joint) != 0))
            k++;
        if (k == u->motors_count)
            return fail(c, TFA_E_JOINT, "unitree.motors",
                        "joint '%.60s' has no motor: its position would be unknown; name it or "
                        "lock it",
                        joint);
    }
    return TFA_OK;
}

static int check_base(const checker *c)
{
    if (tfa_model_base_freedoms(c->model) == 0 || c->config->odometry ||
        c->config->unitree.type != CONFIG_UNITREE_NONE)
        return TFA_OK;
    return fail(c, TFA_E_ARGUMENT, "odometry",
                "a robot with a floating base needs its pose and twist from a topic");
}

static int check_coordinates(const checker *c)
{
    for (uint32_t j = 0; j < tfa_model_joint_count(c->model); j++) {
        const tfa_joint_info joint = tfa_model_joint(c->model, j);
        if (joint.q_count != 1)
            return fail(c, TFA_E_UNSUPPORTED, "enabled",
                        "joint '%.60s' has %u coordinates, a JointState has one for each joint; "
                        "lock it in a scene or use the totalforce topics",
                        joint.name, joint.q_count);
    }
    return TFA_OK;
}

bool tfa_ros2_serves(const tfa_robot *robot)
{
    const char *scene = robot->config->ros2.scene;
    return robot->scene && scene ? strcmp(robot->scene->name, scene) == 0 : !robot->scene && !scene;
}

static const char *name_of_scene(const void *robot, size_t index)
{
    return ((const config_robot *)robot)->scenes[index].name;
}

/* The model of the robot or of the scene that its key names. */
static int find_model(checker *c, const config_robot *robot, const tfa_robot *served)
{
    const char *scene = robot->ros2.scene;
    char nearest[160];
    for (size_t k = 0; k < tfa_robot_count(robot) && !c->model; k++)
        if (tfa_ros2_serves(&served[k]))
            c->model = served[k].model;
    if (c->model)
        return TFA_OK;
    tfa_suggest(scene, robot, robot->scenes_count, name_of_scene, nearest, sizeof nearest);
    return fail(c, TFA_E_ARGUMENT, "scene", "the robot has no scene '%.60s'; nearest: %s", scene,
                nearest);
}

int tfa_ros2_check_robot(const config *all, const config_robot *robot, const tfa_robot *served,
                         gateway_error *error)
{
    const config_robot_ros2 *settings = &robot->ros2;
    checker c = {settings, NULL, error, config_refusals(robot)};
    if (!all->ros2.enabled || !settings->enabled)
        return TFA_OK;
    int status = check_topics(&c);
    if (status == TFA_OK)
        status = find_model(&c, robot, served);
    if (status == TFA_OK)
        status = check_coordinates(&c);
    if (status == TFA_OK)
        status = check_base(&c);
    if (status == TFA_OK)
        status = check_motors(&c);
    if (status == TFA_OK)
        status = check_constraints(&c);
    if (status == TFA_OK)
        status = check_observer(&c);
    if (status == TFA_OK)
        status = check_names(&c);
    if (status == TFA_OK)
        status = check_distinct(&c, "joints", settings->joints, settings->joints_count);
    if (status == TFA_OK)
        status = check_distinct(&c, "unitree.motors", settings->unitree.motors,
                                settings->unitree.motors_count);
    if (status == TFA_OK)
        status = check_motors_of_joints(&c);
    return status;
}
