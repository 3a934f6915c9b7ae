/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Who could have put code where it lies? Only root and the user of this process may: the file and
 * every folder on the way to it are looked at, each opened from the one above and never through a
 * link, so that what was looked at is what is there.
 */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "own/own.h"

/* In a folder with the sticky bit only its owner and an entry's may rename or remove the entry: good
 * enough for a folder above, whose next entry is judged, too; not for the one that is searched. */
static int judge(const char *path, size_t length, const struct stat *s, uid_t user, int above,
                 struct own_reason *why)
{
    const int sticky = above && S_ISDIR(s->st_mode) && s->st_mode & S_ISVTX;
    const int shown = length ? (int)length : 1;
    if (s->st_uid != 0 && s->st_uid != user)
        return own_refuse(
            why, TFA_E_REFUSED,
            "'%.*s' belongs to user %u, neither to root nor to the user of this process "
            "(%u): chown it",
            shown, path, (unsigned)s->st_uid, (unsigned)user);
    if (s->st_mode & (S_IWGRP | S_IWOTH) && !sticky)
        return own_refuse(why, TFA_E_REFUSED,
                          "'%.*s' can be written by others (mode %04o): chmod go-w", shown, path,
                          (unsigned)(s->st_mode & 07777));
    if (!S_ISREG(s->st_mode) && !S_ISDIR(s->st_mode))
        return own_refuse(why, TFA_E_REFUSED, "'%.*s' is neither a file nor a folder", shown, path);
    return TFA_OK;
}

/* The entry that ends at `end`, opened from the folder above. */
static int descend(int folder, const char *path, size_t start, size_t end)
{
    char name[NAME_MAX + 1];
    if (end - start > NAME_MAX) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(name, path + start, end - start);
    name[end - start] = '\0';
    return openat(folder, name, O_PATH | O_NOFOLLOW | O_CLOEXEC);
}

static int look(int at, const char *path, size_t length, uid_t user, int above,
                struct own_reason *why)
{
    struct stat s;
    if (fstat(at, &s) != 0)
        return own_refuse(why, TFA_E_FILE, "'%.*s': %s", (int)length, path, strerror(errno));
    return judge(path, length, &s, user, above, why);
}

/* All of an absolute path without links, or all but its last entry. */
static int walk(const char *path, uid_t user, int whole, struct own_reason *why)
{
    int at = open("/", O_PATH | O_DIRECTORY | O_CLOEXEC);
    int status = at < 0 ? TFA_E_FILE : look(at, path, 0, user, 1, why);
    for (size_t end = 0; status == TFA_OK && path[end];) {
        const size_t start = end + 1;
        end = start + strcspn(path + start, "/");
        const int last = !path[end];
        if (start == end || (last && !whole))
            break;
        const int next = descend(at, path, start, end);
        if (next < 0) {
            status = own_refuse(why, TFA_E_FILE, "'%.*s': %s", (int)end, path, strerror(errno));
            break;
        }
        close(at);
        at = next;
        status = look(at, path, end, user, !last, why);
    }
    if (at >= 0)
        close(at);
    return status;
}

int own_trust(const char *path, uid_t user, struct own_reason *why)
{
    char resolved[PATH_MAX];
    if (!realpath(path, resolved))
        return own_refuse(why, TFA_E_FILE, "'%s': %s", path, strerror(errno));
    return walk(resolved, user, 1, why);
}

int own_trust_open(int file, const char *path, uid_t user, struct own_reason *why)
{
    const int status = walk(path, user, 0, why);
    return status == TFA_OK ? look(file, path, strlen(path), user, 0, why) : status;
}

int tfa_specialised_trust(const char *path, char *reason, size_t size)
{
    struct own_reason why = {reason, size};
    if (size)
        reason[0] = '\0';
    return path ? own_trust(path, geteuid(), &why) : TFA_E_ARGUMENT;
}
