/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client that speaks the protocol by itself.
 */
#include "raw_client.h"

#include "test.h"

#include <errno.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

int connect_raw(const harness *h)
{
    return harness_dial(h, "arm.sock");
}

tfa_hello good_hello(tfa_wait wait)
{
    return (tfa_hello){.magic = TFA_HANDSHAKE_MAGIC,
                       .abi = TFA_HANDSHAKE_ABI,
                       .slots = 8,
                       .max_batch = 2,
                       .max_tips = TFA_DEFAULT_TIPS,
                       .wait = wait,
                       .robot = "arm"};
}

/* A refusal that crossed the greeting is behind the error of that greeting. */
int receive_status(int socket, tfa_welcome *w)
{
    const struct timeval limit = {.tv_sec = WAIT_MS / 1000};
    assert_int_equal(setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit), 0);
    ssize_t size = recv(socket, w, sizeof *w, 0);
    if (size < 0 && errno == ECONNRESET)
        size = recv(socket, w, sizeof *w, 0);
    assert_true(size >= 0 || errno == ECONNRESET);
    return size == (ssize_t)sizeof *w ? w->status : TFA_E_DISCONNECTED;
}

static bool receive_welcome(raw_client *v)
{
    union {
        char bytes[CMSG_SPACE(sizeof v->fds)];
        struct cmsghdr align;
    } control;
    struct iovec part = {.iov_base = &v->welcome, .iov_len = sizeof v->welcome};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    if (recvmsg(v->socket, &message, MSG_CMSG_CLOEXEC) != sizeof v->welcome ||
        v->welcome.status != TFA_OK)
        return false;
    memcpy(v->fds, CMSG_DATA(CMSG_FIRSTHDR(&message)), sizeof v->fds);
    return true;
}

bool try_connect_client(const harness *h, tfa_wait wait, raw_client *v)
{
    *v = (raw_client){.socket = connect_raw(h)};
    const tfa_hello hello = good_hello(wait);
    (void)!send(v->socket, &hello, sizeof hello, MSG_NOSIGNAL);
    if (!receive_welcome(v)) {
        close(v->socket);
        return false;
    }
    const tfa_ring_layout *l = &v->welcome.layout;
    v->ring = (tfa_ring_client){.layout = *l, .spin = wait == TFA_WAIT_SPIN};
    v->ring.requests = mmap(NULL, l->request_bytes, PROT_READ | PROT_WRITE, MAP_SHARED,
                            v->fds[TFA_WELCOME_REQUESTS], 0);
    v->ring.replies =
        mmap(NULL, l->reply_bytes, PROT_READ, MAP_SHARED, v->fds[TFA_WELCOME_REPLIES], 0);
    v->ring.worker_status = (const void *)v->ring.replies;
    assert_ptr_not_equal(v->ring.requests, MAP_FAILED);
    assert_ptr_not_equal(v->ring.replies, MAP_FAILED);
    return true;
}

/* A client by the book so far. */
raw_client connect_client(const harness *h, tfa_wait wait)
{
    raw_client v;
    assert_true(try_connect_client(h, wait, &v));
    return v;
}

void disconnect_client(raw_client *v)
{
    munmap(v->ring.requests, v->ring.layout.request_bytes);
    munmap((void *)(uintptr_t)v->ring.replies, v->ring.layout.reply_bytes);
    for (int i = 0; i < TFA_WELCOME_DESCRIPTORS; i++)
        close(v->fds[i]);
    close(v->socket);
}

void wake(const raw_client *v)
{
    const uint64_t one = 1;
    (void)!write(v->fds[TFA_WELCOME_DOORBELL], &one, sizeof one);
}

const tfa_wire_reply *await_reply(const raw_client *v)
{
    for (int i = 0; i < 1000 && !tfa_ring_reply_ready(&v->ring); i++)
        sched_yield();
    assert_true(WAIT_FOR(tfa_ring_reply_ready(&v->ring)));
    return tfa_ring_oldest_reply(&v->ring);
}

/* The daemon hangs up on this socket. */
void assert_hung_up(int socket)
{
    struct pollfd fd = {.fd = socket, .events = POLLRDHUP};
    assert_int_equal(poll(&fd, 1, WAIT_MS), 1);
    assert_true(fd.revents & (POLLHUP | POLLRDHUP));
}

void assert_unharmed(scene *s)
{
    double qdd[7];
    for (int i = 0; i < 5; i++) {
        assert_int_equal(ask_arm(s->honest_client, 1, qdd, TIMEOUT_NS), TFA_OK);
        assert_memory_equal(qdd, s->expected, sizeof qdd);
    }
}

scene open_scene(const char *more)
{
    scene s = {.h = harness_serve(ARM, more)};
    s.honest_client = harness_connect(&s.h, "arm", TFA_WAIT_HYBRID);
    assert_int_equal(ask_arm(s.honest_client, 1, s.expected, TIMEOUT_NS), TFA_OK);
    return s;
}

void close_scene(scene *s)
{
    assert_unharmed(s);
    tfa_client_close(s->honest_client);
    harness_remove(&s->h);
}
