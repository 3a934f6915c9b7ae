/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Admission of clients: allowed users and groups of the configuration, by the credentials that the
 * kernel gives for a socket.
 */
#ifndef TFA_SERVICE_CONTROL_ADMISSION_H
#define TFA_SERVICE_CONTROL_ADMISSION_H

#include <stdbool.h>
#include <sys/types.h>

#include "config/config.h"

typedef struct tfa_admission {
    uid_t *users;
    gid_t *groups;
    size_t user_count, group_count;
} tfa_admission;

#define TFA_CONNECT_USERS 64

/** Connections of users: each may make `burst` at once and `per_second` from then on. */
typedef struct tfa_connect_rate {
    struct {
        uid_t user;
        double tokens;
        uint64_t when; /**< CLOCK_MONOTONIC ns of the last connection; 0: the row is free */
    } row[TFA_CONNECT_USERS];
} tfa_connect_rate;

/** Takes a connection of this user at `now` into account. Of more users than rows, those that could
 *  connect most at once are forgotten. @return whether it is within the rate */
bool tfa_connect_rate_allows(tfa_connect_rate *rate, uid_t user, uint32_t per_second, uint64_t now);

/** root and the daemon's own user: they tell the daemon what to do. */
bool tfa_is_operator(uid_t user);

/** The most that a user may have of `total` (clients, bytes) of which other users have `others`:
 *  half of what they leave, rounded up, so that no two users take all; the last sixteenth is kept
 *  for operators, who may have all that is left. */
uint64_t tfa_share_of(uint64_t total, uint64_t others, uid_t user);

/** Looks the names of `allow_users` and `allow_groups` up; logs the place of one that does not
 *  exist, and warns of users whom the sockets' group keeps out. @return TFA_OK; TFA_E_ARGUMENT;
 *  TFA_E_MEMORY. On error *admission is empty. */
TFA_CHECKED int tfa_admission_load(const config *settings, tfa_admission *admission);
void tfa_admission_free(tfa_admission *admission);

/** May the process at the other end of this socket, which runs as `user` and `group`, connect? Its
 *  other groups are asked for. */
bool tfa_admission_allows(const tfa_admission *admission, int socket, uid_t user, gid_t group);

#endif
