/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Socket activation: listening sockets that the service manager made and passed on (sd_listen_fds).
 * They stay at their paths when the daemon ends: clients that connect meanwhile wait for the next.
 *
 * One list for the process; the control thread's.
 */
#ifndef TFA_SERVICE_PLATFORM_PASSED_SOCKETS_H
#define TFA_SERVICE_PLATFORM_PASSED_SOCKETS_H

#include <stdbool.h>
#include <totalforce/status.h>

/**
 * Takes the sockets that were passed to this process. Each must listen, be of type SOCK_SEQPACKET
 * and lie in the directory `directory` (a descriptor; `path` for messages), as NAME.sock. Logs the
 * error. Call it before other descriptors are opened by libraries, once.
 * @return TFA_OK, also if there are none; TFA_E_ARGUMENT; TFA_E_MEMORY
 */
TFA_CHECKED int tfa_passed_sockets_take(int directory, const char *path);

/** The descriptor of the socket NAME.sock, which is the caller's now; -1: none was passed. */
int tfa_passed_socket_claim(const char *name);

/** Was it passed? Then its path is the service manager's. */
bool tfa_passed_socket_is(const char *name);

/** All claims are made. Logs the sockets without a claim.
 *  @return TFA_OK; TFA_E_ARGUMENT: there were some */
TFA_CHECKED int tfa_passed_sockets_check(void);

/** Closes those without a claim, and forgets all. */
void tfa_passed_sockets_forget(void);

#endif
