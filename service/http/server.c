/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The thread of the HTTP server, from its port to its end.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <poll.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "http/connections.h"
#include "platform/log.h"

#define BACKLOG 64
#define NICE 10 /* a tenth of a processor that somebody else needs */
#define NO_CHANGE (-2)

uint64_t http_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

int tfa_http_check(const config *settings)
{
    (void)settings;
    return TFA_OK;
}

/* ---- the port ---- */

typedef union http_socket_address {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
} http_socket_address;

static socklen_t set_address(const char *text, uint32_t port, http_socket_address *a)
{
    memset(a, 0, sizeof *a);
    if (inet_pton(AF_INET, text, &a->v4.sin_addr) == 1) {
        a->v4.sin_family = AF_INET;
        a->v4.sin_port = htons((uint16_t)port);
        return sizeof a->v4;
    }
    (void)inet_pton(AF_INET6, text, &a->v6.sin6_addr);
    a->v6.sin6_family = AF_INET6;
    a->v6.sin6_port = htons((uint16_t)port);
    return sizeof a->v6;
}

static int bind_port(int socket, const char *address, uint32_t *port)
{
    const int on = 1;
    http_socket_address a;
    socklen_t size = set_address(address, *port, &a);
    (void)setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(socket, &a.any, size) != 0 || listen(socket, BACKLOG) != 0 ||
        getsockname(socket, &a.any, &size) != 0)
        return TFA_E_SYSTEM;
    *port = ntohs(a.any.sa_family == AF_INET ? a.v4.sin_port : a.v6.sin6_port);
    return TFA_OK;
}

static void log_bind_error(const config *settings, const tfa_http *http, int error)
{
    char at[512];
    config_location(settings, error == EADDRNOTAVAIL ? "http.address" : "http.port", at, sizeof at);
    tfa_log(TFA_LOG_ERROR, "%s: http.port: %s port %u: %s; %s", at, http->address, http->port,
            strerror(error),
            error == EADDRINUSE      ? "choose a free one, or 0: the system chooses"
            : error == EACCES        ? "ports below 1024 need root"
            : error == EADDRNOTAVAIL ? "http.address must be one of this machine"
                                     : "choose another");
}

static int open_port(const config *settings, tfa_http *http)
{
    const int family = strchr(http->address, ':') ? AF_INET6 : AF_INET;
    http->listener = socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (http->listener >= 0 && bind_port(http->listener, http->address, &http->port) == TFA_OK)
        return TFA_OK;
    log_bind_error(settings, http, errno);
    errno = 0; /* it was told */
    return TFA_E_SYSTEM;
}

/* ---- making ---- */

/* Processors of workers and pool. */
static int copy_affinities(const config *settings, tfa_http *http)
{
    const size_t workers = settings->realtime.affinity_count, pool = settings->pool.affinity_count;
    http->avoid = calloc(workers + pool + 1, sizeof *http->avoid);
    if (!http->avoid)
        return TFA_E_MEMORY;
    for (size_t i = 0; i < workers; i++)
        http->avoid[http->avoid_count++] = settings->realtime.affinity[i];
    for (size_t i = 0; i < pool; i++)
        http->avoid[http->avoid_count++] = settings->pool.affinity[i];
    return TFA_OK;
}

static void free_http(tfa_http *http)
{
    if (http->listener >= 0)
        close(http->listener);
    if (http->metrics_listener >= 0)
        close(http->metrics_listener);
    const int next = atomic_load_explicit(&http->next_listener, memory_order_relaxed);
    if (next >= 0)
        close(next);
    if (http->wake >= 0)
        close(http->wake);
    for (uint32_t i = 0; i < http->robot_count; i++)
        figure_close(&http->figures[i]);
    free(http->figures);
    sampler_close(&http->sampler);
    free(http->avoid);
    free(http->address);
    free(http);
}

int tfa_http_listen(const config *settings, tfa_http **http)
{
    const config_http *c = &settings->http;
    *http = NULL;
    if (!c->enabled && !c->metrics_socket)
        return TFA_OK;
    tfa_http *made = calloc(1, sizeof *made);
    if (!made)
        return TFA_E_MEMORY;
    made->listener = made->metrics_listener = -1;
    atomic_init(&made->next_listener, NO_CHANGE);
    made->port = c->port;
    made->page = c->enabled;
    made->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    made->address = strdup(c->address ? c->address : CONFIG_HTTP_ADDRESS);
    int status = made->address ? copy_affinities(settings, made) : TFA_E_MEMORY;
    if (status == TFA_OK && made->wake < 0)
        status = TFA_E_SYSTEM;
    if (status == TFA_OK && made->page)
        status = open_port(settings, made);
    if (status != TFA_OK) {
        free_http(made);
        return status;
    }
    *http = made;
    return TFA_OK;
}

/* ---- the thread ---- */

static void leave_processors(const tfa_http *http)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return;
    for (size_t i = 0; i < http->avoid_count; i++)
        if (http->avoid[i] < CPU_SETSIZE)
            CPU_CLR(http->avoid[i], &set);
    if (CPU_COUNT(&set) > 0)
        (void)sched_setaffinity(0, sizeof set, &set);
}

static void lower_priority(const tfa_http *http)
{
    const struct sched_param ordinary = {0};
    (void)sched_setscheduler(0, SCHED_OTHER, &ordinary);
    (void)setpriority(PRIO_PROCESS, 0, NICE); /* on Linux: of this thread */
    leave_processors(http);
    tfa_log_limit_thread();
}

static void take_listener(tfa_http *http)
{
    uint64_t count;
    (void)!read(http->wake, &count, sizeof count);
    const int next =
        atomic_exchange_explicit(&http->next_listener, NO_CHANGE, memory_order_acquire);
    if (next == NO_CHANGE)
        return;
    if (http->metrics_listener >= 0)
        close(http->metrics_listener);
    http->metrics_listener = next;
}

/* Until something happens, or a time passed. */
static void wait_for_events(tfa_http *http, uint64_t second)
{
    const uint64_t parser = connections_timeout(http);
    const uint64_t ms = ((parser < second ? parser : second) + 999999) / 1000000;
    struct pollfd fds[] = {{.fd = http->wake, .events = POLLIN},
                           {.fd = connections_descriptor(http), .events = POLLIN},
                           {.fd = http->listener, .events = POLLIN},
                           {.fd = http->metrics_listener, .events = POLLIN}};
    if (poll(fds, 4, (int)ms) < 0)
        return;
    if (fds[2].revents)
        connections_accept(http, http->listener, false);
    if (fds[3].revents)
        connections_accept(http, http->metrics_listener, true);
    if (fds[0].revents)
        take_listener(http);
}

static void *run(void *self)
{
    tfa_http *http = self;
    lower_priority(http);
    tfa_stack_prepare();
    while (!atomic_load_explicit(&http->stop, memory_order_acquire)) {
        const uint64_t second = sampler_tick(&http->sampler, http_clock());
        connections_sweep(http);
        connections_run(http);
        wait_for_events(http, second);
    }
    connections_close(http);
    return NULL;
}

/* ---- start, exchange, end ---- */

static int open_figures(tfa_http *http, const tfa_model *const *models,
                        const tfa_worker_robot *solvers, uint32_t count)
{
    http->figures = calloc(count, sizeof *http->figures);
    int status = http->figures ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t i = 0; i < count && status == TFA_OK; i++) {
        status = figure_open(&http->figures[i], models[i], &solvers[i]);
        http->robot_count += status == TFA_OK;
    }
    return status;
}

static void log_address(const tfa_http *http)
{
    const bool v6 = strchr(http->address, ':') != NULL;
    tfa_log(TFA_LOG_INFO, "http: live page http://%s%s%s:%u/, read only", v6 ? "[" : "",
            http->address, v6 ? "]" : "", http->port);
}

int tfa_http_start(tfa_http *http, int statistics, const tfa_model *const *models,
                   const tfa_worker_robot *solvers, uint32_t count)
{
    if (!http)
        return TFA_OK;
    int status = sampler_open(&http->sampler, statistics);
    if (status == TFA_OK && solvers)
        status = open_figures(http, models, solvers, count);
    if (status == TFA_OK)
        status = connections_open(http);
    if (status != TFA_OK)
        return status;
    const int error = pthread_create(&http->thread, NULL, run, http);
    if (error) {
        errno = error;
        return TFA_E_SYSTEM;
    }
    http->running = true;
    (void)pthread_setname_np(http->thread, "tfa-http");
    if (http->page)
        log_address(http);
    return TFA_OK;
}

void tfa_http_exchange(tfa_http *http, uint32_t robot, const tfa_model *next,
                       const tfa_worker_robot *solver)
{
    figure_exchange(&http->figures[robot], next, solver);
}

static void wake(const tfa_http *http)
{
    const uint64_t one = 1;
    (void)!write(http->wake, &one, sizeof one);
}

void tfa_http_metrics(tfa_http *http, int listener)
{
    const int before =
        atomic_exchange_explicit(&http->next_listener, listener, memory_order_acq_rel);
    if (before >= 0)
        close(before);
    wake(http);
}

void tfa_http_stop(tfa_http *http)
{
    if (!http)
        return;
    if (http->running) {
        atomic_store_explicit(&http->stop, true, memory_order_release);
        wake(http);
        pthread_join(http->thread, NULL);
    } else {
        connections_close(http);
    }
    free_http(http);
}
