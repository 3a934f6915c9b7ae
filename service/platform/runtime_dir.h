/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory: one daemon at a time, and nothing stale in it.
 *
 * The directory is opened once, and everything in it is reached through its descriptor: a link or
 * another directory in its place changes nothing for a daemon that runs.
 */
#ifndef TFA_SERVICE_PLATFORM_RUNTIME_DIR_H
#define TFA_SERVICE_PLATFORM_RUNTIME_DIR_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>
#include <totalforce/status.h>

typedef struct tfa_runtime_dir {
    char *path;         /**< a copy of the given one */
    int directory;      /**< descriptor; -1: not open */
    int lock;           /**< descriptor of the lock file; -1: not held */
    bool made;          /**< by this daemon */
    uid_t user;         /**< (uid_t)-1, or the user that the daemon becomes */
    gid_t user_group;   /**< the group of that user */
    gid_t socket_group; /**< (gid_t)-1, or the group of the sockets */
} tfa_runtime_dir;

#define TFA_RUNTIME_DIR_NONE ((tfa_runtime_dir){.directory = -1, .lock = -1})

/**
 * Makes the directory if it is missing (its parent must be there), opens it, takes the lock,
 * removes the sockets that a killed daemon listed in the lock file. A directory that was there must
 * belong to `user`, or else to the user of this process, and be writable by its owner alone. Logs
 * the error. Set the ids before; again after a release.
 * @return TFA_OK; TFA_E_REFUSED (another daemon, or not ours alone); TFA_E_MEMORY; TFA_E_SYSTEM.
 */
TFA_CHECKED int tfa_runtime_dir_acquire(tfa_runtime_dir *dir, const char *path);

/**
 * Checks for a start at `path`, in which `user` would be as in tfa_runtime_dir: what an acquire
 * would refuse, and whether the directory (a missing one: its parent) takes sockets, by one that is
 * made and removed.
 * @return TFA_OK; TFA_E_REFUSED, with error and remedy in `text`
 */
TFA_CHECKED int tfa_runtime_dir_check(const char *path, uid_t user, char *text, size_t size);

/** Notes in the lock file that all sockets are open: a robot without one is then unknown. `names`:
 *  the robots. */
void tfa_runtime_dir_ready(const tfa_runtime_dir *dir, const char *const *names, size_t count);

/** Takes that note back: a client that finds no socket from now on finds no daemon. */
void tfa_runtime_dir_closing(const tfa_runtime_dir *dir);

/** Removes the lock file, and the directory if this daemon made it and it is empty; closes both. */
void tfa_runtime_dir_release(tfa_runtime_dir *dir);

/** Whether the directory is still at its path */
bool tfa_runtime_dir_is_there(const tfa_runtime_dir *dir);

/** Listens at NAME.sock, mode 0660. A socket without a listener is replaced; one that the
 *  service manager passed is taken, and stays at its path.
 *  @return a descriptor, or -1 with errno; EADDRINUSE: another program listens there */
int tfa_runtime_dir_listen(const tfa_runtime_dir *dir, const char *name);
void tfa_runtime_dir_unlink(const tfa_runtime_dir *dir, const char *name);

#endif
