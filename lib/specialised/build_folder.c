/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Temporary folders of builds: locked (flock) while the build runs, so that the next build beside
 * them knows those that a killed one left.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "specialised/specialised_internal.h"

#define PREFIX ".totalforce-"
#define SUFFIX "XXXXXX"
#define TRIES 10

static int open_folder(int at, const char *name)
{
    return openat(at, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

static void remove_files(int folder)
{
    const int again = open_folder(folder, ".");
    DIR *entries = again < 0 ? NULL : fdopendir(again);
    const struct dirent *e;
    while (entries && (e = readdir(entries)))
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0)
            (void)unlinkat(folder, e->d_name, 0);
    if (entries)
        closedir(entries);
    else if (again >= 0)
        close(again);
}

/* ---- what killed builds left ---- */

static int has_our_name(const char *name)
{
    return strlen(name) == sizeof PREFIX SUFFIX - 1 &&
           strncmp(name, PREFIX, sizeof PREFIX - 1) == 0;
}

/* Whoever has the lock builds in it, or removes it. */
static void remove_if_stale(int at, const char *name)
{
    struct stat s;
    const int folder = open_folder(at, name);
    if (folder < 0)
        return;
    if (fstat(folder, &s) == 0 && s.st_uid == geteuid() && flock(folder, LOCK_EX | LOCK_NB) == 0) {
        remove_files(folder);
        (void)unlinkat(at, name, AT_REMOVEDIR);
    }
    close(folder);
}

static void remove_stale(const char *beside)
{
    DIR *entries = opendir(beside);
    const struct dirent *e;
    while (entries && (e = readdir(entries)))
        if (has_our_name(e->d_name))
            remove_if_stale(dirfd(entries), e->d_name);
    if (entries)
        closedir(entries);
}

/* ---- the folder of this build ---- */

/* Another build may have taken it for stale before it was locked. */
static int is_there(int folder, const char *path)
{
    struct stat ours, there;
    return fstat(folder, &ours) == 0 && stat(path, &there) == 0 && ours.st_ino == there.st_ino &&
           ours.st_dev == there.st_dev;
}

int build_folder_make(const char *result, char *path, size_t size, int *lock)
{
    const char *slash = strrchr(result, '/');
    const int prefix = slash ? (int)(slash - result) + 1 : 0;
    if (snprintf(path, size, "%.*s.", prefix, result) >= (int)size)
        return ENAMETOOLONG;
    remove_stale(path);
    for (int i = 0; i < TRIES; i++) {
        if (snprintf(path, size, "%.*s" PREFIX SUFFIX, prefix, result) >= (int)size)
            return ENAMETOOLONG;
        if (!mkdtemp(path))
            return errno;
        *lock = open_folder(AT_FDCWD, path);
        if (*lock >= 0 && flock(*lock, LOCK_EX | LOCK_NB) == 0 && is_there(*lock, path))
            return 0;
        if (*lock >= 0)
            close(*lock);
    }
    return EBUSY;
}

void build_folder_remove(const char *path, int lock)
{
    remove_files(lock);
    (void)rmdir(path);
    close(lock);
}
