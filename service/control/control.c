/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The control thread: sockets, signals, the passing of time. Not real-time.
 */
#include "control/daemon.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "ipc/control_socket.h"
#include "platform/log.h"
#include "platform/passed_sockets.h"

#define EVENTS 64
#define TICK_MS 50       /* how late a broken protocol is noticed */
#define DETACH_TICK_MS 1 /* how late a client is detached; the worker must not signal for it */
#define IDLE_TICK_MS 500 /* without clients */
#define NICE 5           /* workers come first where processors are short */
#define RUNTIME_DIR_LOOK_NS 1000000000u

uint64_t control_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* ---- opening and closing ---- */

/* In epoll, sessions are pointers; a listener is the address of its entry in d->listeners, the
 * signals that of d->signals, the reload's event that of d->reload, and so on. */
static int watch_descriptor(const tfa_daemon *d, int fd, void *what)
{
    struct epoll_event event = {.events = EPOLLIN, .data.ptr = what};
    return epoll_ctl(d->epoll, EPOLL_CTL_ADD, fd, &event);
}

int control_open(tfa_daemon *d)
{
    d->start = control_clock();
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGHUP);
    sigaddset(&set, SIGUSR1);
    d->epoll = epoll_create1(EPOLL_CLOEXEC);
    d->signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    d->reserve = open("/dev/null", O_RDONLY | O_CLOEXEC);
    d->reload.event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (d->epoll < 0 || d->signals < 0 || d->reserve < 0 || d->reload.event < 0)
        return TFA_E_SYSTEM;
    d->watchdog_ns = notify_watchdog_ns() / 2;
    if (watch_descriptor(d, d->signals, &d->signals) != 0)
        return TFA_E_SYSTEM;
    return watch_descriptor(d, d->reload.event, &d->reload) == 0 ? TFA_OK : TFA_E_SYSTEM;
}

int control_watch_descriptions(tfa_daemon *d)
{
    return watch_descriptor(d, d->descriptions.event, &d->descriptions) == 0 ? TFA_OK
                                                                             : TFA_E_SYSTEM;
}

static int listen_at(tfa_daemon *d, uint32_t i)
{
    const char *name = d->robot_set.robots[i].name;
    d->listeners[i] = tfa_runtime_dir_listen(&d->runtime_dir, name);
    if (d->listeners[i] >= 0 && watch_descriptor(d, d->listeners[i], &d->listeners[i]) == 0)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "socket '%s/%s.sock': %s", d->runtime_dir.path, name,
            errno == EADDRINUSE ? "another program listens there; choose another runtime_dir"
                                : strerror(errno));
    return TFA_E_SYSTEM;
}

static int make_listeners(tfa_daemon *d)
{
    if (d->listeners)
        return TFA_OK;
    d->listeners = malloc(d->robot_set.count * sizeof *d->listeners);
    for (uint32_t i = 0; d->listeners && i < d->robot_set.count; i++)
        d->listeners[i] = -1;
    return d->listeners ? TFA_OK : TFA_E_MEMORY;
}

int control_listen(tfa_daemon *d)
{
    const uint32_t count = d->robot_set.count;
    const char **names = calloc(count, sizeof *names);
    int status = names ? make_listeners(d) : TFA_E_MEMORY;
    for (uint32_t i = 0; i < count && status == TFA_OK; i++) {
        status = d->listeners[i] >= 0 ? TFA_OK : listen_at(d, i);
        names[i] = d->robot_set.robots[i].name;
    }
    if (status == TFA_OK && d->command_listener < 0)
        status = commands_listen(d);
    if (status == TFA_OK) {
        tfa_runtime_dir_ready(&d->runtime_dir, names, count);
        tfa_log(TFA_LOG_INFO, "shared memory: %u robots: %s/ROBOT.sock; commands: %s/%s.sock",
                count, d->runtime_dir.path, d->runtime_dir.path, TFA_CONTROL_NAME);
    }
    free(names);
    return status;
}

static void unlisten_at(tfa_daemon *d, uint32_t i)
{
    if (d->listeners[i] < 0)
        return;
    tfa_runtime_dir_unlink(&d->runtime_dir, d->robot_set.robots[i].name);
    close(d->listeners[i]);
    d->listeners[i] = -1;
}

void control_close_listeners(tfa_daemon *d)
{
    if (d->listeners)
        tfa_runtime_dir_closing(&d->runtime_dir);
    commands_unlisten(d);
    for (uint32_t i = 0; d->listeners && i < d->robot_set.count; i++)
        unlisten_at(d, i);
    free(d->listeners);
    d->listeners = NULL;
}

static bool is_passed(const tfa_daemon *d, uint32_t robot)
{
    return d->listeners[robot] >= 0 && tfa_passed_socket_is(d->robot_set.robots[robot].name);
}

/* The service manager's sockets stay open: it would listen at them without a daemon otherwise. */
static void leave_runtime_dir(tfa_daemon *d)
{
    if (!tfa_passed_socket_is(TFA_CONTROL_NAME))
        commands_unlisten(d);
    for (uint32_t i = 0; d->listeners && i < d->robot_set.count; i++)
        if (!is_passed(d, i))
            unlisten_at(d, i);
    tfa_runtime_dir_release(&d->runtime_dir);
}

static void log_removal(const tfa_daemon *d)
{
    const char *path = d->settings->runtime_dir;
    tfa_log(TFA_LOG_ERROR, "runtime directory '%s' was removed: it is made again", path);
    for (uint32_t i = 0; d->listeners && i < d->robot_set.count; i++)
        if (is_passed(d, i))
            tfa_log(TFA_LOG_ERROR,
                    "socket '%s/%s.sock', which the service manager passed, is gone: nobody can "
                    "connect; stop the service, then restart its socket unit",
                    path, d->robot_set.robots[i].name);
}

/* A runtime directory that was removed is made again; clients that are connected notice nothing. */
static void watch_runtime_dir(tfa_daemon *d)
{
    const uint64_t now = control_clock();
    if (now - d->runtime_dir_looked < RUNTIME_DIR_LOOK_NS)
        return;
    d->runtime_dir_looked = now;
    if (tfa_runtime_dir_is_there(&d->runtime_dir))
        return;
    log_removal(d);
    leave_runtime_dir(d);
    if (tfa_runtime_dir_acquire(&d->runtime_dir, d->settings->runtime_dir) != TFA_OK ||
        control_listen(d) != TFA_OK)
        leave_runtime_dir(d); /* until the next look */
}

void control_close(tfa_daemon *d)
{
    commands_close(d);
    if (d->epoll >= 0)
        close(d->epoll);
    if (d->signals >= 0)
        close(d->signals);
    if (d->reserve >= 0)
        close(d->reserve);
    if (d->reload.event >= 0)
        close(d->reload.event);
}

/* ---- events ---- */

/* No descriptor left: the one in reserve lets us take the connection and hang up, or the listener
 * would stay ready for ever. */
static void reject_connection(tfa_daemon *d, int listener)
{
    tfa_log_client(TFA_LOG_WARNING, "no descriptors left: a client was turned away");
    close(d->reserve);
    int fd = accept4(listener, NULL, NULL, SOCK_CLOEXEC);
    if (fd >= 0)
        close(fd);
    d->reserve = open("/dev/null", O_RDONLY | O_CLOEXEC);
    tfa_counter_add(&d->statistics.header->refused, 1);
}

int control_accept(tfa_daemon *d, int listener)
{
    const int fd = accept4(listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0 && (errno == EMFILE || errno == ENFILE))
        reject_connection(d, listener);
    return fd;
}

static void accept_client(tfa_daemon *d, uint32_t robot)
{
    const int fd = control_accept(d, d->listeners[robot]);
    if (fd >= 0)
        session_begin(d, robot, fd);
}

static uint64_t value_of(const tfa_counter *word)
{
    return atomic_load_explicit(word, memory_order_relaxed);
}

static void log_dds_totals(const tfa_daemon *d)
{
    const tfa_shared_dds *c = &d->statistics.header->dds_messages;
    tfa_log(TFA_LOG_INFO,
            "dds: requests %llu, torques %llu, replies %llu, rejected %llu, late %llu, dropped "
            "%llu, handovers %llu, unknown robots %llu, standby %llu",
            (unsigned long long)value_of(&c->requests), (unsigned long long)value_of(&c->torques),
            (unsigned long long)value_of(&c->replies), (unsigned long long)value_of(&c->rejected),
            (unsigned long long)value_of(&c->late), (unsigned long long)value_of(&c->dropped),
            (unsigned long long)value_of(&c->handovers), (unsigned long long)value_of(&c->unknown),
            (unsigned long long)value_of(&c->standby));
}

/* Requests and rejected ones of all transports. */
static void log_totals(const tfa_daemon *d)
{
    const tfa_tally_sums all = statistics_all(d);
    if (d->gateways[TFA_SOURCE_DDS].self)
        log_dds_totals(d);
    tfa_log(TFA_LOG_INFO,
            "clients %u, connections %llu, refused %llu, requests %llu, rejected %llu",
            d->session_count, (unsigned long long)value_of(&d->statistics.header->connections),
            (unsigned long long)value_of(&d->statistics.header->refused),
            (unsigned long long)all.requests, (unsigned long long)all.rejected);
}

static void read_signals(tfa_daemon *d)
{
    struct signalfd_siginfo info;
    while (read(d->signals, &info, sizeof info) == (ssize_t)sizeof info) {
        switch (info.ssi_signo) {
        case SIGHUP:
            reload_request(d);
            break;
        case SIGUSR1:
            log_totals(d);
            break;
        default:
            d->stop = true;
            break;
        }
    }
}

static void dispatch(tfa_daemon *d, void *what)
{
    if (what == &d->signals) {
        read_signals(d);
        return;
    }
    if (what == &d->reload) {
        reload_event(d);
        return;
    }
    if (what == &d->descriptions) {
        reload_described(d);
        return;
    }
    if (what == &d->command_listener) {
        commands_accept(d);
        return;
    }
    if (commands_event(d, what) || recordings_event(d, what))
        return;
    const int *entry = what;
    for (uint32_t i = 0; d->listeners && i < d->robot_set.count; i++)
        if (entry == &d->listeners[i]) {
            accept_client(d, i);
            return;
        }
    session_event(d, what);
}

/* ---- time ---- */

/* The watchdog of the service manager is fed only if every worker has made progress since the
 * last time; one that sleeps is woken to show it. */
static void watch_workers(tfa_daemon *d)
{
    const uint64_t now = control_clock();
    bool all = true;
    if (!d->watchdog_ns || now - d->watchdog_last < d->watchdog_ns / 2)
        return;
    for (uint32_t i = 0; i < d->settings->workers; i++) {
        daemon_worker *w = &d->workers[i];
        const uint64_t beat = tfa_worker_heartbeat(w->worker);
        all = all && beat != w->last_heartbeat;
        w->last_heartbeat = beat;
        tfa_worker_wake(w->worker);
    }
    d->watchdog_last = now;
    if (all)
        notify_watchdog();
}

static int tick_ms(const tfa_daemon *d)
{
    int ms = IDLE_TICK_MS;
    if (d->session_count)
        ms = session_any_detaching(d) ? DETACH_TICK_MS : TICK_MS;
    if (reload_is_urgent(d) || recordings_any_ending(d))
        ms = DETACH_TICK_MS;
    const uint64_t watchdog = d->watchdog_ns / 4 / 1000000;
    return d->watchdog_ns && watchdog < (uint64_t)ms ? (int)watchdog : ms;
}

void control_run(tfa_daemon *d)
{
    struct epoll_event events[EVENTS];
    (void)setpriority(PRIO_PROCESS, 0, NICE); /* on Linux: of this thread */
    while (!d->stop) {
        int n = epoll_wait(d->epoll, events, EVENTS, tick_ms(d));
        for (int i = 0; i < n; i++)
            dispatch(d, events[i].data.ptr);
        /* sessions end here or in their own event, so no event of this batch met a dead one */
        session_tick(d);
        reload_tick(d);
        commands_tick(d);
        recordings_tick(d);
        watch_workers(d);
        watch_runtime_dir(d);
    }
    log_totals(d);
}
