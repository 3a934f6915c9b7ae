/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Ownership check of executable code: only root and the user of this process may own it. The file
 * and every folder above it are checked, each opened from the folder above without following links,
 * so that the checked entries are the ones in use.
 */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "specialised/specialised_internal.h"

/* The sticky bit lets only the owners of a folder and of an entry rename the entry. That suffices
 * for a folder above, whose next entry is checked as well; not for the searched folder itself. */
static int check_permissions(const char *path, size_t length, const struct stat *s, uid_t user,
                             int above, struct error_text *err)
{
    const int sticky = above && S_ISDIR(s->st_mode) && s->st_mode & S_ISVTX;
    const int shown = length ? (int)length : 1;
    if (s->st_uid != 0 && s->st_uid != user)
        return refuse(err, TFA_E_REFUSED,
                      "'%.*s' belongs to user %u, neither to root nor to the user of this "
                      "process (%u): chown it",
                      shown, path, (unsigned)s->st_uid, (unsigned)user);
    if (s->st_mode & (S_IWGRP | S_IWOTH) && !sticky)
        return refuse(err, TFA_E_REFUSED, "'%.*s' can be written by others (mode %04o): chmod go-w",
                      shown, path, (unsigned)(s->st_mode & 07777));
    if (!S_ISREG(s->st_mode) && !S_ISDIR(s->st_mode))
        return refuse(err, TFA_E_REFUSED, "'%.*s' is neither a file nor a folder", shown, path);
    return TFA_OK;
}

/* Opens the entry that ends at `end` from the folder above. */
static int open_entry(int folder, const char *path, size_t start, size_t end)
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

static int check_entry(int at, const char *path, size_t length, uid_t user, int above,
                       struct error_text *err)
{
    struct stat s;
    if (fstat(at, &s) != 0)
        return refuse(err, TFA_E_FILE, "'%.*s': %s", (int)length, path, strerror(errno));
    return check_permissions(path, length, &s, user, above, err);
}

/* Checks an absolute path without links, or all but its last entry. */
static int check_path(const char *path, uid_t user, int whole, struct error_text *err)
{
    int at = open("/", O_PATH | O_DIRECTORY | O_CLOEXEC);
    int status = at < 0 ? TFA_E_FILE : check_entry(at, path, 0, user, 1, err);
    for (size_t end = 0; status == TFA_OK && path[end];) {
        const size_t start = end + 1;
        end = start + strcspn(path + start, "/");
        const int last = !path[end];
        if (start == end || (last && !whole))
            break;
        const int next = open_entry(at, path, start, end);
        if (next < 0) {
            status = refuse(err, TFA_E_FILE, "'%.*s': %s", (int)end, path, strerror(errno));
            break;
        }
        close(at);
        at = next;
        status = check_entry(at, path, end, user, !last, err);
    }
    if (at >= 0)
        close(at);
    return status;
}

int check_ownership(const char *path, uid_t user, struct error_text *err)
{
    char resolved[PATH_MAX];
    if (!realpath(path, resolved))
        return refuse(err, TFA_E_FILE, "'%s': %s", path, strerror(errno));
    return check_path(resolved, user, 1, err);
}

int check_ownership_of_file(int file, const char *path, uid_t user, struct error_text *err)
{
    const int status = check_path(path, user, 0, err);
    return status == TFA_OK ? check_entry(file, path, strlen(path), user, 0, err) : status;
}

int tfa_specialised_check_ownership(const char *path, char *error_text, size_t size)
{
    struct error_text err = begin_error_text(error_text, size);
    return path ? check_ownership(path, geteuid(), &err) : TFA_E_ARGUMENT;
}
