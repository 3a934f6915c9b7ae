/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The side of the control socket's peers.
 */
#include "ipc/control_socket.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

/* Folder of a user's own daemon (the default of a daemon that is not root); NULL: it has no such
 * socket. */
static char *user_daemon_dir(const char *name)
{
    const char *xdg = getenv("XDG_RUNTIME_DIR");
    char *directory = NULL, *socket = NULL;
    if (geteuid() == 0 || !xdg || !*xdg || asprintf(&directory, "%s/totalforce", xdg) < 0)
        return NULL;
    int found = asprintf(&socket, "%s/%s.sock", directory, name) >= 0 && access(socket, F_OK) == 0;
    free(socket);
    if (found)
        return directory;
    free(directory);
    return NULL;
}

char *tfa_find_runtime_dir(const char *directory, const char *name)
{
    if (directory)
        return strdup(directory);
    const char *given = getenv("TOTALFORCE_RUNTIME_DIR");
    if (given && *given)
        return strdup(given);
    char *user_dir = user_daemon_dir(name);
    return user_dir ? user_dir : strdup(TFA_DEFAULT_RUNTIME_DIR);
}

int tfa_control_connect(const char *directory)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int n =
        snprintf(address.sun_path, sizeof address.sun_path, "%s/" TFA_CONTROL_SOCKET, directory);
    if (n < 0 || (size_t)n >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        const int saved = errno;
        close(fd);
        errno = saved;
        return -1;
    }
    return fd;
}

ssize_t tfa_control_receive(int socket, char *text, size_t size, int *descriptors, uint32_t count)
{
    union {
        char bytes[CMSG_SPACE(TFA_CONTROL_DESCRIPTORS_MAX * sizeof(int))];
        struct cmsghdr align;
    } control;
    const size_t bytes = count * sizeof(int);
    struct iovec part = {.iov_base = text, .iov_len = size - 1};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = CMSG_SPACE(bytes)};
    memset(descriptors, -1, bytes);
    const ssize_t length = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
    if (length < 0)
        return -1;
    text[length] = 0;
    const struct cmsghdr *c = CMSG_FIRSTHDR(&message);
    if (c && c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS &&
        c->cmsg_len == CMSG_LEN(bytes))
        memcpy(descriptors, CMSG_DATA(c), bytes);
    return length;
}
