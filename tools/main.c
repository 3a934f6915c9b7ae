/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce`: picks the subcommand.
 */
#include "command_line/command_line.h"
#include "common/commands.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/dynamics.h>
#include <totalforce/text.h>
#include <totalforce/version.h>
#include <unistd.h>

/* X(name, padding of the list in --help, what it does) */
#define COMMAND_LIST(X)                                                                            \
    X(model, "       ", "load a URDF and report the result")                                       \
    X(solve, "       ", "answer JSON lines from standard input, in process")                       \
    X(call, "        ", "answer the same JSON lines through a running daemon")                     \
    X(latency, "     ", "measure a running daemon's round trips")                                  \
    X(status, "      ", "show robots, clients and counters of a running daemon")                   \
    X(list, "        ", "list robots of a running daemon: model, kernel, sockets and topics")      \
    X(top, "         ", "show rates and latencies of a running daemon, live")                      \
    X(reload, "      ", "let a running daemon read its configuration again")                       \
    X(stop, "        ", "stop a running daemon")                                                   \
    X(record, "      ", "record a robot's requests and answers at a running daemon")               \
    X(replay, "      ", "play a recording again and compare the answers")                          \
    X(methods, "     ", "list the methods, their cost and refusals")                               \
    X(chain, "       ", "write a test mechanism as URDF")                                          \
    X(specialise, "  ", "compile a kernel specialised for one robot")

/* The same of programs totalforce-NAME, which tools/python has. */
#define EXTERNAL_LIST(X)                                                                           \
    X(beam, "        ", "modes of a beam, for a flexible link")                                    \
    X(chart, "       ", "chart accuracy against speed")                                            \
    X(atlas, "       ", "map failures of methods, and the answers of the service there")           \
    X(drift, "       ", "energy of a freely swinging robot over simulated time")                   \
    X(plot, "        ", "draw saved sessions of latency, and compare them")                        \
    X(sweep, "       ", "one operation for many states, on many cores and machines")               \
    X(web, "         ", "live page and Prometheus metrics of a running daemon")

static const struct {
    const char *name, *what;
    int (*run)(int argc, char **argv); /* NULL: a program of its own */
} commands[] = {
#define COMMAND(name, pad, what) {#name, what, command_##name},
    COMMAND_LIST(COMMAND)
#undef COMMAND
#define EXTERNAL(name, pad, what) {#name, what, NULL},
        EXTERNAL_LIST(EXTERNAL)
#undef EXTERNAL
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static const char documentation[] =
    "Rigid-body dynamics: forward and inverse dynamics, mass matrix, operational-space inertia.\v"
    "Commands:\n"
#define COMMAND(name, pad, what) "  " #name pad what "\n"
    COMMAND_LIST(COMMAND) EXTERNAL_LIST(COMMAND)
#undef COMMAND
        "\n`totalforce help COMMAND` tells more, and so does `totalforce COMMAND -h`. Exit status: "
        "0 good, 1 an expectation was not "
        "met, "
        "2 failure, 3 wrong command line.";

/* The word that names the command ends the options of the main program. */
typedef struct choice {
    int at; /* its place in argv */
} choice;

static error_t parse(int key, char *text, struct argp_state *state)
{
    choice *chosen = state->input;
    (void)text;
    switch (key) {
    case ARGP_KEY_ARG:
        chosen->at = state->next - 1;
        state->next = state->argc;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_usage(state);
        return EINVAL;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void print_version(FILE *out, struct argp_state *state)
{
    (void)state;
    fprintf(out, "totalforce %s (kernels: %s)\n", TFA_VERSION, tfa_isa_name());
}

/* Becomes totalforce-NAME, from the folder of this program or else from PATH.
 * @return an exit status */
static int run_program(const char *name, char **argv)
{
    char path[PATH_MAX + 64];
    const ssize_t length = readlink("/proc/self/exe", path, PATH_MAX);
    path[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(path, '/');
    char *program = slash ? slash + 1 : path;
    snprintf(program, 64, "totalforce-%s", name);
    execv(path, argv);
    if (errno == ENOENT)
        execvp(program, argv);
    if (errno == ENOENT)
        fprintf(stderr,
                "totalforce: %s is the program %s, which is not installed: install the package "
                "totalforce-tools-python\n",
                name, program);
    else
        fprintf(stderr, "totalforce: %s: %s\n", program, strerror(errno));
    return EXIT_FAILED;
}

static int run(int index, int argc, char **argv)
{
    if (!commands[index].run)
        return run_program(commands[index].name, argv);
    char *name = NULL;
    if (asprintf(&name, "%s %s", program_invocation_short_name, commands[index].name) < 0)
        return EXIT_FAILED;
    argv[0] = name;
    int status = commands[index].run(argc, argv);
    free(name);
    return status;
}

static const char *command_name(const void *unused, size_t index)
{
    (void)unused;
    return index < COMMAND_COUNT ? commands[index].name : "help";
}

/* @return its number, -1 after a message */
static int find_command(const char *name)
{
    char suggestions[120];
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(commands[i].name, name) == 0)
            return i;
    tfa_suggest(name, NULL, COMMAND_COUNT + 1, command_name, suggestions, sizeof suggestions);
    fprintf(stderr, "totalforce: no command '%s'; nearest: %s; `totalforce --help` lists them\n",
            name, suggestions);
    return -1;
}

/* -h is --help, as everywhere else; argp knows -? only. */
static void expand_help(int argc, char **argv)
{
    static char help[] = "--help";
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++)
        if (strcmp(argv[i], "-h") == 0)
            argv[i] = help;
}

/* `help` is the program's --help, `help COMMAND` the command's: put so in place. */
static void move_help_first(int *argc, char **argv)
{
    static char help[] = "--help";
    if (*argc < 2 || strcmp(argv[1], "help") != 0)
        return;
    *argc = *argc > 2 ? 3 : 2;
    argv[1] = *argc > 2 ? argv[2] : help;
    argv[*argc - 1] = help;
}

/* A misspelt TFA_ISA is an error, not the default. */
static bool has_kernels(void)
{
    char names[64];
    if (strcmp(tfa_isa_name(), "none") != 0)
        return true;
    tfa_isa_names(names, sizeof names);
    fprintf(
        stderr,
        "totalforce: TFA_ISA=%s: no instruction set of this library and processor; one of: %s\n",
        getenv("TFA_ISA"), names);
    return false;
}

/* For the programs that write man pages and completion. @return an exit status */
static int print_options(const struct argp *argp)
{
    command_line_print(argp, NULL, stdout);
    for (int i = 0; i < COMMAND_COUNT; i++)
        printf("command\t%s\t%s\n", commands[i].name, commands[i].what);
    return fflush(stdout) == 0 ? EXIT_GOOD : EXIT_FAILED;
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse, .args_doc = "COMMAND [OPTION...]", .doc = documentation};
    choice chosen = {0};
    argp_err_exit_status = EXIT_USAGE;
    argp_program_version_hook = print_version;
    /* a reader that goes away is an error of fflush, not the end of the program */
    signal(SIGPIPE, SIG_IGN);
    if (command_line_asks(argc, argv, "--print-options"))
        return print_options(&argp);
    move_help_first(&argc, argv);
    expand_help(argc, argv);
    error_t error = argp_parse(&argp, argc, argv, ARGP_IN_ORDER, NULL, &chosen);
    if (error) {
        fprintf(stderr, "totalforce: %s\n", strerror(error));
        return EXIT_USAGE;
    }
    const int command = find_command(argv[chosen.at]);
    return command < 0 || !has_kernels() ? EXIT_USAGE
                                         : run(command, argc - chosen.at, argv + chosen.at);
}
