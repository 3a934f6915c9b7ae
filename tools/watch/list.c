/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce list`: the robots of a running daemon, their models, kernels and doors.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/operator.h"
#include "watch.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { KEY_JSON = 256 };

typedef struct arguments {
    const char *runtime_dir;
    int json;
} arguments;

static const struct argp_option options[] = {{"json", KEY_JSON, NULL, 0, "Print JSON", 0}, {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->runtime_dir;
        return 0;
    case KEY_JSON:
        a->json = 1;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: no argument is taken", text);
        return EINVAL;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Clients of a robot by their way in. */
static uint32_t count_clients(const tfa_snapshot *s, uint32_t robot, uint32_t kind)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->client_count; i++)
        count += s->clients[i].served.robot == robot && s->clients[i].served.kind == kind;
    return count;
}

/* ---- text ---- */

static void print_robot(const tfa_snapshot *s, uint32_t i)
{
    const tfa_served_robot *r = &s->robots[i].served;
    printf("%s: %u joints, %u freedoms%s, model %.16s\n", r->name, r->joints,
           r->freedoms + r->base_freedoms, r->base_freedoms ? " (floating base)" : "",
           r->model_hash);
    printf("  kernel: %s, %s, %s\n", r->kernel_isa, r->precision,
           r->kernel_file[0] ? r->kernel_file : "generic");
    printf("  shared memory: %s/%s.sock, %u clients\n", s->runtime_dir, r->name,
           count_clients(s, i, TFA_CLIENT_SHM));
    if (r->dds)
        printf("  dds: domain %u, totalforce/request and reply, joint_torques and "
               "joint_accelerations, key '%s'\n",
               r->dds_domain, r->name);
    if (r->ros2_node[0])
        printf("  ros2: domain %u, namespace %s, node %s\n", r->ros2_domain, r->ros2_namespace,
               r->ros2_node);
}

/* ---- JSON ---- */

static json_t *json_robot(const tfa_snapshot *s, uint32_t i)
{
    const tfa_served_robot *r = &s->robots[i].served;
    json_t *robot = json_pack(
        "{s:s, s:s, s:i, s:i, s:b, s:s, s:s, s:o, s:o, s:i}", "name", r->name, "model",
        r->model_hash, "joints", (int)r->joints, "freedoms", (int)(r->freedoms + r->base_freedoms),
        "floating", r->base_freedoms != 0, "isa", r->kernel_isa, "precision", r->precision,
        "specialised", r->kernel_file[0] ? json_string(r->kernel_file) : json_null(), "socket",
        json_sprintf("%s/%s.sock", s->runtime_dir, r->name), "clients",
        (int)count_clients(s, i, TFA_CLIENT_SHM));
    if (r->dds)
        json_object_set_new(robot, "dds", json_pack("{s:i}", "domain", (int)r->dds_domain));
    if (r->ros2_node[0])
        json_object_set_new(robot, "ros2",
                            json_pack("{s:i, s:s, s:s}", "domain", (int)r->ros2_domain, "namespace",
                                      r->ros2_namespace, "node", r->ros2_node));
    return robot;
}

static int print_json(const tfa_snapshot *s)
{
    json_t *robots = json_array();
    for (uint32_t i = 0; i < s->robot_count; i++)
        json_array_append_new(robots, json_robot(s, i));
    json_t *all = json_pack("{s:s, s:i, s:o}", "version", s->version, "process", (int)s->process,
                            "robots", robots);
    const int bad = !all || json_dumpf(all, stdout, JSON_INDENT(2)) != 0 || putchar('\n') == EOF;
    json_decref(all);
    return bad;
}

int command_list(int argc, char **argv)
{
    static const struct argp_child children[] = {{.argp = &operator_argp}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse_option,
        .children = children,
        .doc = "Lists the robots of a running daemon: model, kernel, doors (socket, DDS, ROS 2), "
               "clients."};
    arguments a = {0};
    const error_t error = command_line_parse(&argp, NULL, argc, argv, &a);
    if (error) {
        fprintf(stderr, "totalforce list: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    watch w = {.runtime_dir = a.runtime_dir};
    const int status = watch_open(&w, 0);
    if (status != TFA_OK) {
        operator_explain("list", a.runtime_dir, status);
        return EXIT_FAILED;
    }
    int bad = 0;
    for (uint32_t i = 0; i < w.now->robot_count && !a.json; i++)
        print_robot(w.now, i);
    if (a.json)
        bad = print_json(w.now);
    watch_close(&w);
    return bad || fflush(stdout) != 0 ? EXIT_FAILED : EXIT_GOOD;
}
