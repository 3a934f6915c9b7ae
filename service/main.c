/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * totalforced: answers robot-dynamics requests over shared memory and DDS.
 */
#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/version.h>
#include <unistd.h>

#include "command_line/command_line.h"
#include "control/daemon.h"
#include "platform/check_rt.h"
#include "platform/log.h"
#include "platform/passed_sockets.h"
#include "platform/realtime.h"
#include "platform/runtime_dir.h"
#include "platform/sigbus.h"

enum { EXIT_GOOD = 0, EXIT_UNMET = 1, EXIT_FAILED = 2, EXIT_USAGE = 3 };

typedef struct arguments {
    const char *file;
    bool check_configuration, check_realtime, dump;
} arguments;

/* All that start-up takes, in order; stop_all gives it back in the opposite order. */
typedef struct service {
    tfa_daemon daemon;
    uid_t user;
    gid_t user_group;
} service;

/* ---- the steps ---- */

/* Every thread inherits this: signals are read by the control thread alone. */
static int block_signals(service *s)
{
    sigset_t set;
    (void)s;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGHUP);
    sigaddset(&set, SIGUSR1);
    signal(SIGPIPE, SIG_IGN);
    return pthread_sigmask(SIG_BLOCK, &set, NULL) == 0 ? TFA_OK : TFA_E_SYSTEM;
}

static int start_log(service *s)
{
    return tfa_log_start((tfa_log_level)s->daemon.settings->log_level);
}

static int find_identity(service *s)
{
    const int status =
        tfa_identity_find(s->daemon.settings, &s->user, &s->user_group, &s->daemon.group);
    return status == TFA_OK ? tfa_admission_load(s->daemon.settings, &s->daemon.admission) : status;
}

static int acquire_runtime_dir(service *s)
{
    tfa_runtime_dir *dir = &s->daemon.runtime_dir;
    dir->user = s->user;
    dir->user_group = s->user_group;
    dir->socket_group = s->daemon.group;
    const int status = tfa_runtime_dir_acquire(dir, s->daemon.settings->runtime_dir);
    return status == TFA_OK ? tfa_passed_sockets_take(dir->directory, dir->path) : status;
}

static int guard_memory(service *s)
{
    tfa_realtime_raise_files();
    tfa_realtime_populate();
    tfa_realtime_lock(&s->daemon.settings->realtime);
    /* the descriptor stays open until the process ends */
    (void)tfa_realtime_limit_idle_states(&s->daemon.settings->realtime, TFA_CPU_DMA_LATENCY);
    return tfa_sigbus_install();
}

static int load_robots(service *s)
{
    return robot_set_load(s->daemon.settings, NULL, &s->daemon.robot_set);
}

static int make_statistics(service *s)
{
    return statistics_open(&s->daemon);
}

static int join_domains(service *s)
{
    return gateways_join(&s->daemon);
}

static int start_pool(service *s)
{
    return daemon_start_pool(&s->daemon);
}

static int prepare_robots(service *s)
{
    return daemon_prepare_robots(&s->daemon);
}

static int start_workers(service *s)
{
    return daemon_start_workers(&s->daemon);
}

static int drop_privileges(service *s)
{
    if (s->user == (uid_t)-1)
        return TFA_OK;
    return tfa_identity_become(s->user, s->user_group, s->daemon.group);
}

static int self_test(service *s)
{
    return daemon_self_test(&s->daemon);
}

static int open_descriptions(service *s)
{
    const int status = descriptions_open(&s->daemon);
    return status == TFA_OK ? control_watch_descriptions(&s->daemon) : status;
}

static int start_gateways(service *s)
{
    return gateways_start(&s->daemon);
}

static int open_control(service *s)
{
    return control_open(&s->daemon);
}

static int open_sockets(service *s)
{
    const int status = control_listen(&s->daemon);
    return status == TFA_OK ? tfa_passed_sockets_check() : status;
}

static int signal_ready(service *s)
{
    tfa_log(TFA_LOG_INFO, "ready: %u robots, %u workers, %s", s->daemon.robot_set.count,
            s->daemon.settings->workers, s->daemon.settings->runtime_dir);
    notify_ready();
    return TFA_OK;
}

/* The order of start-up. Each line depends on those above it. */
static const struct {
    const char *name;
    int (*step)(service *s);
} start_up[] = {
    {"signals", block_signals},
    {"log thread", start_log},
    {"user and group", find_identity},
    {"runtime directory", acquire_runtime_dir},
    {"memory", guard_memory},
    {"control", open_control},
    {"robots", load_robots},
    {"statistics", make_statistics},
    {"dds domains", join_domains}, /* before the workers: its threads inherit priorities */
    {"pool", start_pool},
    {"pools and times of robots", prepare_robots},
    {"workers", start_workers},
    {"privileges", drop_privileges}, /* after priorities and locks are held */
    {"self-test", self_test},
    {"robot descriptions", open_descriptions},
    {"dds", start_gateways},
    {"sockets", open_sockets},
    {"ready", signal_ready},
};

/* A thread still reads and logs. Nothing stays behind but memory, which the system takes. */
__attribute__((noreturn)) static void end_at_once(service *s)
{
    tfa_runtime_dir_release(&s->daemon.runtime_dir);
    tfa_log_finish();
    _exit(EXIT_GOOD);
}

static void stop_all(service *s)
{
    notify_stopping();
    control_close_listeners(&s->daemon);
    gateways_stop(&s->daemon);       /* their requests need the workers */
    daemon_stop_workers(&s->daemon); /* they answer the requests in the rings */
    recordings_close(&s->daemon);
    session_end_all(&s->daemon);
    if (!reload_abandon(&s->daemon)) /* a large robot is being read: its thread uses the rest */
        end_at_once(s);
    daemon_free_robot_set(&s->daemon);
    descriptions_close(&s->daemon);
    tfa_admission_free(&s->daemon.admission);
    control_close(&s->daemon);
    statistics_close(&s->daemon);
    tfa_runtime_dir_release(&s->daemon.runtime_dir);
    tfa_passed_sockets_forget();
    config_free(s->daemon.settings);
    tfa_log_stop();
}

/* Takes the configuration over: a reload may put another in its place. */
static int serve(config *settings)
{
    service s = {.daemon = {.settings = settings,
                            .epoll = -1,
                            .signals = -1,
                            .reserve = -1,
                            .reload.event = -1,
                            .descriptions = {.event = -1, .mutex = PTHREAD_MUTEX_INITIALIZER},
                            .group = (gid_t)-1,
                            .statistics_segment = TFA_SEGMENT_NONE,
                            .runtime_dir = TFA_RUNTIME_DIR_NONE},
                 .user = (uid_t)-1};
    int status = TFA_OK;
    commands_open(&s.daemon); /* a start that fails at once ends like any other */
    for (size_t i = 0; i < sizeof start_up / sizeof *start_up && status == TFA_OK; i++) {
        errno = 0;
        status = start_up[i].step(&s);
        if (status == TFA_E_SYSTEM && errno)
            tfa_log(TFA_LOG_ERROR, "start-up: %s: %s", start_up[i].name, strerror(errno));
        else if (status != TFA_OK)
            tfa_log(TFA_LOG_ERROR, "start-up: %s: %s", start_up[i].name, tfa_status_text(status));
    }
    if (status == TFA_OK)
        control_run(&s.daemon);
    stop_all(&s);
    return status == TFA_OK ? EXIT_GOOD : EXIT_FAILED;
}

static int check_runtime_dir(const config *settings)
{
    uid_t user;
    gid_t user_group, group;
    char text[512], location[512];
    int status = tfa_identity_find(settings, &user, &user_group, &group);
    if (status == TFA_OK)
        status = tfa_runtime_dir_check(settings->runtime_dir, user, text, sizeof text);
    config_location(settings, "runtime_dir", location, sizeof location);
    if (status == TFA_E_REFUSED)
        tfa_log(TFA_LOG_ERROR, "%s: runtime_dir: %s", location, text);
    return status;
}

/* Everything that a start or a reload would load. */
static int check_configuration(const config *settings)
{
    robot_set f;
    tfa_admission admission;
    const int identity = tfa_identity_check(settings);
    const int directory = identity == TFA_OK ? check_runtime_dir(settings) : TFA_OK;
    const int admitted = tfa_admission_load(settings, &admission);
    const int status = robot_set_load(settings, NULL, &f);
    const int joined = gateways_check(settings);
    if (settings->backend == CONFIG_BACKEND_SHM && !settings->user)
        tfa_log(TFA_LOG_INFO, "backend: shm; where clients run as the daemon's own user, memfd is "
                              "safer: its segments are sealed");
    if (admitted == TFA_OK)
        tfa_admission_free(&admission);
    if (status == TFA_OK)
        robot_set_unload(&f);
    const bool good = status == TFA_OK && identity == TFA_OK && directory == TFA_OK &&
                      admitted == TFA_OK && joined == TFA_OK;
    return good ? EXIT_GOOD : EXIT_FAILED;
}

static int check_realtime(const config *settings)
{
    const tfa_check_rt check = tfa_check_rt_here(settings);
    return tfa_check_rt_print(&check, stdout) ? EXIT_UNMET : EXIT_GOOD;
}

/* ---- the command line ---- */

enum { KEY_CHECK = 'n', KEY_CHECK_RT = 'r', KEY_DUMP = 'd' };

static const struct argp_option option_table[] = {
    {"check", KEY_CHECK, NULL, 0,
     "Check the configuration, its robots, runtime directory, user and group, and end: 0 good, 2 "
     "not",
     0},
    {"check-rt", KEY_CHECK_RT, NULL, 0,
     "Report how far this machine suits the configuration's real-time wishes, with remedies, and "
     "end: 0 good, 1 something cannot be had",
     0},
    {"dump-config", KEY_DUMP, NULL, 0, "Print the configuration in effect, explained, and end", 0},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    arguments *a = state->input;
    switch (key) {
    case KEY_CHECK:
        a->check_configuration = true;
        return 0;
    case KEY_CHECK_RT:
        a->check_realtime = true;
        return 0;
    case KEY_DUMP:
        a->dump = true;
        return 0;
    case ARGP_KEY_ARG:
        if (a->file)
            argp_error(state, "one configuration file, not two");
        a->file = text;
        return 0;
    case ARGP_KEY_NO_ARGS:
        if (!a->check_realtime) /* without wishes it tells the machine's properties */
            argp_error(state, "which configuration file?");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
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
        "totalforced: TFA_ISA=%s: no instruction set of this library and processor; one of: %s\n",
        getenv("TFA_ISA"), names);
    return false;
}

/* A socket or the lock file must not become a standard stream: messages would end in it. */
static bool open_standard_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) != fd)
            return false;
    return true;
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .options = option_table,
        .parser = parse_option,
        .args_doc = "CONFIG.yaml",
        .doc = "Serves the robots of a configuration file until SIGTERM. SIGHUP reads the file and "
               "the robots again; SIGUSR1 logs the counters."};
    static char help[] = "--help";
    arguments a = {0};
    config *settings;
    if (!open_standard_streams())
        return EXIT_FAILED;
    argp_program_version = "totalforced " TFA_VERSION;
    argp_err_exit_status = EXIT_USAGE;
    for (int i = 1; i < argc; i++) /* argp knows -? only */
        if (strcmp(argv[i], "-h") == 0)
            argv[i] = help;
    if (command_line_asks(argc, argv, "--print-keys"))
        return config_print_keys(stdout) == 0 ? EXIT_GOOD : EXIT_FAILED;
    error_t error = command_line_parse(&argp, NULL, argc, argv, &a);
    if (error || !has_kernels())
        return EXIT_USAGE;
    if (!a.file)
        return check_realtime(NULL);
    if (config_load(a.file, stderr, &settings) != TFA_OK)
        return EXIT_FAILED;
    if (!a.dump && !a.check_configuration && !a.check_realtime)
        return serve(settings);
    int result = EXIT_GOOD;
    if (a.dump)
        config_dump(settings, stdout);
    if (a.check_configuration)
        result = check_configuration(settings);
    if (a.check_realtime && result == EXIT_GOOD)
        result = check_realtime(settings);
    config_free(settings);
    return result;
}
