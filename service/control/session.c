/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client's life: greeting, quota, ring, hang-up.
 */
#include "control/daemon.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "platform/log.h"

#define HANDSHAKE_TIMEOUT_NS 2000000000u /* a connection without a greeting is closed */
#define MIB ((uint64_t)1 << 20)

/* ---- the end ---- */

static void release(session *s)
{
    if (s->resized) /* it keeps its descriptor, not the memory */
        (void)!ftruncate(s->requests.fd, 0);
    tfa_segment_destroy(&s->requests);
    tfa_segment_destroy(&s->replies);
    if (s->doorbell >= 0)
        close(s->doorbell);
    if (s->socket >= 0)
        close(s->socket);
}

static void free_session(tfa_daemon *d, session *s)
{
    session **link = &d->sessions;
    while (*link != s)
        link = &(*link)->next;
    *link = s->next;
    d->session_count--;
    release(s);
    free(s);
}

static void add_counters(tfa_daemon *d, const session *s)
{
    const tfa_worker_client_counters *count = tfa_worker_client_get_counters(s->client);
    d->totals.requests += atomic_load_explicit(&count->requests, memory_order_relaxed);
    d->totals.rejected += atomic_load_explicit(&count->rejected, memory_order_relaxed);
}

static void remove_client(tfa_daemon *d, session *s)
{
    add_counters(d, s);
    s->worker->clients--;
    free_session(d, s);
}

/* If the worker has detached, the session is gone. */
static void try_detach(tfa_daemon *d, session *s)
{
    if (tfa_worker_detach(s->worker->worker, s->client))
        remove_client(d, s);
}

/* The same, but it hangs up only now: every answer is there. */
static void try_drain(tfa_daemon *d, session *s)
{
    if (tfa_worker_drain(s->worker->worker, s->client))
        remove_client(d, s);
}

/* Hangs up at once; the memory follows when the worker has detached. */
static void end_session(tfa_daemon *d, session *s)
{
    tfa_log(TFA_LOG_DEBUG, "client %d of robot '%s' leaves", (int)s->process,
            d->robot_set.robots[s->robot].name);
    if (s->state == SESSION_HANDSHAKE || s->state == SESSION_DEFERRED) {
        free_session(d, s);
        return;
    }
    close(s->socket);
    s->socket = -1;
    s->state = SESSION_DETACHING;
    try_detach(d, s);
}

/* ---- the greeting ---- */

/* The answer to a HELLO that cannot be granted; the connection ends after it. */
__attribute__((format(printf, 4, 5))) static int refuse(tfa_daemon *d, tfa_welcome *w, int status,
                                                        const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(w->text, sizeof w->text, format, arguments);
    va_end(arguments);
    w->status = status;
    d->totals.refused++;
    return status;
}

static int check_hello(tfa_daemon *d, const session *s, const tfa_hello *hello, tfa_welcome *w)
{
    const tfa_robot *served = &d->robot_set.robots[s->robot];
    const config_robot *robot = served->config;
    if (hello->magic != TFA_HANDSHAKE_MAGIC || hello->abi != TFA_HANDSHAKE_ABI)
        return refuse(d, w, TFA_E_PROTOCOL, "this daemon speaks version %u of the protocol",
                      TFA_HANDSHAKE_ABI);
    if (!memchr(hello->robot, 0, sizeof hello->robot) || strcmp(hello->robot, served->name) != 0)
        return refuse(d, w, TFA_E_ROBOT, "this socket serves robot '%s'", served->name);
    if (!tfa_ring_slots_valid(hello->slots) || hello->slots > robot->slots)
        return refuse(d, w, TFA_E_SIZE, "slots: %u; a power of two, at most %u", hello->slots,
                      robot->slots);
    if (hello->max_batch == 0 || hello->max_batch > robot->max_batch)
        return refuse(d, w, TFA_E_SIZE, "max_batch: %u; 1 to %u", hello->max_batch,
                      robot->max_batch);
    if (hello->wait > TFA_WAIT_BLOCK)
        return refuse(d, w, TFA_E_PROTOCOL, "wait: %u does not exist", hello->wait);
    return TFA_OK;
}

/* Spinning takes a processor on each side: with a single one both would only be in the way. */
static tfa_wait choose_wait_mode(const tfa_daemon *d, const session *s, uint32_t asked)
{
    const config_robot *robot = d->robot_set.robots[s->robot].config;
    tfa_wait wait = (tfa_wait)(asked == TFA_WAIT_DEFAULT ? robot->wait : asked);
    const bool may_spin = d->settings->allow_spin && sysconf(_SC_NPROCESSORS_ONLN) > 1;
    return wait == TFA_WAIT_SPIN && !may_spin ? TFA_WAIT_HYBRID : wait;
}

static daemon_worker *choose_worker(const tfa_daemon *d)
{
    daemon_worker *best = &d->workers[0];
    for (uint32_t i = 1; i < d->settings->workers; i++)
        if (d->workers[i].clients < best->clients)
            best = &d->workers[i];
    return best;
}

/* Shared memory of the clients of a user; of all, if `all`. */
static uint64_t memory_of(const tfa_daemon *d, uid_t user, bool all)
{
    uint64_t bytes = 0;
    for (const session *s = d->sessions; s; s = s->next)
        if (all || s->user == user)
            bytes += (s->requests.memory ? s->requests.size : 0) +
                     (s->replies.memory ? s->replies.size : 0);
    return bytes;
}

static int check_memory(tfa_daemon *d, const session *s, uint64_t size, tfa_welcome *w)
{
    static const char *const keys[] = {"memory_mib_per_user", "memory_mib"};
    const config_limits *limits = &d->settings->limits;
    const uint64_t most[] = {limits->memory_mib_per_user * MIB, limits->memory_mib * MIB};
    for (int all = 0; all < 2; all++)
        if (size > most[all] || memory_of(d, s->user, all) > most[all] - size)
            return refuse(d, w, TFA_E_REFUSED,
                          "%llu KiB of shared memory are beyond limits.%s (%llu); ask for fewer "
                          "slots or a smaller max_batch",
                          (unsigned long long)size / 1024, keys[all],
                          (unsigned long long)(most[all] / MIB));
    return TFA_OK;
}

static int refuse_segment(tfa_daemon *d, tfa_welcome *w, int status, size_t size)
{
    if (errno == ENOSPC)
        return refuse(d, w, TFA_E_REFUSED,
                      "no room for %zu KiB in /dev/shm: free some of it, mount it larger, or set "
                      "backend: memfd",
                      size / 1024);
    return refuse(d, w, status, "shared memory of %zu KiB: %s", size / 1024, strerror(errno));
}

static int create_segments(tfa_daemon *d, session *s, tfa_welcome *w)
{
    const tfa_ring_layout *layout = &w->layout;
    const size_t size = layout->request_bytes + layout->reply_bytes;
    const config_backend backend = (config_backend)d->settings->backend;
    int status = check_memory(d, s, size, w);
    if (status != TFA_OK)
        return status;
    status =
        tfa_segment_create(backend, TFA_SEGMENT_PEER_WRITES, layout->request_bytes, &s->requests);
    if (status == TFA_OK)
        status =
            tfa_segment_create(backend, TFA_SEGMENT_PEER_READS, layout->reply_bytes, &s->replies);
    if (status != TFA_OK)
        return refuse_segment(d, w, status, size);
    s->doorbell = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    return s->doorbell >= 0 ? TFA_OK : refuse(d, w, TFA_E_SYSTEM, "eventfd: %s", strerror(errno));
}

static int attach_client(tfa_daemon *d, session *s, tfa_welcome *w)
{
    const tfa_worker_client_options options = {.robot = s->robot,
                                               .max_batch = w->shape.max_batch,
                                               .layout = w->layout,
                                               .requests = s->requests.memory,
                                               .replies = s->replies.memory,
                                               .wait = (tfa_wait)w->wait,
                                               .doorbell = s->doorbell};
    s->worker = choose_worker(d);
    int status = tfa_worker_attach(s->worker->worker, &options, &s->client);
    if (status != TFA_OK)
        return refuse(d, w, status, "no entry free at the worker: %s", tfa_status_text(status));
    s->worker->clients++;
    s->state = SESSION_ATTACHED;
    return TFA_OK;
}

static int accept_hello(tfa_daemon *d, session *s, const tfa_hello *hello, tfa_welcome *w)
{
    const tfa_robot *robot = &d->robot_set.robots[s->robot];
    int status = check_hello(d, s, hello, w);
    if (status != TFA_OK)
        return status;
    w->shape = robot->shape;
    w->shape.max_batch = hello->max_batch;
    w->layout = tfa_ring_layout_of(&w->shape, hello->slots);
    w->wait = choose_wait_mode(d, s, hello->wait);
    w->spin_ns = d->settings->spin_ns;
    w->joint_count = tfa_model_joint_count(robot->model);
    w->frame_count = tfa_model_frame_count(robot->model);
    w->names_bytes = robot->names.size;
    memcpy(w->model_hash, tfa_model_hash_text(robot->model), sizeof w->model_hash);
    status = create_segments(d, s, w);
    return status == TFA_OK ? attach_client(d, s, w) : status;
}

static bool send_welcome(const tfa_daemon *d, const session *s, tfa_welcome *w)
{
    union {
        char bytes[CMSG_SPACE(sizeof(int) * TFA_WELCOME_DESCRIPTORS)];
        struct cmsghdr align;
    } control = {{0}};
    struct iovec part = {.iov_base = w, .iov_len = sizeof *w};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
    if (w->status == TFA_OK) {
        int fds[TFA_WELCOME_DESCRIPTORS];
        fds[TFA_WELCOME_REQUESTS] = s->requests.fd;
        fds[TFA_WELCOME_REPLIES] = s->replies.fd_readonly;
        fds[TFA_WELCOME_NAMES] = d->robot_set.robots[s->robot].names.fd_readonly;
        fds[TFA_WELCOME_DOORBELL] = s->doorbell;
        message.msg_control = control.bytes;
        message.msg_controllen = sizeof control.bytes;
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        c->cmsg_level = SOL_SOCKET;
        c->cmsg_type = SCM_RIGHTS;
        c->cmsg_len = CMSG_LEN(sizeof fds);
        memcpy(CMSG_DATA(c), fds, sizeof fds);
    }
    return sendmsg(s->socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == (ssize_t)sizeof *w;
}

static void answer_handshake(tfa_daemon *d, session *s, const tfa_hello *hello, ssize_t size)
{
    tfa_welcome w = {
        .magic = TFA_HANDSHAKE_MAGIC, .abi = TFA_HANDSHAKE_ABI, .daemon_pid = (int32_t)getpid()};
    int status;
    if (size != (ssize_t)sizeof *hello)
        status =
            refuse(d, &w, TFA_E_PROTOCOL, "HELLO has %zu bytes, %zd came", sizeof *hello, size);
    else
        status = accept_hello(d, s, hello, &w);
    const bool sent = send_welcome(d, s, &w);
    tfa_segment_close(&s->replies); /* the size of the requests is watched */
    if (status != TFA_OK)
        tfa_log(TFA_LOG_INFO, "client %d (user %u) of robot '%s' refused: %s", (int)s->process,
                (unsigned)s->user, d->robot_set.robots[s->robot].name, w.text);
    if (status != TFA_OK || !sent)
        end_session(d, s);
}

/* ---- events ---- */

static uint32_t sessions_of(const tfa_daemon *d, uid_t user)
{
    uint32_t count = 0;
    for (const session *s = d->sessions; s; s = s->next)
        count += s->user == user;
    return count;
}

/* A connection counts from its first moment, whether it has said HELLO or not. */
static int admit(tfa_daemon *d, int socket, const struct ucred *peer, tfa_welcome *w)
{
    const config_limits *limits = &d->settings->limits;
    if (!tfa_admission_allows(&d->admission, socket, peer->uid, peer->gid))
        return refuse(d, w, TFA_E_REFUSED, "user %u is not among allow_users and allow_groups",
                      (unsigned)peer->uid);
    if (sessions_of(d, peer->uid) >= limits->clients_per_user)
        return refuse(d, w, TFA_E_REFUSED, "user %u has %u clients already (clients_per_user)",
                      (unsigned)peer->uid, limits->clients_per_user);
    if (d->session_count >= limits->clients)
        return refuse(d, w, TFA_E_REFUSED, "%u clients are connected already (limits.clients)",
                      limits->clients);
    return TFA_OK;
}

void session_begin(tfa_daemon *d, uint32_t robot, int socket)
{
    tfa_welcome w = {
        .magic = TFA_HANDSHAKE_MAGIC, .abi = TFA_HANDSHAKE_ABI, .daemon_pid = (int32_t)getpid()};
    struct ucred peer;
    socklen_t size = sizeof peer;
    session *s = NULL;
    if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
        goto err_socket;
    if (admit(d, socket, &peer, &w) != TFA_OK) {
        (void)send(socket, &w, sizeof w, MSG_NOSIGNAL | MSG_DONTWAIT);
        tfa_log(TFA_LOG_INFO, "client %d of robot '%s' refused: %s", (int)peer.pid,
                d->robot_set.robots[robot].name, w.text);
        goto err_socket;
    }
    s = calloc(1, sizeof *s);
    if (!s)
        goto err_socket;
    *s = (session){.next = d->sessions,
                   .socket = socket,
                   .doorbell = -1,
                   .robot = robot,
                   .user = peer.uid,
                   .process = peer.pid,
                   .since = control_clock(),
                   .requests = TFA_SEGMENT_NONE,
                   .replies = TFA_SEGMENT_NONE};
    struct epoll_event event = {.events = EPOLLIN | EPOLLRDHUP, .data.ptr = s};
    if (epoll_ctl(d->epoll, EPOLL_CTL_ADD, socket, &event) != 0)
        goto err_socket;
    d->sessions = s;
    d->session_count++;
    d->totals.connections++;
    return;

err_socket:
    free(s);
    close(socket);
}

void session_event(tfa_daemon *d, session *s)
{
    tfa_hello hello;
    ssize_t size = recv(s->socket, &hello, sizeof hello, MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0 && (errno == EAGAIN || errno == EINTR))
        return;
    if (size > 0 && s->state == SESSION_HANDSHAKE) {
        if (!d->robot_set.robots[s->robot].reshaping) {
            answer_handshake(d, s, &hello, size);
            return;
        }
        s->hello = hello;
        s->hello_size = size;
        s->state = SESSION_DEFERRED;
        return;
    }
    if (size > 0)
        tfa_log(TFA_LOG_WARNING, "client %d speaks after the greeting: it has to go",
                (int)s->process);
    end_session(d, s);
}

/* Why a session has to go; NULL: it may stay. */
static const char *fault_of(session *s, uint64_t now)
{
    if (s->state == SESSION_HANDSHAKE && now - s->since > HANDSHAKE_TIMEOUT_NS)
        return "said no HELLO";
    if (s->state != SESSION_ATTACHED)
        return NULL;
    s->resized = tfa_segment_was_resized(&s->requests);
    if (s->resized)
        return "changed the size of its memory";
    if (tfa_worker_client_is_broken(s->client))
        return "broke the protocol or took its memory away";
    return NULL;
}

void session_tick(tfa_daemon *d)
{
    const uint64_t now = control_clock();
    for (session *s = d->sessions, *next; s; s = next) {
        next = s->next;
        const char *fault = fault_of(s, now);
        if (fault) {
            tfa_log(TFA_LOG_WARNING, "client %d (user %u) of robot '%s' %s: it has to go",
                    (int)s->process, (unsigned)s->user, d->robot_set.robots[s->robot].name, fault);
            end_session(d, s);
        } else if (s->state == SESSION_DETACHING) {
            try_detach(d, s);
        } else if (s->state == SESSION_DRAINING) {
            try_drain(d, s);
        }
    }
}

bool session_any_detaching(const tfa_daemon *d)
{
    for (const session *s = d->sessions; s; s = s->next)
        if (s->state == SESSION_DETACHING || s->state == SESSION_DRAINING)
            return true;
    return false;
}

/* ---- a reload that changes the shape of a robot ---- */

void session_drain(tfa_daemon *d, uint32_t robot)
{
    for (session *s = d->sessions, *next; s; s = next) {
        next = s->next;
        if (s->robot != robot || s->state != SESSION_ATTACHED)
            continue;
        s->state = SESSION_DRAINING;
        try_drain(d, s);
    }
}

bool session_any_attached(const tfa_daemon *d, uint32_t robot)
{
    for (const session *s = d->sessions; s; s = s->next)
        if (s->robot == robot && s->state >= SESSION_ATTACHED)
            return true;
    return false;
}

void session_resume_deferred(tfa_daemon *d)
{
    for (session *s = d->sessions, *next; s; s = next) {
        next = s->next;
        if (s->state != SESSION_DEFERRED || d->robot_set.robots[s->robot].reshaping)
            continue;
        s->state = SESSION_HANDSHAKE;
        answer_handshake(d, s, &s->hello, s->hello_size);
    }
}

void session_end_all(tfa_daemon *d)
{
    for (session *s = d->sessions, *next; s; s = next) {
        next = s->next;
        if (s->state == SESSION_DETACHING)
            try_detach(d, s);
        else
            end_session(d, s);
    }
}
