/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Admission and handshake of a client: quotas, HELLO, segments, WELCOME. A refusal says why.
 */
#include "control/daemon.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "platform/log.h"

#define MIB ((uint64_t)1 << 20)

/* The answer to a HELLO that cannot be granted; the connection ends after it. */
__attribute__((format(printf, 4, 5))) static int refuse(tfa_daemon *d, tfa_welcome *w, int status,
                                                        const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(w->text, sizeof w->text, format, arguments);
    va_end(arguments);
    w->status = status;
    tfa_counter_add(&d->statistics.header->refused, 1);
    return status;
}

/* ---- admission ---- */

static uint32_t sessions_of(const tfa_daemon *d, uid_t user)
{
    uint32_t count = 0;
    for (const session *s = d->sessions; s; s = s->next)
        count += s->user == user;
    return count;
}

tfa_welcome handshake_welcome(void)
{
    return (tfa_welcome){
        .magic = TFA_HANDSHAKE_MAGIC, .abi = TFA_HANDSHAKE_ABI, .daemon_pid = (int32_t)getpid()};
}

/* A connection counts from its first moment, whether it has said HELLO or not. */
int handshake_admit(tfa_daemon *d, int socket, const struct ucred *peer, tfa_welcome *w)
{
    const config_limits *limits = &d->settings->limits;
    if (!tfa_admission_allows(&d->admission, socket, peer->uid, peer->gid))
        return refuse(d, w, TFA_E_REFUSED, "user %u is not among allow_users and allow_groups",
                      (unsigned)peer->uid);
    if (!tfa_connect_rate_allows(&d->connect_rate, peer->uid, limits->connects_per_second,
                                 control_clock()))
        return refuse(d, w, TFA_E_REFUSED, "user %u connects too often (connects_per_second: %u)",
                      (unsigned)peer->uid, limits->connects_per_second);
    const uint32_t own = sessions_of(d, peer->uid);
    if (own >= limits->clients_per_user)
        return refuse(d, w, TFA_E_REFUSED, "user %u has %u clients already (clients_per_user)",
                      (unsigned)peer->uid, limits->clients_per_user);
    if (own >= tfa_share_of(limits->clients, d->session_count - own, peer->uid))
        return refuse(d, w, TFA_E_REFUSED,
                      "user %u has %u clients, %u are connected: its share is used "
                      "(limits.clients: %u)",
                      (unsigned)peer->uid, own, d->session_count, limits->clients);
    return TFA_OK;
}

/* ---- HELLO ---- */

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
    if (hello->max_tips > TFA_MAX_TIPS)
        return refuse(d, w, TFA_E_SIZE, "max_tips: %u; at most %u", hello->max_tips,
                      (unsigned)TFA_MAX_TIPS);
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

/* Shared memory of the clients of a user, or of all others */
static uint64_t memory_of(const tfa_daemon *d, uid_t user, bool others)
{
    uint64_t bytes = 0;
    for (const session *s = d->sessions; s; s = s->next)
        if ((s->user == user) != others)
            bytes += (s->requests.memory ? s->requests.size : 0) +
                     (s->replies.memory ? s->replies.size : 0);
    return bytes;
}

static int check_memory(tfa_daemon *d, const session *s, uint64_t size, tfa_welcome *w)
{
    static const char *const keys[] = {"memory_mib_per_user", "memory_mib"};
    const config_limits *limits = &d->settings->limits;
    const uint64_t mib[] = {limits->memory_mib_per_user, limits->memory_mib};
    const uint64_t most[] = {mib[0] * MIB,
                             tfa_share_of(mib[1] * MIB, memory_of(d, s->user, true), s->user)};
    const uint64_t own = memory_of(d, s->user, false);
    for (int i = 0; i < 2; i++)
        if (size > most[i] || own > most[i] - size)
            return refuse(d, w, TFA_E_REFUSED,
                          "%llu KiB of shared memory are beyond the user's share of limits.%s "
                          "(%llu); ask for fewer slots, fewer tips or a smaller max_batch",
                          (unsigned long long)size / 1024, keys[i], (unsigned long long)mib[i]);
    return TFA_OK;
}

static int refuse_segment(tfa_daemon *d, tfa_welcome *w, int status, size_t size)
{
    if (errno == ENOSPC)
        return refuse(d, w, TFA_E_REFUSED,
                      "no room for %zu KiB in /dev/shm: free some of it, mount it larger, or set "
                      "backend: memfd",
                      size / 1024);
    if (d->settings->backend == CONFIG_BACKEND_SHM && (errno == ENOENT || errno == EROFS))
        return refuse(d, w, status,
                      "shared memory of %zu KiB: /dev/shm: %s; mount it, or set backend: memfd",
                      size / 1024, strerror(errno));
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
    const tfa_worker_client_options options = {
        .robot = s->robot,
        .max_batch = w->shape.max_batch,
        .max_tips = w->shape.max_tips,
        .layout = w->layout,
        .requests = s->requests.memory,
        .replies = s->replies.memory,
        .wait = (tfa_wait)w->wait,
        .doorbell = s->doorbell,
        .served = {
            .kind = TFA_CLIENT_SHM, .process = s->process, .user = s->user, .since = s->since}};
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
    if (hello->max_tips < w->shape.max_tips)
        w->shape.max_tips = hello->max_tips;
    w->layout = tfa_ring_layout_of(&w->shape, hello->slots);
    w->wait = choose_wait_mode(d, s, hello->wait);
    w->spin_ns = d->settings->spin_ns;
    w->joint_count = tfa_model_joint_count(robot->model);
    w->frame_count = tfa_model_frame_count(robot->model);
    w->constraint_count = tfa_model_constraint_count(robot->model);
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

bool handshake_answer(tfa_daemon *d, session *s, const tfa_hello *hello, ssize_t size)
{
    tfa_welcome w = handshake_welcome();
    int status;
    if (size != (ssize_t)sizeof *hello)
        status =
            refuse(d, &w, TFA_E_PROTOCOL, "HELLO has %zu bytes, %zd came", sizeof *hello, size);
    else
        status = accept_hello(d, s, hello, &w);
    const bool sent = send_welcome(d, s, &w);
    tfa_segment_close(&s->replies); /* the size of the requests is watched */
    if (status != TFA_OK)
        tfa_log_client(TFA_LOG_INFO, "client %d (user %u) of robot '%s' refused: %s",
                       (int)s->process, (unsigned)s->user, d->robot_set.robots[s->robot].name,
                       w.text);
    return status == TFA_OK && sent;
}
