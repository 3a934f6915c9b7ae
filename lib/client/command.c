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
#include <unistd.h>

#include "client/client.h"
#include "ipc/control_socket.h"

#define DEFAULT_TIMEOUT_MS 10000

static int connect_to(const char *directory, int *out)
{
    *out = tfa_control_connect(directory);
    if (*out >= 0)
        return TFA_OK;
    if (errno == ENAMETOOLONG)
        return TFA_E_ARGUMENT;
    if (errno == ENOENT || errno == ECONNREFUSED || errno == ENOTDIR)
        return TFA_E_DISCONNECTED;
    return errno == EACCES || errno == EPERM ? TFA_E_REFUSED : TFA_E_SYSTEM;
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
    const ssize_t length = tfa_control_receive(fd, text, size, descriptor, 1);
    if (length <= 0)
        return length == 0 || errno == ECONNRESET ? TFA_E_DISCONNECTED : TFA_E_SYSTEM;
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
    char *directory = tfa_find_runtime_dir(runtime_dir, TFA_CONTROL_NAME);
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
