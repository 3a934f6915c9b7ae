/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory: lock file and sockets.
 */
#include "runtime_dir.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "ipc/handshake.h"
#include "log.h"

#define BACKLOG 64
#define LOCK_TRIES 10

static int make_directory(const char *path)
{
    struct stat info;
    if (mkdir(path, 0755) != 0 && errno != EEXIST) {
        tfa_log(TFA_LOG_ERROR, "runtime directory '%s' cannot be made: %s; set runtime_dir", path,
                strerror(errno));
        return TFA_E_SYSTEM;
    }
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode)) {
        tfa_log(TFA_LOG_ERROR, "runtime directory '%s' is not a directory", path);
        return TFA_E_SYSTEM;
    }
    /* whoever can write here can put their socket in place of ours */
    if ((info.st_uid != geteuid() && geteuid() != 0) || (info.st_mode & S_IWOTH)) {
        tfa_log(TFA_LOG_ERROR,
                "runtime directory '%s' belongs to another user or anybody may write "
                "to it: it must be ours alone",
                path);
        return TFA_E_REFUSED;
    }
    return TFA_OK;
}

static void log_taken(const char *path, int fd)
{
    char text[32] = "";
    ssize_t n = pread(fd, text, sizeof text - 1, 0);
    if (n > 0)
        text[strcspn(text, " \n")] = 0;
    tfa_log(TFA_LOG_ERROR,
            "another totalforced (pid %s) serves '%s': stop it, or choose another "
            "runtime_dir",
            *text ? text : "unknown", path);
}

/* A daemon that ends removes the file while it holds the lock; whoever opened it before that has
 * the lock of a file that has no name any more: then try again. */
static bool is_current(int fd, const char *file)
{
    struct stat ours, there;
    return fstat(fd, &ours) == 0 && stat(file, &there) == 0 && ours.st_ino == there.st_ino &&
           ours.st_dev == there.st_dev;
}

static int acquire_lock(const char *path, const char *file, int *lock)
{
    const struct flock want = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    for (int i = 0; i < LOCK_TRIES; i++) {
        int fd = open(file, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
        if (fd < 0) {
            tfa_log(TFA_LOG_ERROR, "lock '%s' cannot be opened: %s", file, strerror(errno));
            return TFA_E_SYSTEM;
        }
        struct flock request = want;
        if (fcntl(fd, F_OFD_SETLK, &request) != 0) {
            log_taken(path, fd);
            close(fd);
            return TFA_E_REFUSED;
        }
        if (is_current(fd, file)) {
            *lock = fd;
            return TFA_OK;
        }
        close(fd);
    }
    return TFA_E_SYSTEM;
}

static void write_state(int fd, const char *state)
{
    char text[32];
    int n = snprintf(text, sizeof text, "%d%s\n", (int)getpid(), state);
    if (ftruncate(fd, 0) != 0 || pwrite(fd, text, (size_t)n, 0) != n)
        tfa_log(TFA_LOG_WARNING, "the lock file cannot be written: %s", strerror(errno));
}

/* We hold the lock, so every socket here is a dead daemon's. */
static void remove_stale(const char *path)
{
    DIR *directory = opendir(path);
    if (!directory)
        return;
    for (const struct dirent *e; (e = readdir(directory)) != NULL;) {
        const size_t length = strlen(e->d_name);
        struct stat info;
        if (length > 5 && strcmp(e->d_name + length - 5, ".sock") == 0 &&
            fstatat(dirfd(directory), e->d_name, &info, AT_SYMLINK_NOFOLLOW) == 0 &&
            S_ISSOCK(info.st_mode))
            (void)unlinkat(dirfd(directory), e->d_name, 0);
    }
    closedir(directory);
}

static char *lock_name(const char *path)
{
    char *file;
    return asprintf(&file, "%s/" TFA_LOCK_FILE, path) < 0 ? NULL : file;
}

int tfa_runtime_dir_acquire(const char *path, int *lock)
{
    int status = make_directory(path);
    if (status != TFA_OK)
        return status;
    char *file = lock_name(path);
    if (!file)
        return TFA_E_MEMORY;
    status = acquire_lock(path, file, lock);
    free(file);
    if (status != TFA_OK)
        return status;
    write_state(*lock, "");
    remove_stale(path);
    return TFA_OK;
}

void tfa_runtime_dir_ready(int lock)
{
    write_state(lock, " " TFA_LOCK_READY);
}

int tfa_runtime_dir_set_owner(const char *path, int lock, uid_t user, gid_t group)
{
    if (chown(path, user, group) == 0 && fchown(lock, user, group) == 0)
        return TFA_OK;
    return TFA_E_SYSTEM;
}

void tfa_runtime_dir_release(const char *path, int lock)
{
    char *file = lock_name(path);
    if (file)
        (void)unlink(file);
    free(file);
    close(lock);
}

/* @return false: the path is too long for a socket */
static bool make_address(const char *path, const char *name, struct sockaddr_un *address)
{
    *address = (struct sockaddr_un){.sun_family = AF_UNIX};
    int n = snprintf(address->sun_path, sizeof address->sun_path, "%s/%s.sock", path, name);
    return n > 0 && (size_t)n < sizeof address->sun_path;
}

int tfa_runtime_dir_listen(const char *path, const char *name, gid_t group)
{
    struct sockaddr_un address;
    if (!make_address(path, name, &address)) {
        errno = ENAMETOOLONG;
        return -1;
    }
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0)
        return -1;
    const mode_t before = umask(0117); /* 0660 from the first moment */
    int result = bind(fd, (const struct sockaddr *)&address, sizeof address);
    umask(before);
    if (result == 0 && group != (gid_t)-1)
        result = chown(address.sun_path, (uid_t)-1, group);
    if (result == 0)
        result = listen(fd, BACKLOG);
    if (result == 0)
        return fd;
    const int saved = errno;
    close(fd);
    errno = saved;
    return -1;
}

void tfa_runtime_dir_unlink(const char *path, const char *name)
{
    struct sockaddr_un address;
    if (make_address(path, name, &address))
        (void)unlink(address.sun_path);
}
