/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operators: their connections, and the status that they ask for.
 */
#ifndef TFA_SERVICE_CONTROL_COMMANDS_H
#define TFA_SERVICE_CONTROL_COMMANDS_H

#include <sys/types.h>

#include "control/robot_set.h"

#define COMMANDS_MAX 8         /* at once */
#define COMMANDS_DESCRIPTORS 2 /* of one answer at most */

/* A connection on the control socket of operators. */
typedef struct command {
    int socket;
    uid_t user;
    bool waits; /* for the end of a reload */
    uint64_t since;
} command;

/* None yet. The first thing: everything may end from then on. */
void commands_open(tfa_daemon *d);
TFA_CHECKED int commands_listen(tfa_daemon *d);
void commands_unlisten(tfa_daemon *d);
/* Takes a connection. Without a free place the oldest silent one of the user with most of them
 * ends, but none of an operator for another user; those that wait for a reload stay. */
void commands_accept(tfa_daemon *d);
/* Something happened at `what`. @return it is a command's connection */
bool commands_event(tfa_daemon *d, void *what);
/* A reload ended: answers those that wait for it. */
void commands_reloaded(tfa_daemon *d, const char *text);
void commands_tick(tfa_daemon *d);
void commands_close(tfa_daemon *d);
/* Sends a text with descriptors. @return whether the peer's buffer took it */
bool commands_send(int socket, const char *text, const int *descriptors, size_t count);

/* Writes the status as JSON; free(*text). @return TFA_OK; TFA_E_MEMORY */
TFA_CHECKED int status_write(const tfa_daemon *d, char **text, size_t *size);

#endif
