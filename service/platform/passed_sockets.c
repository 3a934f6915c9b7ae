/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Listening sockets of the service manager.
 */
#include "passed_sockets.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#ifdef TFA_HAVE_SYSTEMD
#include <systemd/sd-daemon.h>
#endif

#include "ipc/handshake.h"
#include "log.h"

typedef struct passed_socket {
    char name[TFA_ROBOT_NAME_MAX + 1]; /* of the robot */
    int fd;                            /* -1: claimed */
} passed_socket;

static passed_socket *list;
static size_t count;

/* ---- one socket ---- */

static int refuse(int fd, const char *socket, const char *reason)
{
    tfa_log(TFA_LOG_ERROR, "socket %d%s%s%s, which the service manager passed: %s", fd,
            *socket ? " (" : "", socket, *socket ? ")" : "", reason);
    return TFA_E_ARGUMENT;
}

static int option_of(int fd, int option)
{
    int value = -1;
    socklen_t size = sizeof value;
    return getsockopt(fd, SOL_SOCKET, option, &value, &size) == 0 ? value : -1;
}

static const char *wrong_type(int type)
{
    switch (type) {
    case SOCK_STREAM:
        return "is a stream (SOCK_STREAM); the unit needs ListenSequentialPacket=";
    case SOCK_DGRAM:
        return "takes datagrams (SOCK_DGRAM); the unit needs ListenSequentialPacket=";
    default:
        return "is not of type SOCK_SEQPACKET; the unit needs ListenSequentialPacket=";
    }
}

static bool is_in(int directory, const char *path)
{
    struct stat ours, there;
    char copy[sizeof(((struct sockaddr_un *)0)->sun_path) + 1];
    strcpy(copy, path);
    return fstat(directory, &ours) == 0 && stat(dirname(copy), &there) == 0 &&
           ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

static int take_socket(passed_socket *s, int fd, int directory, const char *path)
{
    struct sockaddr_un address = {0};
    socklen_t size = sizeof address;
    char text[sizeof address.sun_path + 1] = "";
    if (getsockname(fd, (struct sockaddr *)&address, &size) != 0 || address.sun_family != AF_UNIX)
        return refuse(fd, "", "not a Unix socket; the unit needs ListenSequentialPacket=");
    memcpy(text, address.sun_path, sizeof address.sun_path);
    if (option_of(fd, SO_TYPE) != SOCK_SEQPACKET)
        return refuse(fd, text, wrong_type(option_of(fd, SO_TYPE)));
    if (option_of(fd, SO_ACCEPTCONN) != 1)
        return refuse(fd, text, "does not listen; the unit needs Accept=no");
    const char *base = strrchr(text, '/');
    const size_t length = base ? strlen(base + 1) : 0;
    if (length <= 5 || strcmp(base + 1 + length - 5, ".sock") != 0 ||
        length - 5 >= sizeof s->name || !is_in(directory, text)) {
        tfa_log(TFA_LOG_ERROR, "the sockets of the runtime directory are %s/ROBOT.sock", path);
        return refuse(fd, text, "lies elsewhere; correct the unit, or runtime_dir");
    }
    memcpy(s->name, base + 1, length - 5);
    s->name[length - 5] = '\0';
    s->fd = fd;
    if (fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK) != 0)
        return refuse(fd, text, strerror(errno));
    return TFA_OK;
}

/* ---- all of them ---- */

#ifdef TFA_HAVE_SYSTEMD
/* How many sockets were passed; -1: unreadable, and the log has the error. Without it the daemon
 * would fail later, at a path where the service manager listens. */
static int count_passed(void)
{
    char number[32], process[32]; /* sd_listen_fds removes the variables */
    const char *n = getenv("LISTEN_FDS"), *p = getenv("LISTEN_PID");
    snprintf(number, sizeof number, "%s", n ? n : "");
    snprintf(process, sizeof process, "%s", p ? p : "");
    const int passed = sd_listen_fds(1);
    if (passed >= 0)
        return passed;
    tfa_log(TFA_LOG_ERROR,
            "LISTEN_FDS '%s', LISTEN_PID '%s': %s; both must be numbers, and the sockets open from "
            "descriptor %d on: correct the program that starts the daemon, or unset both",
            number, process, strerror(-passed), SD_LISTEN_FDS_START);
    return -1;
}
#endif

int tfa_passed_sockets_take(int directory, const char *path)
{
#ifdef TFA_HAVE_SYSTEMD
    const int passed = count_passed();
    if (passed <= 0)
        return passed == 0 ? TFA_OK : TFA_E_ARGUMENT;
    list = calloc((size_t)passed, sizeof *list);
    if (!list)
        return TFA_E_MEMORY;
    for (int i = 0; i < passed; i++) {
        const int status = take_socket(&list[count], SD_LISTEN_FDS_START + i, directory, path);
        if (status != TFA_OK)
            return status;
        count++;
    }
    tfa_log(TFA_LOG_INFO, "the service manager passed %zu sockets", count);
#else
    (void)take;
    (void)directory;
    (void)path;
#endif
    return TFA_OK;
}

static passed_socket *find(const char *name)
{
    for (size_t i = 0; i < count; i++)
        if (strcmp(list[i].name, name) == 0)
            return &list[i];
    return NULL;
}

int tfa_passed_socket_claim(const char *name)
{
    passed_socket *s = find(name);
    const int fd = s ? s->fd : -1;
    if (s)
        s->fd = -1;
    return fd;
}

bool tfa_passed_socket_is(const char *name)
{
    return find(name) != NULL;
}

int tfa_passed_sockets_check(void)
{
    int status = TFA_OK;
    for (size_t i = 0; i < count; i++)
        if (list[i].fd >= 0) {
            char socket[TFA_ROBOT_NAME_MAX + 6];
            snprintf(socket, sizeof socket, "%s.sock", list[i].name);
            status = refuse(list[i].fd, socket,
                            "the configuration has no such robot; correct the unit, or 'robots'");
        }
    return status;
}

void tfa_passed_sockets_forget(void)
{
    for (size_t i = 0; i < count; i++)
        if (list[i].fd >= 0)
            close(list[i].fd);
    free(list);
    list = NULL;
    count = 0;
}
