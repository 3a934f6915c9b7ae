/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: any packet as a HELLO. It is refused with a reason, or granted as asked, and
 * everything is given back when the client leaves.
 */
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "control/daemon.h"
#include "fuzz_service.h"

static tfa_daemon *open_daemon(void)
{
    static const char text[] = "log: error\nrobots:\n  - name: arm\n    urdf: " TFA_SOURCE_DIR
                               "/config/robots/arm7.urdf\n";
    static tfa_daemon d;
    char path[32];
    const int fd = memfd_create("config", MFD_CLOEXEC);
    require(fd >= 0 && write(fd, text, sizeof text - 1) == sizeof text - 1);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    require(config_load(path, stderr, &d.settings) == TFA_OK);
    require(robot_set_load(d.settings, NULL, &d.robot_set) == TFA_OK);
    require(statistics_open(&d) == TFA_OK && daemon_start_workers(&d) == TFA_OK);
    d.epoll = epoll_create1(EPOLL_CLOEXEC);
    require(d.epoll >= 0);
    return &d;
}

static void close_welcome(struct msghdr *message)
{
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        int fds[TFA_WELCOME_DESCRIPTORS];
        require(c->cmsg_len == CMSG_LEN(sizeof fds));
        memcpy(fds, CMSG_DATA(c), sizeof fds);
        for (int i = 0; i < TFA_WELCOME_DESCRIPTORS; i++)
            close(fds[i]);
    }
}

/* The answer to the HELLO. @return its status */
static int receive(int socket)
{
    union {
        char bytes[CMSG_SPACE(sizeof(int) * TFA_WELCOME_DESCRIPTORS)];
        struct cmsghdr align;
    } control;
    tfa_welcome w;
    struct iovec part = {.iov_base = &w, .iov_len = sizeof w};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    require(recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC) == (ssize_t)sizeof w);
    require(is_known_status(w.status) && (w.status == TFA_OK) == (w.text[0] == 0));
    close_welcome(&message);
    return w.status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static tfa_daemon *d;
    int ends[2];
    if (!d)
        d = open_daemon();
    if (size == 0 || size > 4096)
        return 0;
    require(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    require(send(ends[1], data, size, 0) == (ssize_t)size);
    d->connect_rate = (tfa_connect_rate){0};
    session_begin(d, 0, ends[0]);
    require(d->session_count == 1);
    session_event(d, d->sessions);
    const int status = receive(ends[1]);
    require((status == TFA_OK) == (d->session_count == 1));
    close(ends[1]);
    if (status == TFA_OK)
        session_event(d, d->sessions); /* it hung up */
    while (d->session_count)
        session_tick(d);
    return 0;
}
