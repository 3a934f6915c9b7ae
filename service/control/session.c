/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client's life: from its connection to its hang-up.
 */
#include "control/daemon.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "platform/log.h"

#define HANDSHAKE_TIMEOUT_NS 2000000000u /* a connection without a greeting is closed */

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

static void remove_client(tfa_daemon *d, session *s)
{
    s->worker->clients--;
    free_session(d, s);
}

/* The last message to a client that was attached: why it is hung up on. */
static void say_why(const session *s, const char *why)
{
    tfa_welcome w = handshake_welcome();
    w.status = TFA_E_DISCONNECTED;
    snprintf(w.text, sizeof w.text, "%s", why);
    (void)send(s->socket, &w, sizeof w, MSG_NOSIGNAL | MSG_DONTWAIT);
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
    if (!tfa_worker_drain(s->worker->worker, s->client))
        return;
    say_why(
        s, "the robot has other joints, links or a base now: connect again, with buffers that fit");
    remove_client(d, s);
}

/* Hangs up at once; the memory follows when the worker has detached. */
static void end_session(tfa_daemon *d, session *s)
{
    tfa_log_client(TFA_LOG_DEBUG, "client %d of robot '%s' leaves", (int)s->process,
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

/* ---- events ---- */

void session_begin(tfa_daemon *d, uint32_t robot, int socket)
{
    tfa_welcome w = handshake_welcome();
    struct ucred peer;
    socklen_t size = sizeof peer;
    session *s = NULL;
    if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
        goto err_socket;
    if (handshake_admit(d, socket, &peer, &w) != TFA_OK) {
        (void)send(socket, &w, sizeof w, MSG_NOSIGNAL | MSG_DONTWAIT);
        tfa_log_client(TFA_LOG_INFO, "client %d of robot '%s' refused: %s", (int)peer.pid,
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
    tfa_counter_add(&d->statistics.header->connections, 1);
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
            if (!handshake_answer(d, s, &hello, size))
                end_session(d, s);
            return;
        }
        s->hello = hello;
        s->hello_size = size;
        s->state = SESSION_DEFERRED;
        return;
    }
    if (size > 0)
        tfa_log_client(TFA_LOG_WARNING, "client %d speaks after the greeting: it has to go",
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
            tfa_log_client(TFA_LOG_WARNING, "client %d (user %u) of robot '%s' %s: it has to go",
                           (int)s->process, (unsigned)s->user, d->robot_set.robots[s->robot].name,
                           fault);
            say_why(s, fault);
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
        if (!handshake_answer(d, s, &s->hello, s->hello_size))
            end_session(d, s);
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
