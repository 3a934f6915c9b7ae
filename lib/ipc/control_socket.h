/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The control socket of a daemon: AF_UNIX SOCK_SEQPACKET at RUNTIME_DIR/TFA_CONTROL_SOCKET.
 *
 * A peer sends one packet, a command without a final 0, and gets one packet of text back; then the
 * daemon hangs up. `status` answers JSON to everybody who may open the socket. `reload` and `stop`
 * are for root and the daemon's user: `reload` answers when it is done, `stop` at once. The text
 * begins with "ok" or "error: " for these two, and with "error: " for a command that is refused.
 * `statistics` answers "ok" to everybody, and one descriptor: the segment of statistics_layout.h,
 * which its receiver cannot write.
 *
 * `record ROBOT MIB`, for the same users, is answered by "ok" with two descriptors: a segment of
 * taps (tap.h) with rings of MIB MiB, read-write, and a description of the robot, read-only
 * (recording.h). The connection stays: its hang-up ends the recording in both directions. Before
 * the daemon hangs up it sends the reason as a text.
 */
#ifndef TFA_IPC_CONTROL_SOCKET_H
#define TFA_IPC_CONTROL_SOCKET_H

/** Begins with a dot: no robot has such a name. */
#define TFA_CONTROL_NAME ".control"
#define TFA_CONTROL_SOCKET TFA_CONTROL_NAME ".sock"
/** Bytes of the longest answer. */
#define TFA_CONTROL_TEXT_MAX 65536

#endif
