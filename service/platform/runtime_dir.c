/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory: lock file and sockets.
 */
#include "runtime_dir.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "ipc/control_socket.h"
#include "ipc/handshake.h"
#include "log.h"
#include "passed_sockets.h"

#define BACKLOG 64
#define LOCK_TRIES 10
/* A lock file lists a thousand robots and scenes with the longest names. */
#define LOCK_BYTES_MAX 131072

/* ---- the check of a configuration ---- */

#define OTHER "or choose another runtime_dir"

/* @return 0, or the errno of a socket in this directory */
static int try_socket(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int directory = open(path, O_PATH | O_DIRECTORY | O_CLOEXEC);
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d/.check-%d.sock",
             directory, (int)getpid());
    const bool made = directory >= 0 && fd >= 0 &&
                      bind(fd, (const struct sockaddr *)&address, sizeof address) == 0;
    const int error = made ? 0 : errno;
    if (made)
        (void)unlink(address.sun_path);
    close(fd);
    close(directory);
    return error;
}

/* The service manager makes the default directory for the daemon's user. */
static int check_sockets(const char *path, const char *in, char *text, size_t size)
{
    const int error = try_socket(in);
    if (error == 0 || (error == EACCES && strcmp(path, TFA_DEFAULT_RUNTIME_DIR) == 0))
        return TFA_OK;
    snprintf(text, size, "'%s': no socket can be made in '%s': %s: %s, " OTHER, path, in,
             strerror(error),
             error == EACCES ? "check as the daemon's user" : "a folder below /run takes sockets");
    return TFA_E_REFUSED;
}

/* @param info  NULL: there is nothing at the path */
static int check_directory(const char *path, const struct stat *info, uid_t user, char *text,
                           size_t size)
{
    if (info && !S_ISDIR(info->st_mode))
        snprintf(text, size, "'%s' is not a directory: remove it, " OTHER, path);
    else if (info && (info->st_mode & (S_IWGRP | S_IWOTH)))
        snprintf(text, size,
                 "'%s' has mode %04o, others could replace its sockets: chmod 0755 it, " OTHER,
                 path, (unsigned)info->st_mode & 07777);
    else if (info && user != (uid_t)-1 && info->st_uid != user)
        snprintf(text, size, "'%s' belongs to user %u, it must belong to user %u: chown it, " OTHER,
                 path, (unsigned)info->st_uid, (unsigned)user);
    else
        return TFA_OK;
    return TFA_E_REFUSED;
}

/* Who may rename an entry of the parent can put a directory of their own in place of ours. */
static int check_parent(const char *path, char *text, size_t size)
{
    struct stat info;
    char *copy = strdup(path);
    const char *parent = copy ? dirname(copy) : "";
    int status = copy ? TFA_OK : TFA_E_MEMORY;
    if (copy && stat(parent, &info) != 0) {
        status = TFA_E_REFUSED;
        snprintf(text, size, "'%s' cannot be made, '%s': %s: make that folder, " OTHER, path,
                 parent, strerror(errno));
    } else if (copy && (info.st_mode & S_IWOTH) && !(info.st_mode & S_ISVTX)) {
        status = TFA_E_REFUSED;
        snprintf(
            text, size,
            "'%s': every user can replace it, for '%s' has mode %04o: chmod +t that folder, " OTHER,
            path, parent, (unsigned)info.st_mode & 07777);
    }
    free(copy);
    return status;
}

int tfa_runtime_dir_check(const char *path, uid_t user, char *text, size_t size)
{
    struct stat info;
    const bool is_there = lstat(path, &info) == 0;
    char *copy = strdup(path);
    int status = copy ? check_parent(path, text, size) : TFA_E_MEMORY;
    if (status == TFA_OK)
        status = check_directory(path, is_there ? &info : NULL, user, text, size);
    if (status == TFA_OK)
        status = check_sockets(path, is_there ? path : dirname(copy), text, size);
    free(copy);
    return status;
}

/* ---- the directory ---- */

/* Writing here is the right to put another socket in place of ours. One that was made just now is
 * still this process's, or another has come in its place. */
static int check_owner(const tfa_runtime_dir *d, const struct stat *info)
{
    const uid_t owner = d->made || d->user == (uid_t)-1 ? geteuid() : d->user;
    if (info->st_uid == owner && !(info->st_mode & (S_IWGRP | S_IWOTH)))
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR,
            "runtime directory '%s' has owner %u and mode %04o: it must belong to user %u alone; "
            "chown and chmod 0755 it, or set runtime_dir",
            d->path, (unsigned)info->st_uid, (unsigned)info->st_mode & 07777, (unsigned)owner);
    return TFA_E_REFUSED;
}

static int open_directory(tfa_runtime_dir *d)
{
    struct stat info;
    char text[512];
    if (check_parent(d->path, text, sizeof text) != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "runtime directory %s", text);
        return TFA_E_REFUSED;
    }
    d->made = mkdir(d->path, 0755) == 0;
    if (!d->made && errno != EEXIST) {
        tfa_log(TFA_LOG_ERROR, "runtime directory '%s' cannot be made: %s; set runtime_dir",
                d->path, strerror(errno));
        return TFA_E_SYSTEM;
    }
    d->directory = open(d->path, O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (d->directory < 0 || fstat(d->directory, &info) != 0) {
        tfa_log(TFA_LOG_ERROR, "runtime directory '%s' is not a directory: %s", d->path,
                strerror(errno));
        return TFA_E_SYSTEM;
    }
    return check_owner(d, &info);
}

/* A directory that was there keeps its owner. */
static int set_owner(const tfa_runtime_dir *d)
{
    if (d->user == (uid_t)-1)
        return TFA_OK;
    if (d->made && fchownat(d->directory, "", d->user, d->user_group, AT_EMPTY_PATH) != 0)
        return TFA_E_SYSTEM;
    return fchown(d->lock, d->user, d->user_group) == 0 ? TFA_OK : TFA_E_SYSTEM;
}

bool tfa_runtime_dir_is_there(const tfa_runtime_dir *d)
{
    struct stat ours, there;
    return fstat(d->directory, &ours) == 0 && stat(d->path, &there) == 0 &&
           ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

/* ---- the lock ---- */

static void log_taken(const tfa_runtime_dir *d, int fd)
{
    char text[32] = "";
    ssize_t n = pread(fd, text, sizeof text - 1, 0);
    if (n > 0)
        text[strcspn(text, " \n")] = 0;
    tfa_log(TFA_LOG_ERROR,
            "another totalforced (pid %s) serves '%s': stop it, or choose another "
            "runtime_dir",
            *text ? text : "unknown", d->path);
}

/* A daemon that ends removes the file while it holds the lock; whoever opened it before that has
 * the lock of a file that has no name any more: then try again. */
static bool is_current(const tfa_runtime_dir *d, int fd)
{
    struct stat ours, there;
    return fstat(fd, &ours) == 0 &&
           fstatat(d->directory, TFA_LOCK_FILE, &there, AT_SYMLINK_NOFOLLOW) == 0 &&
           ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

static int acquire_lock(tfa_runtime_dir *d)
{
    const struct flock want = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    for (int i = 0; i < LOCK_TRIES; i++) {
        int fd =
            openat(d->directory, TFA_LOCK_FILE, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
        if (fd < 0) {
            tfa_log(TFA_LOG_ERROR, "lock '%s/" TFA_LOCK_FILE "' cannot be opened: %s", d->path,
                    strerror(errno));
            return TFA_E_SYSTEM;
        }
        struct flock request = want;
        if (fcntl(fd, F_OFD_SETLK, &request) != 0) {
            log_taken(d, fd);
            close(fd);
            return TFA_E_REFUSED;
        }
        if (is_current(d, fd)) {
            d->lock = fd;
            return TFA_OK;
        }
        close(fd);
    }
    return TFA_E_SYSTEM;
}

/* ---- sockets ---- */

static bool socket_name(const char *name, char file[TFA_ROBOT_NAME_MAX + 6])
{
    const int n = snprintf(file, TFA_ROBOT_NAME_MAX + 6, "%s.sock", name);
    return n > 0 && n < TFA_ROBOT_NAME_MAX + 6 && !strchr(name, '/');
}

/* The address of a socket in the opened directory, however long its path is. */
static struct sockaddr_un address_of(const tfa_runtime_dir *d, const char *file)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "/proc/self/fd/%d/%s", d->directory, file);
    return address;
}

/* Clients reach it by its path, which must fit an address. */
static bool path_fits(const tfa_runtime_dir *d, const char *file)
{
    return strlen(d->path) + 1 + strlen(file) < sizeof(((struct sockaddr_un *)0)->sun_path);
}

/* A socket of that name without a listener is what a killed daemon left. */
static void remove_stale(const tfa_runtime_dir *d, const char *file)
{
    const struct sockaddr_un address = address_of(d, file);
    struct stat info;
    if (fstatat(d->directory, file, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISSOCK(info.st_mode))
        return;
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return;
    if (connect(fd, (const struct sockaddr *)&address, sizeof address) != 0 &&
        errno == ECONNREFUSED)
        (void)unlinkat(d->directory, file, 0);
    close(fd);
}

static int listen_at(const tfa_runtime_dir *d, const char *file)
{
    remove_stale(d, file);
    const struct sockaddr_un address = address_of(d, file);
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -1;
    const mode_t before = umask(0117); /* 0660 from the first moment */
    int result = bind(fd, (const struct sockaddr *)&address, sizeof address);
    umask(before);
    if (result == 0 && d->socket_group != (gid_t)-1)
        result = fchownat(d->directory, file, (uid_t)-1, d->socket_group, AT_SYMLINK_NOFOLLOW);
    if (result == 0)
        result = listen(fd, BACKLOG);
    if (result == 0)
        return fd;
    const int saved = errno;
    close(fd);
    errno = saved;
    return -1;
}

int tfa_runtime_dir_listen(const tfa_runtime_dir *d, const char *name)
{
    char file[TFA_ROBOT_NAME_MAX + 6];
    if (!socket_name(name, file) || !path_fits(d, file)) {
        errno = ENAMETOOLONG;
        return -1;
    }
    const int passed = tfa_passed_socket_claim(name);
    return passed >= 0 ? passed : listen_at(d, file);
}

void tfa_runtime_dir_unlink(const tfa_runtime_dir *d, const char *name)
{
    char file[TFA_ROBOT_NAME_MAX + 6];
    if (!tfa_passed_socket_is(name) && socket_name(name, file))
        (void)unlinkat(d->directory, file, 0);
}

/* ---- the lock file: process id and "ready", then a robot on each line ---- */

/* Removes the sockets of the robots that a killed daemon listed. */
static void remove_listed(const tfa_runtime_dir *d)
{
    char *text = calloc(1, LOCK_BYTES_MAX + 1), file[TFA_ROBOT_NAME_MAX + 6];
    char *rest = text;
    if (!text || pread(d->lock, text, LOCK_BYTES_MAX, 0) < 0) {
        free(text);
        return;
    }
    (void)strsep(&rest, "\n");
    for (const char *name; rest && (name = strsep(&rest, "\n"));)
        if (*name && socket_name(name, file))
            remove_stale(d, file);
    free(text);
}

static void write_state(const tfa_runtime_dir *d, const char *state, const char *const *names,
                        size_t count)
{
    bool written = ftruncate(d->lock, 0) == 0 && lseek(d->lock, 0, SEEK_SET) == 0 &&
                   dprintf(d->lock, "%d%s\n", (int)getpid(), state) > 0;
    for (size_t i = 0; i < count && written; i++)
        written = dprintf(d->lock, "%s\n", names[i]) > 0;
    if (!written)
        tfa_log(TFA_LOG_WARNING, "the lock file of '%s' cannot be written: %s", d->path,
                strerror(errno));
}

int tfa_runtime_dir_acquire(tfa_runtime_dir *d, const char *path)
{
    d->path = strdup(path);
    int status = d->path ? open_directory(d) : TFA_E_MEMORY;
    if (status == TFA_OK)
        status = acquire_lock(d);
    if (status == TFA_OK) {
        remove_listed(d);
        write_state(d, "", NULL, 0);
        status = set_owner(d);
    }
    return status;
}

void tfa_runtime_dir_ready(const tfa_runtime_dir *d, const char *const *names, size_t count)
{
    write_state(d, " " TFA_LOCK_READY, names, count);
}

void tfa_runtime_dir_closing(const tfa_runtime_dir *d)
{
    write_state(d, "", NULL, 0);
}

void tfa_runtime_dir_release(tfa_runtime_dir *d)
{
    if (d->lock >= 0) {
        (void)unlinkat(d->directory, TFA_LOCK_FILE, 0);
        close(d->lock);
    }
    if (d->made && tfa_runtime_dir_is_there(d))
        (void)rmdir(d->path);
    if (d->directory >= 0)
        close(d->directory);
    free(d->path);
    d->path = NULL;
    d->directory = d->lock = -1;
}
