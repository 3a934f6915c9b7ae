/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A process that serves the test robots over DDS: the gateway of the daemon and what stands behind
 * it.
 */
#include "gateway_process.h"

#include "dds/common/dds_domain.h"
#include "dds/topics/dds.h"
#include "dds_test.h"
#include "herald.h"
#include "robots.h"
#include "test_worker.h"
#include "worker/local_client.h"

#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static tfa_shared_dds messages;

/* ---- what a reload does that finds no entry at the worker ---- */

static tfa_local_client fillers[TFA_WORKER_CLIENTS_MAX];

static void take_all_entries(struct tfa_worker *worker)
{
    for (uint32_t i = 0; i < TFA_WORKER_CLIENTS_MAX; i++)
        if (tfa_local_client_open(worker, 0, 1, 1, &fillers[i]) != TFA_OK)
            return;
}

/* The robot gets its model again, with or without an entry. Prints the status. */
static void reload(tfa_dds *gateway, struct tfa_worker *worker, const tfa_model *model, bool full)
{
    while (!tfa_dds_detach(gateway, 0))
        sleep_ms(1);
    if (full)
        take_all_entries(worker);
    for (uint32_t i = 0; !full && i < TFA_WORKER_CLIENTS_MAX; i++)
        tfa_local_client_close(&fillers[i]);
    printf("%d\n", tfa_dds_announce(gateway, 0, model));
    fflush(stdout);
}

/* SIGUSR1: a reload, every other one without an entry; SIGUSR2: answers are held, or not. */
static void obey(tfa_dds *gateway, struct tfa_worker *worker, const tfa_model *model,
                 const siginfo_t *order)
{
    static bool full;
    if (order->si_signo == SIGUSR1) {
        reload(gateway, worker, model, full = !full);
        return;
    }
    test_worker_hold(order->si_value.sival_int);
    printf("%lu\n", (unsigned long)atomic_load(&messages.rejected));
    fflush(stdout);
}

static int serve(uint32_t domain, uint32_t delay_us, uint32_t slots, uint32_t max_age_ms)
{
    test_robot robots[TEST_ROBOTS];
    tfa_robot served[TEST_ROBOTS];
    tfa_dds *gateway;
    sigset_t orders;
    siginfo_t order;
    sigemptyset(&orders);
    sigaddset(&orders, SIGTERM);
    sigaddset(&orders, SIGUSR1);
    sigaddset(&orders, SIGUSR2);
    sigprocmask(SIG_BLOCK, &orders, NULL);
    test_robots_make(robots);
    for (uint32_t i = 0; i < TEST_ROBOTS; i++) {
        served[i] = (tfa_robot){.model = robots[i].model, .shape.max_batch = TEST_BATCH};
        snprintf(served[i].name, sizeof served[i].name, "%s", robots[i].name);
    }
    const config settings = {
        .dds = {.domain = domain, .lease_ms = TEST_LEASE_MS, .max_age_ms = max_age_ms}};
    const gateway_context context = {
        .settings = &settings, .robots = served, .messages = &messages};
    if (tfa_dds_create(&context, TEST_ROBOTS, NULL, slots, &gateway) != TFA_OK) {
        fprintf(stderr, "gateway: %s\n", tfa_dds_error());
        return 4;
    }
    struct tfa_worker *worker = test_worker_start(robots, delay_us);
    if (worker == NULL || tfa_dds_start(gateway, worker, test_gateway_solvers()) != TFA_OK)
        return 5;
    printf("ready\n");
    fflush(stdout);
    while (sigwaitinfo(&orders, &order) != SIGTERM)
        obey(gateway, worker, robots[0].model, &order);
    tfa_dds_stop(gateway);
    test_worker_stop(worker);
    printf("dropped %lu, handovers %lu\n", (unsigned long)atomic_load(&messages.dropped),
           (unsigned long)atomic_load(&messages.handovers));
    for (uint32_t i = 0; i < TEST_ROBOTS; i++)
        tfa_model_free(robots[i].model);
    return 0;
}

void test_daemon_main(int argc, char **argv)
{
    if (argc != 6 || strcmp(argv[1], "serve") != 0)
        return;
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that crashes leaves nobody behind */
    exit(serve((uint32_t)atoi(argv[2]), (uint32_t)atoi(argv[3]), (uint32_t)atoi(argv[4]),
               (uint32_t)atoi(argv[5])));
}

static void read_line(int fd, char *line, size_t size)
{
    size_t length = 0;
    while (length + 1 < size && read(fd, line + length, 1) == 1 && line[length] != '\n')
        length++;
    line[length] = '\0';
}

/* The one that runs; a test that failed may have left it. */
static pid_t running;

static void kill_running(void)
{
    if (running <= 0)
        return;
    kill(running, SIGKILL);
    waitpid(running, NULL, 0);
    running = 0;
}

test_daemon test_daemon_start(uint32_t domain, const test_daemon_options *options)
{
    char numbers[4][16], line[32];
    char program[] = "/proc/self/exe", verb[] = "serve";
    char *argv[] = {program, verb, numbers[0], numbers[1], numbers[2], numbers[3], NULL};
    test_daemon daemon;
    posix_spawn_file_actions_t actions;
    int ends[2];
    snprintf(numbers[0], sizeof numbers[0], "%u", domain);
    snprintf(numbers[1], sizeof numbers[1], "%u", options != NULL ? options->delay_us : 0);
    snprintf(numbers[2], sizeof numbers[2], "%u", options != NULL ? options->slots : 0);
    snprintf(numbers[3], sizeof numbers[3], "%u", options != NULL ? options->max_age_ms : 0);
    kill_running();
    assert_int_equal(pipe(ends), 0);
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    assert_int_equal(posix_spawn(&daemon.pid, program, &actions, NULL, argv, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    running = daemon.pid;
    close(ends[1]);
    daemon.out = ends[0];
    read_line(daemon.out, line, sizeof line);
    assert_string_equal(line, "ready");
    dds_herald(domain, "arm");
    dds_herald(domain, "four.closed");
    return daemon;
}

int test_daemon_reload(const test_daemon *daemon)
{
    char line[32];
    assert_int_equal(kill(daemon->pid, SIGUSR1), 0);
    read_line(daemon->out, line, sizeof line);
    return atoi(line);
}

unsigned long test_daemon_hold(const test_daemon *daemon, bool hold)
{
    char line[32];
    assert_int_equal(sigqueue(daemon->pid, SIGUSR2, (union sigval){.sival_int = hold}), 0);
    read_line(daemon->out, line, sizeof line);
    return strtoul(line, NULL, 10);
}

unsigned long test_daemon_stop(test_daemon *daemon)
{
    char line[64];
    int status;
    unsigned long dropped = 0;
    assert_int_equal(kill(daemon->pid, SIGTERM), 0);
    assert_int_equal(waitpid(daemon->pid, &status, 0), daemon->pid);
    running = 0;
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    read_line(daemon->out, line, sizeof line);
    assert_int_equal(sscanf(line, "dropped %lu, handovers %lu", &dropped, &daemon->handovers), 2);
    close(daemon->out);
    return dropped;
}
