/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Admission of clients.
 */
#include "control/admission.h"

#include <grp.h>
#include <pwd.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "platform/log.h"

/* Linux gives no more groups to a process (NGROUPS_MAX is 65536; few have more than these). */
#define GROUPS_MAX 1024

static int report_unknown(const config *c, const char *key, size_t index, const char *name)
{
    char path[64], location[512];
    snprintf(path, sizeof path, "%s[%zu]", key, index);
    config_location(c, path, location, sizeof location);
    tfa_log(TFA_LOG_ERROR, "%s: %s: '%s' does not exist on this machine; getent %s lists the names",
            location, path, name, key[6] == 'u' ? "passwd" : "group");
    return TFA_E_ARGUMENT;
}

/* User of the daemon and group of its sockets */
typedef struct door {
    uid_t user;
    gid_t group;
} door;

/* A check may run as another user: the runtime directory belongs to the daemon's. */
static door find_door(const config *c)
{
    struct stat info;
    const struct passwd *user = NULL;
    const struct group *group = c->group ? getgrnam(c->group) : NULL;
    if (c->user && geteuid() == 0)
        user = getpwnam(c->user);
    else if (stat(c->runtime_dir, &info) == 0 && info.st_uid != geteuid())
        user = getpwuid(info.st_uid);
    door d = user ? (door){user->pw_uid, user->pw_gid} : (door){geteuid(), getegid()};
    d.group = group ? group->gr_gid : d.group;
    return d;
}

static bool opens(const door *d, const struct passwd *user)
{
    gid_t groups[GROUPS_MAX];
    int count = GROUPS_MAX;
    if (user->pw_uid == 0 || user->pw_uid == d->user)
        return true;
    if (getgrouplist(user->pw_name, user->pw_gid, groups, &count) < 0)
        return true; /* of more groups than these: unknown */
    for (int i = 0; i < count; i++)
        if (groups[i] == d->group)
            return true;
    return false;
}

/* The lists narrow what the mode of the sockets lets in, and cannot widen it. */
static void warn_kept_out(const config *c, const door *d, const char *key, size_t index,
                          const char *user)
{
    const struct group *entry = getgrgid(d->group);
    const char *group = entry ? entry->gr_name : "GROUP";
    char path[64], location[512];
    snprintf(path, sizeof path, "%s[%zu]", key, index);
    config_location(c, path, location, sizeof location);
    tfa_log(TFA_LOG_WARNING,
            "%s: %s: user '%s' cannot open the sockets: their mode is 0660 and their group %u "
            "('%s'); adduser %s %s, or name a group of theirs with 'group'",
            location, path, user, (unsigned)d->group, group, user, group);
}

static int find_users(const config *c, const door *d, tfa_admission *a)
{
    int status = TFA_OK;
    for (size_t i = 0; i < c->allow_users_count; i++) {
        const char *name = c->allow_users[i];
        const struct passwd *entry = getpwnam(name);
        if (!entry) {
            status = report_unknown(c, "allow_users", i, name);
            continue;
        }
        a->users[a->user_count++] = entry->pw_uid;
        if (!opens(d, entry))
            warn_kept_out(c, d, "allow_users", i, name);
    }
    return status;
}

static int find_groups(const config *c, const door *d, tfa_admission *a)
{
    int status = TFA_OK;
    for (size_t i = 0; i < c->allow_groups_count; i++) {
        const struct group *entry = getgrnam(c->allow_groups[i]);
        if (!entry) {
            status = report_unknown(c, "allow_groups", i, c->allow_groups[i]);
            continue;
        }
        a->groups[a->group_count++] = entry->gr_gid;
        for (char **member = entry->gr_mem; *member; member++) {
            const struct passwd *user = getpwnam(*member);
            if (user && !opens(d, user)) {
                warn_kept_out(c, d, "allow_groups", i, user->pw_name);
                break; /* one is enough, and `entry` has gone */
            }
        }
    }
    return status;
}

static int find_names(const config *c, tfa_admission *a)
{
    const door d = find_door(c);
    const int users = find_users(c, &d, a), groups = find_groups(c, &d, a);
    return users != TFA_OK ? users : groups;
}

int tfa_admission_load(const config *settings, tfa_admission *admission)
{
    *admission = (tfa_admission){
        .users = calloc(settings->allow_users_count + 1, sizeof *admission->users),
        .groups = calloc(settings->allow_groups_count + 1, sizeof *admission->groups)};
    int status = admission->users && admission->groups ? TFA_OK : TFA_E_MEMORY;
    if (status == TFA_OK)
        status = find_names(settings, admission);
    if (status != TFA_OK)
        tfa_admission_free(admission);
    return status;
}

void tfa_admission_free(tfa_admission *admission)
{
    free(admission->users);
    free(admission->groups);
    *admission = (tfa_admission){0};
}

static double tokens_of(const tfa_connect_rate *rate, uint32_t k, uint32_t per_second, uint64_t now)
{
    const double burst = 2.0 * per_second;
    const double elapsed = (double)(now - rate->row[k].when) * 1e-9;
    const double tokens = rate->row[k].tokens + elapsed * per_second;
    return rate->row[k].when == 0 || tokens > burst ? burst : tokens;
}

bool tfa_connect_rate_allows(tfa_connect_rate *rate, uid_t user, uint32_t per_second, uint64_t now)
{
    uint32_t row = 0;
    double most = -1;
    for (uint32_t k = 0; k < TFA_CONNECT_USERS; k++) {
        const double tokens = tokens_of(rate, k, per_second, now);
        if (rate->row[k].user == user && rate->row[k].when != 0) {
            row = k;
            break;
        }
        row = tokens > most ? k : row;
        most = tokens > most ? tokens : most;
    }
    if (rate->row[row].user != user)
        rate->row[row].when = 0;
    const double tokens = tokens_of(rate, row, per_second, now);
    rate->row[row].user = user;
    rate->row[row].when = now;
    rate->row[row].tokens = tokens >= 1 ? tokens - 1 : tokens;
    return tokens >= 1;
}

bool tfa_is_operator(uid_t user)
{
    return user == 0 || user == geteuid();
}

uint64_t tfa_share_of(uint64_t total, uint64_t others, uid_t user)
{
    const uint64_t kept = tfa_is_operator(user) ? 0 : total / 16;
    const uint64_t left = total - kept > others ? total - kept - others : 0;
    return tfa_is_operator(user) ? left : left / 2 + left % 2;
}

static bool has_group(const tfa_admission *a, gid_t group)
{
    for (size_t i = 0; i < a->group_count; i++)
        if (a->groups[i] == group)
            return true;
    return false;
}

bool tfa_admission_allows(const tfa_admission *a, int socket, uid_t user, gid_t group)
{
    gid_t groups[GROUPS_MAX];
    socklen_t size = sizeof groups;
    if ((!a->user_count && !a->group_count) || tfa_is_operator(user))
        return true;
    for (size_t i = 0; i < a->user_count; i++)
        if (a->users[i] == user)
            return true;
    if (has_group(a, group))
        return true;
    if (!a->group_count || getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups, &size) != 0)
        return false;
    for (size_t i = 0; i < size / sizeof *groups; i++)
        if (has_group(a, groups[i]))
            return true;
    return false;
}
