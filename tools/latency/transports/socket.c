/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Baseline transport: a child echoes as many bytes as a request and a reply have over a Unix socket
 * (SEQPACKET), without a solve.
 */
#include "open.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* First words of a message */
typedef struct head {
    uint64_t id, stamp;
} head;

typedef struct socket_transport {
    transport base;
    int socket;
    pid_t child;
    size_t request_bytes, reply_bytes, buffer_bytes;
    tfa_wait wait;
    unsigned char *buffer;
} socket_transport;

static socket_transport *own(transport *t)
{
    return (socket_transport *)(void *)t;
}

static int send_request(transport *t, uint64_t id, uint64_t index)
{
    socket_transport *s = own(t);
    (void)index;
    memcpy(s->buffer, &id, sizeof id);
    if (send(s->socket, s->buffer, s->request_bytes, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0)
        return TFA_OK;
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS)
        return TFA_E_AGAIN;
    return TFA_E_SYSTEM;
}

static int wait_readable(const socket_transport *s, uint64_t until)
{
    struct pollfd fd = {.fd = s->socket, .events = POLLIN};
    const uint64_t at = clock_ns();
    if (s->wait == TFA_WAIT_SPIN || until <= at)
        return until > at;
    const uint64_t left = until - at;
    const struct timespec time = {.tv_sec = (time_t)(left / 1000000000u),
                                  .tv_nsec = (long)(left % 1000000000u)};
    return ppoll(&fd, 1, &time, NULL) != 0;
}

static int receive(transport *t, uint64_t until, transport_answer *answer)
{
    socket_transport *s = own(t);
    for (;;) {
        head h;
        const ssize_t got = recv(s->socket, s->buffer, s->buffer_bytes, MSG_DONTWAIT);
        if (got >= (ssize_t)sizeof h) {
            memcpy(&h, s->buffer, sizeof h);
            *answer = (transport_answer){
                .id = h.id, .t_received = h.stamp, .t_start = h.stamp, .t_done = h.stamp};
            return TFA_OK;
        }
        if (got >= 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR))
            return TFA_E_SYSTEM;
        if (!wait_readable(s, until))
            return TFA_E_TIMEOUT;
    }
}

static void idle(transport *t, uint64_t until)
{
    transport_sleep(own(t)->wait, until);
}

static int reconnect(transport *t)
{
    (void)t;
    return TFA_E_SYSTEM; /* the child lives as long as the run */
}

static void close_transport(transport *t)
{
    socket_transport *s = own(t);
    if (s->socket >= 0)
        close(s->socket);
    if (s->child > 0)
        kill(s->child, SIGKILL); /* children of later clients hold its socket, too */
    if (s->child > 0)
        while (waitpid(s->child, NULL, 0) < 0 && errno == EINTR)
            ;
    free(s->buffer);
    free(s);
}

static const transport_operations operations = {.now = transport_clock,
                                                .send = send_request,
                                                .receive = receive,
                                                .idle = idle,
                                                .reconnect = reconnect,
                                                .close = close_transport};

/* The child's life. */
static void echo(const socket_transport *s, int socket)
{
    const int flags = s->wait == TFA_WAIT_SPIN ? MSG_DONTWAIT : 0;
    for (;;) {
        const ssize_t got = recv(socket, s->buffer, s->buffer_bytes, flags);
        if (got < 0 && (errno == EAGAIN || errno == EINTR))
            continue;
        if (got <= 0)
            return;
        const uint64_t stamp = clock_ns();
        memcpy(s->buffer + offsetof(head, stamp), &stamp, sizeof stamp);
        if (send(socket, s->buffer, s->reply_bytes, MSG_NOSIGNAL) < 0)
            return;
    }
}

static int start(socket_transport *s)
{
    int ends[2];
    const int bytes = (int)(8 * s->buffer_bytes);
    const pid_t parent = getpid();
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
        return TFA_E_SYSTEM;
    for (int i = 0; i < 2; i++)
        (void)setsockopt(ends[i], SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
    s->socket = ends[0];
    s->child = fork();
    if (s->child == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        close(ends[0]);
        if (getppid() == parent)
            echo(s, ends[1]);
        _exit(0);
    }
    close(ends[1]);
    return s->child > 0 ? TFA_OK : TFA_E_SYSTEM;
}

/* Sizes of the robot: known, or asked of the daemon. */
static int describe(const latency_options *options, transport_facts *facts)
{
    daemon_link *link = NULL;
    char text[512];
    facts->info = options->known;
    if (options->known.v_count)
        return TFA_OK;
    const int status = daemon_connect(&options->daemon, DAEMON_SHM, &link);
    if (status != TFA_OK) {
        daemon_explain(&options->daemon, DAEMON_SHM, status, text, sizeof text);
        fprintf(stderr, "totalforce latency: %s\n", text);
        return status;
    }
    facts->info = *daemon_info(link);
    facts->info.joint_names = facts->info.frame_names = NULL;
    facts->info.joint_types = NULL;
    facts->info.model_hash = NULL;
    daemon_close(link);
    return TFA_OK;
}

int transport_socket_open(const latency_options *options, latency_states *states, transport **t,
                          transport_facts *facts)
{
    (void)states;
    socket_transport *s = calloc(1, sizeof *s);
    if (!s)
        return TFA_E_MEMORY;
    *s = (socket_transport){.base.ops = &operations, .socket = -1};
    int status = describe(options, facts);
    facts->info.slots = 0;
    facts->info.daemon_pid = 0;
    facts->info.wait = s->wait = options->daemon.wait ? options->daemon.wait : TFA_WAIT_BLOCK;
    const pingpong_size size = latency_size(options, &facts->info);
    s->request_bytes = 64 * (size_t)size.request_lines;
    s->reply_bytes = 64 * (size_t)size.reply_lines;
    s->buffer_bytes = s->request_bytes > s->reply_bytes ? s->request_bytes : s->reply_bytes;
    s->buffer = calloc(1, s->buffer_bytes);
    if (status == TFA_OK && !s->buffer)
        status = TFA_E_MEMORY;
    if (status == TFA_OK && (status = start(s)) != TFA_OK)
        fprintf(stderr, "totalforce latency: --via socket: %s\n", strerror(errno));
    if (status == TFA_OK)
        *t = &s->base;
    else
        close_transport(&s->base);
    return status;
}
