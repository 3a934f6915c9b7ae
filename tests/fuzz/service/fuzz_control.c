/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: the control socket of operators. The input says what its peers do: connect,
 * send any packet, hang up, wait. Each answer is one of the documented kinds, nothing but the word
 * stops the daemon, and every connection is closed in the end.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "control/daemon.h"
#include "fuzz_service.h"
#include "ipc/control_socket.h"

#define PEERS (COMMANDS_MAX + 2) /* some are hung up on */
#define HALF_SECOND 500000000u

typedef struct bytes {
    const uint8_t *data;
    size_t size;
} bytes;

static tfa_daemon d;
static struct sockaddr_un address;
static socklen_t address_size = sizeof address;
static int peers[PEERS];
static uint64_t now;
static bool may_stop, reloading;

/* ---- what the daemon has instead of a clock, a thread that reloads and one that runs out of
 * descriptors ---- */

uint64_t control_clock(void)
{
    return now;
}

void reload_request(tfa_daemon *daemon)
{
    require(daemon == &d);
    reloading = true;
}

int control_accept(tfa_daemon *daemon, int listener)
{
    require(daemon == &d);
    return accept4(listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
}

/* ---- the daemon ---- */

static void load_robots(void)
{
    static const char text[] = "log: error\nrobots:\n  - name: arm\n    urdf: " TFA_SOURCE_DIR
                               "/config/robots/arm7.urdf\n";
    char path[32];
    const int fd = memfd_create("config", MFD_CLOEXEC);
    require(fd >= 0 && write(fd, text, sizeof text - 1) == sizeof text - 1);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    require(config_load(path, stderr, &d.settings) == TFA_OK);
    require(robot_set_load(d.settings, NULL, &d.robot_set) == TFA_OK);
    require(statistics_open(&d) == TFA_OK && daemon_start_workers(&d) == TFA_OK);
    close(fd);
}

static void open_daemon(void)
{
    commands_open(&d);
    load_robots();
    address.sun_family = AF_UNIX; /* without a path the kernel chooses an abstract name */
    d.command_listener = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    d.epoll = epoll_create1(EPOLL_CLOEXEC);
    require(d.command_listener >= 0 && d.epoll >= 0);
    require(bind(d.command_listener, (struct sockaddr *)&address, sizeof address.sun_family) == 0);
    require(listen(d.command_listener, PEERS) == 0);
    require(getsockname(d.command_listener, (struct sockaddr *)&address, &address_size) == 0);
    for (int i = 0; i < PEERS; i++)
        peers[i] = -1;
}

static void dispatch(void)
{
    struct epoll_event events[PEERS];
    for (int turn = 0; turn < PEERS; turn++) {
        const int n = epoll_wait(d.epoll, events, PEERS, 0);
        for (int i = 0; i < n; i++)
            require(commands_event(&d, events[i].data.ptr) ||
                    recordings_event(&d, events[i].data.ptr));
        recordings_tick(&d);
    }
    require(may_stop || !d.stop);
    d.stop = false;
}

/* ---- its peers ---- */

static bool starts_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

static void read_answers(int peer)
{
    static char text[TFA_CONTROL_TEXT_MAX + 1];
    ssize_t n;
    while ((n = recv(peer, text, sizeof text - 1, MSG_DONTWAIT)) > 0) {
        text[n] = 0;
        require(starts_with(text, "{\n") || starts_with(text, "ok") ||
                starts_with(text, "error: "));
    }
}

static void hang_up(int *peer)
{
    if (*peer >= 0)
        close(*peer);
    *peer = -1;
}

static void say(int *peer, bytes *b)
{
    const size_t wanted = b->size ? b->data[0] : 0;
    const size_t size = wanted < b->size ? wanted : b->size ? b->size - 1 : 0;
    if (*peer < 0) {
        *peer = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
        require(connect(*peer, (struct sockaddr *)&address, address_size) == 0);
        commands_accept(&d);
    }
    if (b->size) {
        /* taps of a few MiB: a fuzzer has no memory for others */
        const bool large =
            size > sizeof "record arm 1" - 1 && memcmp(b->data + 1, "record", 6) == 0;
        may_stop = may_stop || (size >= 4 && memcmp(b->data + 1, "stop", 4) == 0);
        if (!large)
            (void)!send(*peer, b->data + 1, size, MSG_NOSIGNAL | MSG_DONTWAIT);
        b->data += 1 + size;
        b->size -= 1 + size;
    }
}

static void pass_time(uint64_t ns)
{
    now += ns;
    commands_tick(&d);
}

static void act(uint8_t action, bytes *b)
{
    int *peer = &peers[action % PEERS];
    switch (action / PEERS % 8) {
    case 4:
        hang_up(peer);
        break;
    case 5:
        pass_time(HALF_SECOND);
        break;
    case 6:
        if (reloading)
            commands_reloaded(&d, "ok: 1 of 1 models exchanged");
        reloading = false;
        break;
    case 7:
        if (*peer >= 0)
            (void)shutdown(*peer, SHUT_WR);
        break;
    default:
        say(peer, b);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes b = {data, size};
    if (!d.settings)
        open_daemon();
    may_stop = reloading = false;
    while (b.size) {
        const uint8_t action = *b.data++;
        b.size--;
        act(action, &b);
        dispatch();
        for (int i = 0; i < PEERS; i++)
            if (peers[i] >= 0)
                read_answers(peers[i]);
    }
    for (int i = 0; i < PEERS; i++)
        hang_up(&peers[i]);
    dispatch();
    for (int i = 0; i < COMMANDS_MAX; i++)
        require(d.commands[i].socket < 0);
    return 0;
}
