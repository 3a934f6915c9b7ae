/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A small synchronous client of totalforced over DDS: the twin of client.h for `--via dds`.
 *
 * It speaks the topics of idl/totalforce.idl and uses the same requests, replies, info and
 * statuses as the shared-memory client, so that a tool can drive either through one code path.
 * Times are CLOCK_MONOTONIC ns of this machine: the daemon's ROS times are translated, exact to
 * about 0.1 us when both run on one machine and meaningless as a split when they do not.
 *
 * Thread rules: a tfa_dds_client belongs to one thread at a time; different clients are
 * independent. Every function may allocate (DDS does).
 */
#ifndef TOOLS_DDS_CLIENT_DDS_CLIENT_H
#define TOOLS_DDS_CLIENT_DDS_CLIENT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/client.h>
#include <totalforce/dynamics.h>
#include <totalforce/status.h>

typedef struct tfa_dds_client tfa_dds_client;

/** Zero-initialise, then set the robot. */
typedef struct tfa_dds_client_options {
    uint32_t domain;   /**< DDS domain id, 0..230; the daemon's configuration has the same */
    const char *robot; /**< name in the daemon's configuration; required */
    int32_t connect_timeout_ms; /**< discovery of the daemon; 0: 5000 */
    tfa_wait wait;              /**< how a call waits; DEFAULT means HYBRID: see below */
    uint32_t spin_ns;           /**< hybrid: 0 means 50000 */
} tfa_dds_client_options;

/* Why HYBRID: a round trip over DDS takes turns of four threads (caller, worker, Cyclone's
 * receiving thread on either side), and a spinning client takes a core that the others need. On two
 * cores the daemon's worker sleeps for that reason and the caller spins: 35 us, every time
 * (service/worker/worker_client.c says how it was measured); with both asleep 85, with both
 * spinning 130. */

/**
 * Joins the domain and waits until the daemon has described the robot (RobotInfo) and all our
 * topics are matched with it, so that the first call cannot be lost.
 *
 * @return TFA_OK; TFA_E_ARGUMENT (no robot name, or longer than 63); TFA_E_ROBOT (daemons of
 *         the domain announce robots, none this one, until the timeout); TFA_E_TIMEOUT (no daemon
 *         found: same domain? same CYCLONEDDS_URI?); TFA_E_MEMORY; TFA_E_SYSTEM (the domain cannot
 *         be joined: a bad CYCLONEDDS_URI or no free participant index). On error *client is NULL.
 */
TFA_CHECKED int tfa_dds_client_connect(const tfa_dds_client_options *options,
                                       tfa_dds_client **client);

/** Leaves the domain and releases everything. NULL is allowed. */
void tfa_dds_client_close(tfa_dds_client *client);

/** Announcement of the robot; lives as long as the client. slots, wait and daemon_pid
 *  have no meaning over DDS and are 0. */
const tfa_client_info *tfa_dds_client_get_info(const tfa_dds_client *client);

/**
 * Sends one request and waits for its reply. The buffers in `reply` are filled as tfa_compute
 * would. Earlier requests sent with tfa_dds_client_send must have been received (TFA_E_AGAIN).
 *
 * After TFA_E_DISCONNECTED calls work again when the daemon is back with the same robot; if its
 * joints changed, connect anew. A daemon that is killed is missed only when its lease is over
 * (Cyclone: 10 s unless configured); until then calls time out.
 *
 * @param timeout_ns  0 waits until the daemon is gone
 * @param exchange    NULL or the times of this exchange
 * @return status of the reply (see tfa_compute), or TFA_E_TIMEOUT (a late reply is dropped),
 *         TFA_E_DISCONNECTED (the daemon left the domain), TFA_E_ARGUMENT, TFA_E_PROTOCOL (the
 *         reply does not fit the request), TFA_E_SYSTEM.
 */
int tfa_dds_client_call(tfa_dds_client *client, const tfa_request *request, tfa_reply *reply,
                        uint64_t timeout_ns, tfa_exchange *exchange);

/**
 * Publishes a request without waiting; at most 64 may be outstanding.
 * @return TFA_OK, TFA_E_AGAIN, TFA_E_ARGUMENT, TFA_E_DISCONNECTED, TFA_E_SYSTEM.
 */
TFA_CHECKED int tfa_dds_client_send(tfa_dds_client *client, const tfa_request *request,
                                    uint64_t *id);

/** Waits for the reply to the oldest request sent and not yet received; as tfa_dds_client_call.
 *  After TFA_E_TIMEOUT that request still counts as outstanding and may be received later. */
int tfa_dds_client_receive(tfa_dds_client *client, tfa_reply *reply, uint64_t timeout_ns,
                           tfa_exchange *exchange);

/** One sample of the torque stream. Arrays have the sizes of the robot; NULL: at rest or zero,
 *  base_pose only for a fixed base. */
typedef struct tfa_dds_torques {
    uint64_t seq;              /**< counted by the publisher */
    int64_t stamp;             /**< ns since 1970 (ROS time); 0: now */
    const double *q;           /**< q_count, rad or m */
    const double *v;           /**< v_count, rad/s or m/s */
    const double *tau;         /**< v_count, N m or N */
    const double *base_pose;   /**< 7: x y z (m), quaternion x y z w */
    const double *base_twist;  /**< 6, root link frame */
    const double *base_wrench; /**< 6, root link frame */
    const double *modes;       /**< mode_count; NULL: 0 */
    const double *mode_velocities; /**< mode_count, 1/s; NULL: 0 */
} tfa_dds_torques;

/** The answer to one sample. The caller gives qdd, base_acceleration and modes (NULL: not
 *  wanted). */
typedef struct tfa_dds_accelerations {
    uint64_t seq;              /**< of the torques it answers */
    int64_t stamp;             /**< of the torques it answers */
    double *qdd;               /**< v_count, rad/s^2 or m/s^2 */
    double *base_acceleration; /**< 6, root link frame */
    double *modes;             /**< mode_count, 1/s^2 */
    int32_t status;            /**< TFA_OK, or why there is no answer */
    tfa_field field;           /**< invalid field of a bad sample */
    uint32_t index;            /**< index in that field */
    tfa_answer answer;         /**< method, flags and estimate */
} tfa_dds_accelerations;

/**
 * Joins the streaming topics of the robot; needed once before publish and take.
 * @return TFA_OK, TFA_E_TIMEOUT (the daemon's streaming is off), TFA_E_SYSTEM.
 */
TFA_CHECKED int tfa_dds_stream_open(tfa_dds_client *client, int32_t timeout_ms);

/** Publishes one sample of joint torques. Does not wait. @return TFA_OK, TFA_E_ARGUMENT,
 *  TFA_E_SYSTEM. */
TFA_CHECKED int tfa_dds_stream_publish(tfa_dds_client *client, const tfa_dds_torques *torques);

/**
 * Takes the next sample of joint accelerations, in order; samples that arrive faster than they are
 * taken push out the oldest (keep last), so seq may jump.
 * @return TFA_OK (a sample: look at its status), TFA_E_TIMEOUT, TFA_E_DISCONNECTED,
 *         TFA_E_PROTOCOL (its sizes do not fit the robot), TFA_E_SYSTEM.
 */
TFA_CHECKED int tfa_dds_stream_take(tfa_dds_client *client, tfa_dds_accelerations *accelerations,
                                    uint64_t timeout_ns);

#endif
