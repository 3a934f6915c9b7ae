/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory: one daemon at a time, and nothing stale in it.
 */
#ifndef TFA_SERVICE_PLATFORM_RUNTIME_DIR_H
#define TFA_SERVICE_PLATFORM_RUNTIME_DIR_H

#include <sys/types.h>
#include <totalforce/status.h>

/** Makes the directory if it is missing (its parent must be there), takes the lock, removes the
 *  sockets that a killed daemon left. Logs the error.
 *  @return TFA_OK and the descriptor of the lock; TFA_E_REFUSED (another daemon, not ours);
 *          TFA_E_SYSTEM. */
TFA_CHECKED int tfa_runtime_dir_acquire(const char *path, int *lock);

/** Gives directory and lock to the user the daemon will become. */
TFA_CHECKED int tfa_runtime_dir_set_owner(const char *path, int lock, uid_t user, gid_t group);

/** Notes in the lock file that all sockets are open: a robot without one is then unknown. */
void tfa_runtime_dir_ready(int lock);

/** Removes the lock file and lets go. */
void tfa_runtime_dir_release(const char *path, int lock);

/** Listens at PATH/NAME.sock, mode 0660, group `group` unless (gid_t)-1. @return a descriptor, or
 *  -1 with errno */
int tfa_runtime_dir_listen(const char *path, const char *name, gid_t group);
void tfa_runtime_dir_unlink(const char *path, const char *name);

#endif
