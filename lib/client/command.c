/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Commands for a daemon, by its control socket.
 */
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "client/client.h"
#include "ipc/control_socket.h"

#define DEFAULT_TIMEOUT_MS 10000

static int connect_to(const char *directory, int *out)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int n =
        snprintf(address.sun_path, sizeof address.sun_path, "%s/" TFA_CONTROL_SOCKET, directory);
    if (n < 0 || (size_t)n >= sizeof address.sun_path)
        return TFA_E_ARGUMENT;
    *out = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (*out < 0)
        return TFA_E_SYSTEM;
    if (connect(*out, (const struct sockaddr *)&address, sizeof address) == 0)
        return TFA_OK;
    if (errno == ENOENT || errno == ECONNREFUSED || errno == ENOTDIR)
        return TFA_E_DISCONNECTED;
    return errno == EACCES || errno == EPERM ? TFA_E_REFUSED : TFA_E_SYSTEM;
}

/* Receives a packet, and the descriptor that comes with it: -1 where there is none. */
static ssize_t receive(int fd, char *text, size_t size, int *descriptor)
{
    union {
        char bytes[CMSG_SPACE(sizeof(int))];
        struct cmsghdr align;
    } control;
    struct iovec part = {.iov_base = text, .iov_len = size};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    *descriptor = -1;
    const ssize_t length = recvmsg(fd, &message, MSG_CMSG_CLOEXEC);
    const struct cmsghdr *c = length >= 0 ? CMSG_FIRSTHDR(&message) : NULL;
    if (c && c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS &&
        c->cmsg_len == CMSG_LEN(sizeof(int)))
        memcpy(descriptor, CMSG_DATA(c), sizeof(int));
    return length;
}

static int exchange(int fd, const char *command, int timeout_ms, char *text, size_t size,
                    int *descriptor)
{
    struct pollfd ready = {.fd = fd, .events = POLLIN};
    int n;
    if (send(fd, command, strlen(command), MSG_NOSIGNAL) < 0)
        return errno == EPIPE || errno == ECONNRESET ? TFA_E_DISCONNECTED : TFA_E_SYSTEM;
    do
        n = poll(&ready, 1, timeout_ms);
    while (n < 0 && errno == EINTR);
    if (n == 0)
        return TFA_E_TIMEOUT;
    const ssize_t length = receive(fd, text, size - 1, descriptor);
    if (length <= 0)
        return length == 0 || errno == ECONNRESET ? TFA_E_DISCONNECTED : TFA_E_SYSTEM;
    text[length] = 0;
    return strncmp(text, "error", 5) == 0 ? TFA_E_REFUSED : TFA_OK;
}

int tfa_daemon_ask(const char *runtime_dir, const char *command, int32_t timeout_ms, char *text,
                   size_t size, int *descriptor)
{
    int fd = -1;
    *descriptor = -1;
    if (!command || !text || size == 0)
        return TFA_E_ARGUMENT;
    *text = 0;
    char *directory = tfa_client_runtime_dir(runtime_dir, TFA_CONTROL_NAME);
    if (!directory)
        return TFA_E_MEMORY;
    int status = connect_to(directory, &fd);
    if (status == TFA_OK)
        status = exchange(fd, command, timeout_ms ? timeout_ms : DEFAULT_TIMEOUT_MS, text, size,
                          descriptor);
    const int saved = errno;
    if (fd >= 0)
        close(fd);
    free(directory);
    errno = saved;
    return status;
}

int tfa_daemon_command(const char *runtime_dir, const char *command, int32_t timeout_ms, char *text,
                       size_t size)
{
    int descriptor;
    const int status = tfa_daemon_ask(runtime_dir, command, timeout_ms, text, size, &descriptor);
    if (descriptor >= 0)
        close(descriptor);
    return status;
}
