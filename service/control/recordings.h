/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recorders.
 */
#ifndef TFA_SERVICE_CONTROL_RECORDINGS_H
#define TFA_SERVICE_CONTROL_RECORDINGS_H

#include "control/robot_set.h"

/* Requests and answers of a robot on their way to a recorder, which holds `socket`. */
typedef struct recording {
    struct recording *next;
    int socket; /* -1: it ended; workers may still use the taps */
    uint32_t robot;
    pid_t process; /* of the recorder */
    tfa_segment segment;
    struct tfa_tap *taps; /* of the workers, then of the gateways by source */
} recording;

/* Begins a recording, of which `order` has the rest of the command, and answers it. @return it has
 * the socket now; otherwise the error is in `text` */
bool recordings_begin(tfa_daemon *d, int socket, const char *order, char *text, size_t size);
/* Something happened at `what`. @return it is a recorder's connection */
bool recordings_event(tfa_daemon *d, void *what);
/* Ends those of a robot, with a reason for their recorders: no later answer is recorded. */
void recordings_end(tfa_daemon *d, uint32_t robot, const char *reason);
/* Time passed: taps may be unused by now. */
void recordings_tick(tfa_daemon *d);
/* One waits for a worker: look again soon. */
bool recordings_any_ending(const tfa_daemon *d);
/* Ends all of them; the workers run no more. */
void recordings_close(tfa_daemon *d);

#endif
