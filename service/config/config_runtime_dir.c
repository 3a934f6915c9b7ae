/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory: the configured one or the default, and whether its sockets' paths fit
 * addresses.
 */
#include <stdlib.h>
#include <string.h>
#include <sys/un.h>
#include <unistd.h>

#include "config_read.h"
#include "ipc/control_socket.h"
#include "ipc/handshake.h"

#define PATH_LENGTH_MAX (sizeof(((struct sockaddr_un *)0)->sun_path) - 1)

typedef char socket_name[TFA_ROBOT_NAME_MAX + 6];

/* The variable that decides where the file does not; NULL: none. */
static const char *deciding_variable(void)
{
    const char *given = getenv("TOTALFORCE_RUNTIME_DIR"), *xdg = getenv("XDG_RUNTIME_DIR");
    if (given && *given)
        return "TOTALFORCE_RUNTIME_DIR";
    return geteuid() != 0 && xdg && *xdg ? "XDG_RUNTIME_DIR" : NULL;
}

int config_set_runtime_dir(config *c)
{
    const char *variable = deciding_variable();
    if (c->runtime_dir)
        return TFA_OK;
    const bool of_user = variable && strcmp(variable, "XDG_RUNTIME_DIR") == 0;
    if (asprintf(&c->default_dir, "%s%s", variable ? getenv(variable) : TFA_DEFAULT_RUNTIME_DIR,
                 of_user ? "/totalforce" : "") < 0)
        c->default_dir = NULL;
    c->runtime_dir = c->default_dir;
    return c->default_dir ? TFA_OK : TFA_E_MEMORY;
}

/* ---- the longest path ---- */

/* A name that is too long has an error of its own. */
static void keep_longer(socket_name longest, const char *robot, const char *scene)
{
    socket_name name;
    const int n = snprintf(name, sizeof name, "%s%s%s.sock", robot, *scene ? "." : "", scene);
    if (n < (int)sizeof name && strlen(name) > strlen(longest))
        strcpy(longest, name);
}

/* Names that could not be read are NULL. */
static void find_longest(const config *c, socket_name longest)
{
    strcpy(longest, TFA_CONTROL_SOCKET);
    for (size_t i = 0; i < c->robots_count; i++) {
        const config_robot *robot = &c->robots[i];
        if (robot->name)
            keep_longer(longest, robot->name, "");
        for (size_t k = 0; robot->name && k < robot->scenes_count; k++)
            if (robot->scenes[k].name)
                keep_longer(longest, robot->name, robot->scenes[k].name);
    }
}

void config_check_runtime_dir(config_reader *r, const config *c)
{
    socket_name longest;
    char text[300];
    find_longest(c, longest);
    const size_t directory = strlen(c->runtime_dir), file = 1 + strlen(longest);
    if (*c->runtime_dir != '/')
        snprintf(text, sizeof text,
                 "'%.200s' is not absolute, and clients have other working directories: begin it "
                 "with '/'",
                 c->runtime_dir);
    else if (directory + file > PATH_LENGTH_MAX)
        snprintf(text, sizeof text,
                 "%zu characters, with '/%s' %zu; the path of a socket has at most %zu: choose a "
                 "runtime_dir of at most %zu",
                 directory, longest, directory + file, PATH_LENGTH_MAX, PATH_LENGTH_MAX - file);
    else
        return;
    if (c->runtime_dir != c->default_dir) {
        config_error(r, "runtime_dir", "%s", text);
        return;
    }
    /* the default without a variable is short */
    fprintf(r->errors, "%s: %s: %s\n", r->file, deciding_variable(), text);
    r->count++;
}
