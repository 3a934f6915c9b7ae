/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon as a whole, and its clients. Grouped by the file that defines it. Everything here
 * belongs to the control thread.
 */
#ifndef TFA_SERVICE_CONTROL_DAEMON_H
#define TFA_SERVICE_CONTROL_DAEMON_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>
#include <sys/types.h>

#include "config/config.h"
#include "control/admission.h"
#include "control/gateways.h"
#include "http/http.h"
#include "ipc/handshake.h"
#include "platform/runtime_dir.h"
#include "platform/segment.h"
#include "robots/robot.h"
#include "worker/worker.h"

/* A worker, its thread and its solvers */
typedef struct daemon_worker {
    tfa_worker *worker;
    tfa_robot_solver **solvers; /* one for each robot */
    pthread_t thread;
    bool started;
    uint32_t clients;
    uint64_t last_heartbeat; /* for the watchdog */
} daemon_worker;

typedef enum session_state {
    SESSION_HANDSHAKE, /* connected, HELLO has not come */
    SESSION_DEFERRED,  /* HELLO came while a reload changes the robot's shape: it is kept */
    SESSION_ATTACHED,  /* attached to a worker */
    SESSION_DRAINING,  /* the worker answers earlier requests, then detaches; the socket is open */
    SESSION_DETACHING, /* the worker was asked to detach; the socket is closed */
} session_state;

/* One connection on the control socket. */
typedef struct session {
    struct session *next;
    session_state state;
    int socket, doorbell;
    uint32_t robot;
    uid_t user;
    pid_t process;
    uint64_t since; /* CLOCK_MONOTONIC ns of the connection */
    daemon_worker *worker;
    tfa_worker_client *client;
    tfa_segment requests, replies;
    bool resized;    /* the client changed its request segment */
    tfa_hello hello; /* of a session that waits */
    ssize_t hello_size;
} session;

#define COMMANDS_MAX 4         /* at once; a further one is hung up on */
#define COMMANDS_DESCRIPTORS 2 /* of one answer at most */

/* A connection on the control socket of operators. */
typedef struct command {
    int socket;
    bool waits; /* for the end of a reload */
    uint64_t since;
} command;

/* Requests and answers of a robot on their way to a recorder, which holds `socket`. */
typedef struct recording {
    struct recording *next;
    int socket; /* -1: it ended; workers may still use the taps */
    uint32_t robot;
    pid_t process; /* of the recorder */
    tfa_segment segment;
    struct tfa_tap *taps; /* of the workers, then of the gateways by source */
} recording;

/* All robots and scenes of a configuration: the served ones, or the ones that a reload made. */
typedef struct robot_set {
    tfa_robot *robots; /* those with dds first: the DDS gateway numbers them as the workers do */
    uint32_t count;
} robot_set;

/* Robot descriptions that came over a topic, by number of the robot in the configuration. */
typedef struct robot_descriptions {
    pthread_mutex_t mutex; /* guards next and last: the gateway's thread writes them */
    int event;             /* eventfd: there is a next one */
    size_t count;
    char **next;   /* received and not yet loaded, or NULL */
    char **last;   /* received last: the same again is no news */
    char **loaded; /* in place of the robot's file, or NULL */
} robot_descriptions;

typedef enum reload_phase {
    RELOAD_NONE,
    RELOAD_LOADING,  /* the thread makes everything aside */
    RELOAD_DRAINING, /* robots whose shape changes lose their clients */
    RELOAD_OFFERED,  /* the workers have not all taken the new solvers */
} reload_phase;

#define RELOAD_GATEWAYS (TFA_GATEWAY_SOURCES + 1) /* have solvers besides the workers: HTTP, too */

/* A reload under way. Up to the commit it owns the new objects, afterwards the old ones: either is
 * released in the same way. */
typedef struct reload {
    reload_phase phase;
    bool requested_again; /* SIGHUP came meanwhile */
    bool of_topic;        /* of one robot, by its description, with the settings as they are */
    pthread_t thread;
    int event;   /* eventfd: the thread is done */
    bool loaded; /* the eventfd said so */
    int status;
    config *settings;  /* NULL: of one robot, or not read */
    size_t robot;      /* that one, in the configuration */
    char *description; /* its URDF; after the commit: the one before */
    tfa_robot_urdf urdf;
    tfa_admission admission;
    robot_set robot_set;         /* of one robot: the others are empty */
    bool *changed;               /* by robot: it has another model, arithmetic or estimate policy */
    bool *shape_changed;         /* and its clients cannot stay */
    tfa_robot_solver ***solvers; /* by worker, then gateway, then of the HTTP server, and robot;
                                    NULL: no change */
    uint64_t start;
} reload;

typedef struct tfa_daemon {
    config *settings;
    robot_set robot_set;
    tfa_thread_pool *thread_pool; /* threads of all robots' pools; NULL: none */
    daemon_worker *workers;
    gateway_slot gateways[TFA_GATEWAY_SOURCES]; /* by source */
    tfa_http *http;                             /* NULL: off */
    tfa_robot_solver **http_solvers;            /* one for each robot; NULL: no page */
    bool metrics_open; /* the socket of metrics is in the runtime directory */
    robot_descriptions descriptions;
    reload reload;

    int epoll, signals, reserve;
    uint64_t start; /* CLOCK_MONOTONIC ns */
    int command_listener;
    command commands[COMMANDS_MAX];
    int *listeners; /* one for each robot */
    gid_t group;
    tfa_runtime_dir runtime_dir;
    uint64_t runtime_dir_looked; /* CLOCK_MONOTONIC ns */
    tfa_admission admission;
    tfa_connect_rate connect_rate;
    recording *recordings;
    session *sessions;
    uint32_t session_count;
    tfa_segment statistics_segment;
    tfa_statistics_view statistics; /* in it */
    bool stop;
    uint64_t watchdog_ns, watchdog_last; /* 0: no watchdog */
} tfa_daemon;

/* ---- robot_set.c: robots and workers ---- */

/* @param descriptions  by robot of the configuration, NULL: its file; NULL: all files */
TFA_CHECKED int robot_set_load(const config *settings, char *const *descriptions, robot_set *f);
/* Loads one robot of the configuration and its scenes into a set like `now`, whose others stay
 * empty. */
TFA_CHECKED int robot_set_load_one(const config *settings, const robot_set *now, size_t robot,
                                   tfa_robot_urdf *urdf, robot_set *f);
void robot_set_unload(robot_set *f);
/* Starts the pool's threads, if configured, and gives robots their workspaces for it. */
TFA_CHECKED int daemon_start_pool(tfa_daemon *d);
TFA_CHECKED int daemon_start_workers(tfa_daemon *d);
TFA_CHECKED int daemon_self_test(tfa_daemon *d);
/* A solver of robot `i` of the set, into `solvers` by robot, which are made when they are NULL. */
TFA_CHECKED int daemon_make_solver(const tfa_daemon *d, uint32_t i, tfa_robot_solver ***solvers,
                                   tfa_worker_robot *made);
void daemon_stop_workers(tfa_daemon *d);
void daemon_free_robot_set(tfa_daemon *d);

/* ---- reload.c: other models while it runs; reload_load.c: its thread ---- */

/* SIGHUP: begins a reload, or notes that another one is wanted. */
void reload_request(tfa_daemon *d);
/* A robot_description came: loads it when nothing else is under way. */
void reload_described(tfa_daemon *d);
/* The thread is done. */
void reload_event(tfa_daemon *d);
/* Time passed: clients may have left, workers may have taken over. */
void reload_tick(tfa_daemon *d);
/* It waits for workers: look again soon. */
bool reload_is_urgent(const tfa_daemon *d);
/* Ends it whatever its phase; the workers run no more. @return false: its thread still reads, and
 * uses robots and configuration */
bool reload_abandon(tfa_daemon *d);
/* The thread: fills in d->reload from settings to solvers, and status. `d` is only read. */
void *reload_thread(void *d);

/* ---- descriptions.c: robot descriptions from topics ---- */

/* Makes room for those of all robots. @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM */
TFA_CHECKED int descriptions_open(tfa_daemon *d);
void descriptions_close(tfa_daemon *d);
/* A description was received: any thread. */
void descriptions_receive(tfa_daemon *d, size_t robot, const char *text);
/* The next one, for the caller to free, and its robot in the configuration; NULL: there is none. */
char *descriptions_take(tfa_daemon *d, size_t *robot);

/* ---- control.c: the control thread's loop ---- */

/* Opens epoll and the signals, which must be blocked. */
TFA_CHECKED int control_open(tfa_daemon *d);
/* Opens the sockets that are not open: from now on clients come. Notes in the lock file that all
 * are. */
TFA_CHECKED int control_listen(tfa_daemon *d);
/* Descriptions that are received are loaded from now on. */
TFA_CHECKED int control_watch_descriptions(tfa_daemon *d);
/* Until a signal says stop. */
void control_run(tfa_daemon *d);
/* Closes the sockets: no new clients. */
void control_close_listeners(tfa_daemon *d);
void control_close(tfa_daemon *d);
uint64_t control_clock(void);
/* Takes a connection, or hangs up on it where descriptors have run out. @return it, or -1 */
int control_accept(tfa_daemon *d, int listener);

/* ---- commands.c: operators ---- */

/* None yet. The first thing: everything may end from then on. */
void commands_open(tfa_daemon *d);
TFA_CHECKED int commands_listen(tfa_daemon *d);
void commands_unlisten(tfa_daemon *d);
void commands_accept(tfa_daemon *d);
/* Something happened at `what`. @return it is a command's connection */
bool commands_event(tfa_daemon *d, void *what);
/* A reload ended: answers those that wait for it. */
void commands_reloaded(tfa_daemon *d, const char *text);
void commands_tick(tfa_daemon *d);
void commands_close(tfa_daemon *d);

/* ---- live_page.c: the HTTP server ---- */

/* Starts it, if configured: when statistics and robots are there. */
TFA_CHECKED int live_page_start(tfa_daemon *d);
/* Opens the socket of metrics, if configured and not open. */
TFA_CHECKED int live_page_listen(tfa_daemon *d);
void live_page_unlisten(tfa_daemon *d);
void live_page_stop(tfa_daemon *d);

/* ---- statistics.c: counters in shared memory ---- */

/* Makes the segment for the robots of the set and all clients, and describes the robots. */
TFA_CHECKED int statistics_open(tfa_daemon *d);
/* Robots were exchanged: describes them again. */
void statistics_update(tfa_daemon *d);
void statistics_close(tfa_daemon *d);
/* The blocks of a worker. */
tfa_worker_statistics statistics_of_worker(const tfa_daemon *d, uint32_t worker);
/* States that a gateway publishes, by robot. */
tfa_shared_state *statistics_gateway_states(const tfa_daemon *d, uint32_t source);
/* Requests of clients that left; of all clients, those that left and gateways included. */
tfa_tally_sums statistics_departed(const tfa_daemon *d);
tfa_tally_sums statistics_all(const tfa_daemon *d);
/* Sends a text with descriptors. @return whether the peer's buffer took it */
bool commands_send(int socket, const char *text, const int *descriptors, size_t count);

/* ---- recordings.c: recorders ---- */

/* Begins a recording, of which `order` has the rest of the command, and answers it. @return it has
 * the socket now; otherwise the error is in `text` */
bool recordings_begin(tfa_daemon *d, int socket, const char *order, char *text, size_t size);
/* Something happened at `what`. @return it is a recorder's connection */
bool recordings_event(tfa_daemon *d, void *what);
/* Ends those of a robot, with a reason for their recorders: no later answer is recorded. */
void recordings_end(tfa_daemon *d, uint32_t robot, const char *reason);
/* Time passed: workers may have let go of taps. */
void recordings_tick(tfa_daemon *d);
/* One waits for a worker: look again soon. */
bool recordings_any_ending(const tfa_daemon *d);
/* Ends all of them; the workers run no more. */
void recordings_close(tfa_daemon *d);

/* ---- status.c ---- */

/* Writes the status as JSON; free(*text). @return TFA_OK; TFA_E_MEMORY */
TFA_CHECKED int status_write(const tfa_daemon *d, char **text, size_t *size);

/* ---- session.c: clients ---- */

/* A connection was accepted: it becomes a session, or is refused with a reason. */
void session_begin(tfa_daemon *d, uint32_t robot, int socket);
/* Something happened on its socket. */
void session_event(tfa_daemon *d, session *s);
/* Time passed: late handshakes, broken protocols, clients to detach. */
void session_tick(tfa_daemon *d);
/* Ends all of them; the workers run no more. */
void session_end_all(tfa_daemon *d);
/* The clients of a robot are detached when their requests are answered. */
void session_drain(tfa_daemon *d, uint32_t robot);
/* A client of this robot is attached. */
bool session_any_attached(const tfa_daemon *d, uint32_t robot);
/* Answers the HELLOs that were kept. */
void session_resume_deferred(tfa_daemon *d);
/* Some session waits for its worker: look again soon. */
bool session_any_detaching(const tfa_daemon *d);

/* ---- handshake.c: admission and handshake ---- */

/* May this process connect now? A connection counts from its first moment. @return TFA_OK; a
 * refusal, and its reason in the welcome */
int handshake_admit(tfa_daemon *d, int socket, const struct ucred *peer, tfa_welcome *w);
/* Answers the HELLO of a session, of `size` bytes. @return false: it was refused, or is gone */
bool handshake_answer(tfa_daemon *d, session *s, const tfa_hello *hello, ssize_t size);

/* ---- notify.c: the service manager ---- */

void notify_ready(void);
void notify_reloading(void);
void notify_stopping(void);
void notify_watchdog(void);
/* ns between two signs of life that the service manager wants; 0: none. */
uint64_t notify_watchdog_ns(void);

#endif
