/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Commands of operators, by the control socket: status, statistics, describe, reload,
 * stop, record.
 */
#include "control/daemon.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "ipc/control_socket.h"
#include "platform/log.h"

#define WORD_BYTES 128         /* the longest command with its final 0 */
#define TIMEOUT_NS 2000000000u /* a connection without a command is closed */

void commands_open(tfa_daemon *d)
{
    for (int i = 0; i < COMMANDS_MAX; i++)
        d->commands[i].socket = -1;
    d->command_listener = -1;
}

int commands_listen(tfa_daemon *d)
{
    struct epoll_event event = {.events = EPOLLIN, .data.ptr = &d->command_listener};
    d->command_listener = tfa_runtime_dir_listen(&d->runtime_dir, TFA_CONTROL_NAME);
    if (d->command_listener >= 0 &&
        epoll_ctl(d->epoll, EPOLL_CTL_ADD, d->command_listener, &event) == 0)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "socket '%s/%s': %s", d->runtime_dir.path, TFA_CONTROL_SOCKET,
            strerror(errno));
    return TFA_E_SYSTEM;
}

void commands_unlisten(tfa_daemon *d)
{
    if (d->command_listener < 0)
        return;
    tfa_runtime_dir_unlink(&d->runtime_dir, TFA_CONTROL_NAME);
    close(d->command_listener);
    d->command_listener = -1;
}

static void end(command *c)
{
    if (c->socket >= 0)
        close(c->socket);
    c->socket = -1;
}

void commands_close(tfa_daemon *d)
{
    for (int i = 0; i < COMMANDS_MAX; i++)
        end(&d->commands[i]);
}

/* The daemon does not wait for the peer: an answer that its buffer does not take is lost. */
static void send_answer(command *c, const char *text, size_t length)
{
    (void)!send(c->socket, text, length, MSG_NOSIGNAL | MSG_DONTWAIT);
    end(c);
}

static void answer_text(command *c, const char *text)
{
    send_answer(c, text, strlen(text));
}

bool commands_send(int socket, const char *text, const int *descriptors, size_t count)
{
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE(COMMANDS_DESCRIPTORS * sizeof(int))];
    } control = {0};
    struct iovec part = {.iov_base = (void *)(uintptr_t)text, .iov_len = strlen(text)};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = CMSG_SPACE(count * sizeof(int))};
    struct cmsghdr *const head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(count * sizeof(int));
    memcpy(CMSG_DATA(head), descriptors, count * sizeof(int));
    return sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == (ssize_t)part.iov_len;
}

static void answer_status(const tfa_daemon *d, command *c)
{
    char *text = NULL;
    size_t size = 0;
    const int buffer = TFA_CONTROL_TEXT_MAX;
    (void)setsockopt(c->socket, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    if (status_write(d, &text, &size) == TFA_OK)
        send_answer(c, text, size);
    else
        answer_text(c, "error: out of memory");
    free(text);
}

/* "ok", and a read-only descriptor. */
static void answer_statistics(const tfa_daemon *d, command *c)
{
    (void)commands_send(c->socket, "ok", &d->statistics_segment.fd_readonly, 1);
    end(c);
}

static void answer_description(tfa_daemon *d, command *c, const char *robot)
{
    char text[256];
    const uint32_t i = robot_set_find(&d->robot_set, robot, text, sizeof text);
    const tfa_segment *s = i == UINT32_MAX ? NULL : description_segment(d, i, text, sizeof text);
    if (s)
        (void)commands_send(c->socket, "ok", &s->fd_readonly, 1);
    else
        answer_text(c, text);
    end(c);
}

/* ---- places ---- */

static uint32_t count_of(const tfa_daemon *d, uid_t user)
{
    uint32_t count = 0;
    for (const command *c = d->commands; c < d->commands + COMMANDS_MAX; c++)
        count += c->socket >= 0 && c->user == user;
    return count;
}

/* The connection that ends for one of `user`; NULL: none may */
static command *find_silent(tfa_daemon *d, uid_t user)
{
    command *found = NULL;
    uint32_t most = 0;
    for (command *c = d->commands; c < d->commands + COMMANDS_MAX; c++) {
        if (c->socket < 0 || c->waits || (tfa_is_operator(c->user) && !tfa_is_operator(user)))
            continue;
        const uint32_t count = count_of(d, c->user);
        if (count > most || (count == most && c->since < found->since))
            found = c;
        most = count > most ? count : most;
    }
    return found;
}

static command *find_place(tfa_daemon *d, uid_t user)
{
    static const char text[] = "error: busy: more connections came, and this one sent no command";
    for (command *c = d->commands; c < d->commands + COMMANDS_MAX; c++)
        if (c->socket < 0)
            return c;
    command *c = find_silent(d, user);
    if (c)
        answer_text(c, text);
    return c;
}

void commands_accept(tfa_daemon *d)
{
    static const char text[] = "error: busy: too many commands under way; try again";
    struct ucred peer;
    socklen_t size = sizeof peer;
    command next = {.socket = control_accept(d, d->command_listener), .since = control_clock()};
    if (next.socket < 0)
        return;
    const bool known = getsockopt(next.socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0;
    command *c = known ? find_place(d, peer.uid) : NULL;
    if (!c) {
        answer_text(&next, text);
        return;
    }
    next.user = peer.uid;
    *c = next;
    struct epoll_event event = {.events = EPOLLIN | EPOLLRDHUP, .data.ptr = c};
    if (epoll_ctl(d->epoll, EPOLL_CTL_ADD, c->socket, &event) != 0)
        end(c);
}

/* ---- commands ---- */

/* Has the peer closed its socket, as a client does whose time is over? An AF_UNIX SOCK_SEQPACKET
 * socket reports a hang-up (POLLHUP) when both directions are shut down, which close() of the peer
 * does. shutdown(SHUT_WR) of the peer shuts down only the direction to here, which is POLLRDHUP:
 * that peer still waits for its answer. */
static bool has_hung_up(int socket)
{
    struct pollfd peer = {.fd = socket}; /* POLLHUP is reported without being asked for */
    return poll(&peer, 1, 0) > 0 && (peer.revents & POLLHUP);
}

/* The connection becomes that of a recorder. */
static void obey_record(tfa_daemon *d, command *c, const char *order)
{
    char text[256];
    if (recordings_begin(d, c->socket, order, text, sizeof text))
        c->socket = -1;
    else
        answer_text(c, text);
}

/* The answer comes at the end of the reload. Until then only a hang-up is of interest, which epoll
 * reports without being asked for: the end of input after shutdown(SHUT_WR) is none. */
static void obey_reload(tfa_daemon *d, command *c)
{
    struct epoll_event event = {.events = 0, .data.ptr = c};
    c->waits = true;
    (void)epoll_ctl(d->epoll, EPOLL_CTL_MOD, c->socket, &event);
    reload_request(d);
}

static void obey(tfa_daemon *d, command *c, const char *word)
{
    const bool record = strncmp(word, "record ", 7) == 0;
    if (strcmp(word, "status") == 0) {
        answer_status(d, c);
    } else if (strcmp(word, "statistics") == 0) {
        answer_statistics(d, c);
    } else if (strncmp(word, "describe ", 9) == 0) {
        answer_description(d, c, word + 9);
    } else if (!record && strcmp(word, "reload") != 0 && strcmp(word, "stop") != 0) {
        answer_text(c, "error: no such command; there are status, statistics, describe, reload, "
                       "stop and record");
    } else if (!tfa_is_operator(c->user)) {
        answer_text(c, "error: only root and the daemon's user may do that");
    } else if (record) {
        obey_record(d, c, word + 7);
    } else if (*word == 's') {
        answer_text(c, "ok: stopping");
        d->stop = true;
    } else {
        obey_reload(d, c);
    }
}

bool commands_event(tfa_daemon *d, void *what)
{
    command *c = what;
    char word[WORD_BYTES];
    if (c < d->commands || c >= d->commands + COMMANDS_MAX)
        return false;
    const ssize_t size = recv(c->socket, word, sizeof word - 1, MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0 && (errno == EAGAIN || errno == EINTR))
        return true;
    if (size <= 0 || c->waits || (size_t)size >= sizeof word || has_hung_up(c->socket)) {
        end(c);
        return true;
    }
    word[size] = 0;
    obey(d, c, word);
    return true;
}

void commands_reloaded(tfa_daemon *d, const char *text)
{
    for (int i = 0; i < COMMANDS_MAX; i++)
        if (d->commands[i].socket >= 0 && d->commands[i].waits)
            answer_text(&d->commands[i], text);
}

void commands_tick(tfa_daemon *d)
{
    const uint64_t now = control_clock();
    for (int i = 0; i < COMMANDS_MAX; i++)
        if (d->commands[i].socket >= 0 && !d->commands[i].waits &&
            now - d->commands[i].since > TIMEOUT_NS)
            end(&d->commands[i]);
}
