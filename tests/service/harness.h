/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Starts the real totalforced in a directory of its own, and looks at it from outside.
 */
#ifndef TFA_TESTS_SERVICE_HARNESS_H
#define TFA_TESTS_SERVICE_HARNESS_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>
#include <totalforce/client.h>

#include "support/scoped.h"
#include "support/wait.h"

typedef struct harness {
    char directory[64]; /* configuration, log and runtime directory */
    char runtime_dir[80];
    char config[80];
    char preload[256]; /* LD_PRELOAD of the daemon, or "" */
    char notify[96];   /* NOTIFY_SOCKET of the daemon, or "" */
    pid_t pid;
} harness;

/** Makes the directory. `robots` is the YAML below "robots:", `more` other top-level keys. Names
 *  of URDF files start at the source directory: "@/config/robots/arm7.urdf". Without `limits` in
 *  `more`, clients connect as often as they like: how many a second depends on the machine. */
harness harness_make(const char *robots, const char *more);
/** Writes another configuration in its place, as harness_make does. */
void harness_configure(const harness *h, const char *robots, const char *more);
/** Starts the daemon and waits until it accepts `robot`. */
void harness_start(harness *h, const char *robot);
/** harness_make, then harness_start for "arm". */
harness harness_serve(const char *robots, const char *more);
/** Starts it and does not wait. */
void harness_launch(harness *h);
/** Starts it and waits until it ended. @return its wait status */
int harness_run(harness *h);
/** Starts it; it ends with status 2 and logs the reason. */
void harness_assert_refused(harness *h, const char *reason);
/** `totalforced --check`, which writes to the log, too. @return exit status */
int harness_check(const harness *h);
/** The same for both. */
void harness_assert_mistake(harness *h, const char *reason);
/** Sends a signal and waits for the end. @return wait status */
int harness_stop(harness *h, int signal);
/** Another configuration, unless `robots` is NULL, then SIGHUP. */
void harness_reload(const harness *h, const char *robots, const char *more);
/** Writes a file of that name beside the configuration. */
void harness_write(const harness *h, const char *name, const char *text);
/** Connects to a socket in the runtime directory, "arm.sock". @return its descriptor */
int harness_dial(const harness *h, const char *name);
/** A socket of others: its path is `name` in `directory`. @return its descriptor */
int socket_at(const char *directory, const char *name, int type, bool listens);
/** In a child: becomes a user of group nogroup alone. @return false: it may not */
bool become_user(uid_t user);
#define USER_NOBODY 65534
/** Waits for a child. @return its exit status; -signal */
int child_end(pid_t child);
/** Sends SIGSTOP and waits until it stands. */
void harness_pause(const harness *h);
/** Ends the daemon by SIGTERM if it runs, and it must end well; removes the directory. */
void harness_remove(harness *h);
#define SCOPED_HARNESS SCOPED(harness_remove) harness

tfa_client_options harness_options(const harness *h, const char *robot);
/** Connects or fails the test. */
tfa_client *harness_connect(const harness *h, const char *robot, tfa_wait wait);
tfa_client *harness_connect_with(const tfa_client_options *options);
SCOPED_POINTER(scoped_client_close, tfa_client, tfa_client_close)
#define SCOPED_CLIENT SCOPED(scoped_client_close) tfa_client

/** Shared memory of the daemon that others could open by its name, or that would stay behind. */
int harness_named_segments(const harness *h);
/** Waits until the daemon has so many clients. @return false: it does not come to it */
bool harness_has_clients(const harness *h, unsigned count);
/** Open descriptors, mappings and resident KiB of the daemon. */
int harness_descriptors(const harness *h);
/** Waits until the daemon has no more descriptors than these: it closes some after it has noticed a
 * hang-up or logged a reload. */
void harness_assert_descriptors(const harness *h, int most);
int harness_mappings(const harness *h);
long harness_resident_kib(const harness *h);
/** Does the log contain this text? Waits for it. */
bool harness_logged(const harness *h, const char *text);
/** The same, in so many lines. */
bool harness_logged_times(const harness *h, const char *text, unsigned times);
/** Lines of the log that contain this text now. */
unsigned harness_log_lines(const harness *h, const char *text);
/** Minor page faults of the daemon's thread of that name; -1 if there is none. */
long harness_thread_faults(const harness *h, const char *thread);

/** Forward dynamics of the 7-joint arm; x varies the state, which lies in q, v and tau. */
tfa_request arm_request(double x, double q[7], double v[7], double tau[7]);
/** One forward dynamics of the 7-joint arm; x varies the state. @return status of the reply */
int ask_arm(tfa_client *client, double x, double qdd[7], uint64_t timeout_ns);

#define ARM "  - name: arm\n    urdf: @/config/robots/arm7.urdf\n"

#endif
