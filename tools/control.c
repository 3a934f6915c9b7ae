/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce status`, `reload` and `stop`: commands for a running daemon.
 */
#include "command_line/command_line.h"
#include "common/commands.h"
#include "common/operator.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>

enum { KEY_JSON = 256 };

#define TEXT_BYTES 65536
#define RELOAD_MS 600000 /* large robots take a while */

typedef struct arguments {
    const char *runtime_dir;
    int json;
} arguments;

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

static const struct argp_child children[] = {{.argp = &operator_argp}, {0}};
static const struct argp_option status_options[] = {
    {"json", KEY_JSON, NULL, 0, "Print the daemon's JSON", 0}, {0}};

/* Gives the command, or says what stands in the way. @return an exit status */
static int give(const char *command, const arguments *a, int32_t timeout_ms, char text[TEXT_BYTES])
{
    const int status = tfa_daemon_command(a->runtime_dir, command, timeout_ms, text, TEXT_BYTES);
    if (status == TFA_OK)
        return EXIT_GOOD;
    if (*text)
        fprintf(stderr, "totalforce %s: %s\n", command, text);
    else
        operator_explain(command, a->runtime_dir, status);
    return EXIT_FAILED;
}

static int run_command(const char *command, const char *doc, int32_t timeout_ms, int argc,
                       char **argv)
{
    const struct argp argp = {.parser = parse_option, .doc = doc, .children = children};
    static char text[TEXT_BYTES];
    arguments a = {0};
    if (command_line_parse(&argp, NULL, argc, argv, &a))
        return EXIT_USAGE;
    const int result = give(command, &a, timeout_ms, text);
    if (result == EXIT_GOOD)
        printf("%s\n", text);
    return result;
}

int command_reload(int argc, char **argv)
{
    return run_command(
        "reload",
        "Lets the daemon read its configuration and robots again, as SIGHUP, and waits for "
        "the outcome.",
        RELOAD_MS, argc, argv);
}

int command_stop(int argc, char **argv)
{
    return run_command("stop", "Stops the daemon, as SIGTERM.", 0, argc, argv);
}

/* ---- status as text ---- */

static json_int_t integer(const json_t *object, const char *key)
{
    return json_integer_value(json_object_get(object, key));
}

static const char *string(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* Other daemons may serve the robot over DDS, too. */
static void print_leadership(const json_t *leadership)
{
    if (leadership)
        printf(", dds (%s, epoch %" JSON_INTEGER_FORMAT ", %" JSON_INTEGER_FORMAT " peers)",
               string(leadership, "role"), integer(leadership, "epoch"),
               integer(leadership, "peers"));
}

static void print_robots(const json_t *robots)
{
    size_t i;
    json_t *r;
    printf("%-24s %6s %8s  %-16s %s\n", "robot", "joints", "freedoms", "model", "served by");
    json_array_foreach(robots, i, r)
    {
        printf("%-24s %6" JSON_INTEGER_FORMAT " %8" JSON_INTEGER_FORMAT "  %-16.16s shared memory",
               string(r, "name"), integer(r, "joints"), integer(r, "freedoms"), string(r, "model"));
        print_leadership(json_object_get(r, "leadership"));
        puts(json_is_true(json_object_get(r, "specialised")) ? "; specialised kernel" : "");
    }
}

static void print_clients(const json_t *clients)
{
    size_t i;
    json_t *c;
    printf("\n%-24s %8s %6s %12s %9s %9s %12s\n", "client of", "process", "user", "requests",
           "rejected", "late", "busy ms");
    json_array_foreach(clients, i, c) printf(
        "%-24s %8" JSON_INTEGER_FORMAT " %6" JSON_INTEGER_FORMAT " %12" JSON_INTEGER_FORMAT
        " %9" JSON_INTEGER_FORMAT " %9" JSON_INTEGER_FORMAT " %12.1f\n",
        string(c, "robot"), integer(c, "process"), integer(c, "user"), integer(c, "requests"),
        integer(c, "rejected"), integer(c, "late"), 1e-3 * (double)integer(c, "busy_us"));
}

/* One line of a group of counters, in the order of the JSON. */
static void print_counters(const char *name, json_t *counters)
{
    const char *key;
    json_t *value;
    if (!counters)
        return;
    printf("\n%s:", name);
    json_object_foreach(counters, key, value)
        printf(" %s %" JSON_INTEGER_FORMAT, key, json_integer_value(value));
}

static int print_status(const char *text)
{
    json_t *status = json_loads(text, 0, NULL);
    if (!status) {
        fprintf(stderr, "totalforce status: the answer is not JSON\n");
        return EXIT_FAILED;
    }
    printf("totalforced %s, process %" JSON_INTEGER_FORMAT ", up %.0f s, %zu workers\n\n",
           string(status, "version"), integer(status, "process"),
           json_real_value(json_object_get(status, "seconds")),
           json_array_size(json_object_get(status, "workers")));
    print_robots(json_object_get(status, "robots"));
    if (json_array_size(json_object_get(status, "clients")))
        print_clients(json_object_get(status, "clients"));
    print_counters("dds", json_object_get(status, "dds"));
    print_counters("clients that left", json_object_get(status, "totals"));
    printf("\n");
    json_decref(status);
    return EXIT_GOOD;
}

int command_status(int argc, char **argv)
{
    const struct argp argp = {.options = status_options,
                              .parser = parse_option,
                              .doc = "Shows robots, clients and counters of a running daemon.",
                              .children = children};
    static char text[TEXT_BYTES];
    arguments a = {0};
    if (command_line_parse(&argp, NULL, argc, argv, &a))
        return EXIT_USAGE;
    const int result = give("status", &a, 0, text);
    if (result != EXIT_GOOD || !a.json)
        return result == EXIT_GOOD ? print_status(text) : result;
    fputs(text, stdout);
    return EXIT_GOOD;
}
