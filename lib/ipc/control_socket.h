/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The control socket of a daemon: AF_UNIX SOCK_SEQPACKET at RUNTIME_DIR/TFA_CONTROL_SOCKET.
 *
 * A peer sends one packet, a command without a final 0, and gets one packet of text back; then the
 * daemon hangs up. A peer may shut down its sending direction after the command. A command whose
 * peer has closed the socket before the daemon reads it is dropped. `status` answers JSON to
 * every process that may open the socket. `reload` and `stop` are for root and the daemon's user:
 * `reload` answers when it is done, `stop` at once. The text begins with "ok" or "error: " for
 * these two, and with "error: " for a command that is refused. `statistics` answers "ok" to
 * everybody, and one descriptor: the segment of statistics_layout.h, which its receiver cannot
 * write. `describe ROBOT` answers the same with the description of a robot (recording.h), by which
 * its model can be made elsewhere.
 *
 * `record ROBOT MIB`, for the same users, is answered by "ok" with two descriptors: a segment of
 * taps (tap.h) with rings of MIB MiB, read-write, and a description of the robot, read-only
 * (recording.h). The connection stays: its hang-up ends the recording in both directions. Before
 * the daemon hangs up it sends the reason as a text.
 */
#ifndef TFA_IPC_CONTROL_SOCKET_H
#define TFA_IPC_CONTROL_SOCKET_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/** Begins with a dot: no robot has such a name. */
#define TFA_CONTROL_NAME ".control"
#define TFA_CONTROL_SOCKET TFA_CONTROL_NAME ".sock"
/** Bytes of the longest answer. */
#define TFA_CONTROL_TEXT_MAX 65536
/** Descriptors of an answer, at most. */
#define TFA_CONTROL_DESCRIPTORS_MAX 2

#define TFA_DEFAULT_RUNTIME_DIR "/run/totalforce"

/** Folder of a daemon's sockets: `directory`, or if NULL the default for the socket "NAME.sock".
 *  Free it. NULL: no memory. */
char *tfa_find_runtime_dir(const char *directory, const char *name);

/** Connects to the daemon of a runtime directory. @return the socket, or -1 (errno) */
int tfa_control_connect(const char *directory);

/** Receives a packet, ends it with 0, and takes the `count` descriptors that come with it: all are
 *  -1 if as many did not. @return the bytes of the packet, 0: a hang-up, or -1 (errno) */
ssize_t tfa_control_receive(int socket, char *text, size_t size, int *descriptors, uint32_t count);

#endif
