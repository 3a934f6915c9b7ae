/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of a running daemon: robots, clients, counters and histograms, read from shared memory
 * that workers and gateways write. Reading takes no lock and delays no writer.
 *
 *     tfa_statistics_open -> tfa_snapshot_create -> tfa_statistics_read, as often as needed
 */
#ifndef TOTALFORCE_STATISTICS_H
#define TOTALFORCE_STATISTICS_H

#include <stdint.h>
#include <totalforce/histogram.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TFA_STATISTICS_METHODS 16    /**< length of tfa_tally.methods: every tfa_method */
#define TFA_STATISTICS_STATUSES 27   /**< length of tfa_tally.statuses: every tfa_status */
#define TFA_STATISTICS_DECADES 20    /**< length of tfa_tally.estimate_decades */
#define TFA_STATISTICS_Q_MAX 256     /**< longest q of a tfa_robot_state */
#define TFA_STATISTICS_INPUTS_MAX 26 /**< inputs of a robot from ROS 2 */
#define TFA_STATISTICS_BITS 5        /**< resolution of the histograms: 6.3 % */
#define TFA_STATISTICS_RANGE 36      /**< times of 2^36 ns (69 s) and more are one bucket */
/** Buckets of each histogram. */
#define TFA_STATISTICS_BUCKETS TFA_HISTOGRAM_BUCKETS(TFA_STATISTICS_BITS, TFA_STATISTICS_RANGE)

/** A client's way to the daemon. */
typedef enum tfa_client_kind {
    TFA_CLIENT_NONE = 0,
    TFA_CLIENT_SHM = 1,  /**< a process that uses shared memory */
    TFA_CLIENT_DDS = 2,  /**< the DDS gateway, for all clients of a robot */
    TFA_CLIENT_ROS2 = 3, /**< the ROS 2 gateway, for a robot */
    TFA_CLIENT_SELF = 4, /**< a self-test of the daemon: not counted to the robot */
} tfa_client_kind;

/** "shm", "dds", "ros2", "self-test"; "" for any other number. Static storage. Any thread. */
TFA_API const char *tfa_client_kind_name(uint32_t kind);

/** A robot, or a scene of one, as the daemon serves it. */
typedef struct tfa_served_robot {
    char name[64];            /**< "arm", "arm.scene" */
    char model_hash[72];      /**< hexadecimal */
    char kernel_isa[32];      /**< instruction set of the kernel: "avx2", ... */
    char kernel_file[256];    /**< specialised kernel; "": the generic one answers */
    char precision[8];        /**< "f64" or "f32" */
    char ros2_namespace[256]; /**< "": not on ROS 2 */
    char ros2_node[256];      /**< name of the node */
    uint32_t joints;          /**< moving joints */
    uint32_t freedoms;        /**< v_count, without those of a floating base */
    uint32_t q_count;         /**< numbers of q */
    uint32_t base_freedoms;   /**< 6 with a floating base, else 0 */
    uint32_t dds;             /**< 1: served on DDS */
    uint32_t dds_domain;      /**< domain of DDS */
    uint32_t ros2_domain;     /**< domain of ROS 2 */
    uint32_t reserved;        /**< 0 */
} tfa_served_robot;

/** Identity of a client. */
typedef struct tfa_served_client {
    uint32_t kind;   /**< tfa_client_kind */
    uint32_t robot;  /**< index of the robot */
    int32_t worker;  /**< that serves it; -1: the gateway itself */
    int32_t process; /**< of a gateway: the daemon's */
    uint32_t user;   /**< user id */
    uint32_t slots;  /**< of its ring; 0: the gateway itself */
    uint64_t since;  /**< CLOCK_MONOTONIC ns */
} tfa_served_client;

/** Counters of requests. Sums: requests = all of statuses; requests - rejected = all of methods.
 *  While requests are answered, histograms may hold a few that the counters do not yet. */
typedef struct tfa_tally {
    uint64_t requests; /**< answered, with whatever status */
    uint64_t rejected; /**< of those: without an answer */
    uint64_t late;     /**< of those: TFA_E_LATE, the deadline had passed */
    uint64_t states;   /**< of requests with answers */
    uint64_t busy_ns;  /**< time spent on requests */
    uint64_t statuses[TFA_STATISTICS_STATUSES]; /**< requests; index: - tfa_status */
    uint64_t methods[TFA_STATISTICS_METHODS];   /**< requests with answers; index: tfa_method of
                                                     the first state; 0: not known */
    uint64_t refined;            /**< states of requests that asked for refinement steps */
    uint64_t estimates;          /**< states with an error estimate */
    uint64_t fallbacks;          /**< states that another method answered */
    uint64_t inaccurate;         /**< states with TFA_ANSWER_INACCURATE */
    uint64_t stalled;            /**< states with TFA_ANSWER_STALLED */
    uint64_t not_finite;         /**< states with TFA_ANSWER_NOT_FINITE */
    uint64_t residual_precision; /**< states with TFA_ANSWER_RESIDUAL_PRECISION */
    uint64_t sentinel;           /**< states with TFA_ANSWER_SENTINEL */
    double largest_estimate;     /**< of the error estimates; 0: none */
    uint64_t estimate_decades[TFA_STATISTICS_DECADES]; /**< estimates; index k: below 10^(k - 18),
                                                            the last: all others */
    tfa_histogram queue;                               /**< ns from received to start */
    tfa_histogram compute;                             /**< ns from start to done */
    tfa_histogram total; /**< ns from sent to done, of requests whose client stamped them */
} tfa_tally;

/** State of the most recent request with an answer, published at most every 10 ms. */
typedef struct tfa_robot_state {
    uint64_t time;                  /**< CLOCK_MONOTONIC ns; 0: none yet */
    uint32_t q_count;               /**< 0: the robot has more than TFA_STATISTICS_Q_MAX */
    uint32_t floating;              /**< 1: base_pose is set */
    double base_pose[7];            /**< x y z (m), quaternion x y z w */
    double q[TFA_STATISTICS_Q_MAX]; /**< rad or m, in the order of the model */
} tfa_robot_state;

/** A topic that a robot's ROS 2 gateway reads. */
typedef struct tfa_input_statistics {
    char name[104];      /**< of the topic, cut if longer */
    uint32_t publishers; /**< matched, at most a second old */
    uint32_t reserved;   /**< 0 */
    uint64_t received;   /**< messages */
    uint64_t refused;    /**< messages: their content */
    uint64_t oversized;  /**< messages: too long to be read */
    uint64_t last;       /**< receipt of the last, CLOCK_MONOTONIC ns; 0: none */
} tfa_input_statistics;

/** Inputs and outputs of a robot on ROS 2. */
typedef struct tfa_ros2_statistics {
    uint32_t input_count; /**< of inputs */
    uint32_t subscribers; /**< of all outputs, at most a second old */
    uint64_t refused;     /**< answers that were not given: an input was missing, too old or bad */
    char refusal[160];    /**< why the last of them was not */
    tfa_input_statistics inputs[TFA_STATISTICS_INPUTS_MAX]; /**< input_count are set */
} tfa_ros2_statistics;

/** Statistics of a robot. */
typedef struct tfa_robot_statistics {
    tfa_served_robot served; /**< the robot */
    tfa_tally total;         /**< of `departed` and all clients of the robot but self-tests */
    tfa_tally departed;      /**< of clients that left */
    uint32_t clients;        /**< connections of other processes: no gateways, no self-tests */
    uint32_t queued;         /**< requests that wait, as tfa_client_statistics.queued */
    uint64_t dds_request;    /**< receipt of the last request by DDS, CLOCK_MONOTONIC ns; 0: none */
    uint64_t dds_torques;    /**< the same of the torque stream */
    tfa_robot_state state;   /**< last state */
    tfa_ros2_statistics ros2; /**< all 0 if the robot is not on ROS 2 */
} tfa_robot_statistics;

/** Statistics of a client. */
typedef struct tfa_client_statistics {
    tfa_served_client served; /**< the client */
    uint32_t queued;          /**< requests in its ring, at most 10 ms old while the worker works */
    uint32_t slot;            /**< with served.worker and .since it names the client */
    tfa_tally tally;          /**< since it came */
} tfa_client_statistics;

/** Messages of the DDS gateway. */
typedef struct tfa_dds_statistics {
    uint64_t requests;             /**< samples taken from the request topic */
    uint64_t torques;              /**< samples taken from the torque topic */
    uint64_t replies;              /**< replies and accelerations written */
    uint64_t rejected;             /**< of those: bad input, too late, or no free slot */
    uint64_t late;                 /**< of those: too late */
    uint64_t unknown;              /**< samples about robots that are not served here: dropped */
    uint64_t dropped;              /**< of the answers: DDS would not take them */
    uint64_t handovers;            /**< requests that went to the worker */
    uint64_t standby;              /**< samples that were left to the leader: another daemon */
    uint64_t request_writers;      /**< matched endpoints of others, at most a second old */
    uint64_t reply_readers;        /**< the same */
    uint64_t torque_writers;       /**< the same */
    uint64_t acceleration_readers; /**< the same */
} tfa_dds_statistics;

/** A copy of all statistics. */
typedef struct tfa_snapshot {
    uint64_t time;          /**< of the copy, CLOCK_MONOTONIC ns */
    uint64_t start;         /**< of the daemon, CLOCK_MONOTONIC ns */
    int32_t process;        /**< of the daemon */
    char version[36];       /**< of the daemon */
    char runtime_dir[116];  /**< its runtime directory, as configured: ROBOT.sock is there */
    uint32_t stopped;       /**< 1: the daemon ended in good order; nothing changes any more */
    uint32_t dds_on;        /**< 1: `dds` is set */
    uint64_t reloads;       /**< robots were exchanged so often */
    uint64_t connections;   /**< of clients to sockets, since the start */
    uint64_t refused;       /**< connections that were refused */
    uint64_t heartbeat;     /**< sum of the workers': it changes at least every second */
    tfa_dds_statistics dds; /**< of the DDS gateway */
    uint32_t worker_count;  /**< workers */
    uint32_t robot_count;   /**< robots and scenes */
    uint32_t client_count;  /**< clients that are there now, gateways included */
    uint32_t reserved;      /**< 0 */
    tfa_robot_statistics *robots;   /**< robot_count */
    tfa_client_statistics *clients; /**< client_count */
} tfa_snapshot;

/** Statistics of a daemon, mapped into this process. One thread at a time. */
typedef struct tfa_statistics tfa_statistics;

/**
 * Opens the statistics of the daemon with this runtime directory, by its control socket. The memory
 * is mapped read-only. After the end of the daemon its last figures stay readable.
 *
 * @param runtime_dir  NULL: as tfa_client_connect
 * @param timeout_ms   0: 10 s
 * @param statistics   receives them; NULL on error
 * @return TFA_OK; TFA_E_DISCONNECTED (no daemon answers there); TFA_E_REFUSED (the socket is not
 *         open to this user); TFA_E_TIMEOUT; TFA_E_PROTOCOL (another version of the daemon);
 *         TFA_E_ARGUMENT; TFA_E_MEMORY; TFA_E_SYSTEM
 */
TFA_API TFA_CHECKED int tfa_statistics_open(const char *runtime_dir, int32_t timeout_ms,
                                            tfa_statistics **statistics);

/** Opens statistics in a descriptor, which stays the caller's. @return as tfa_statistics_open */
TFA_API TFA_CHECKED int tfa_statistics_map(int descriptor, tfa_statistics **statistics);

/** Unmaps. NULL is allowed; snapshots stay. */
TFA_API void tfa_statistics_close(tfa_statistics *statistics);

/** Makes a snapshot with room for everything that `statistics` may hold. @return TFA_OK;
 *  TFA_E_MEMORY */
TFA_API TFA_CHECKED int tfa_snapshot_create(const tfa_statistics *statistics,
                                            tfa_snapshot **snapshot);

/** Releases a snapshot. NULL is allowed. */
TFA_API void tfa_snapshot_free(tfa_snapshot *snapshot);

/**
 * Copies all statistics. Every tally is that of one moment, and the robot's `departed` and the
 * clients of a worker are: a client that leaves is in one of them. No lock, no system call, no
 * allocation; about 2 us and 3 us for each robot and client.
 *
 * @param statistics  of the daemon
 * @param snapshot    is overwritten
 * @return TFA_OK; TFA_E_BUSY (a writer was interrupted while it wrote: the snapshot is not
 *         complete; read again in a while);
 *         TFA_E_SIZE (the snapshot was made for smaller statistics)
 */
TFA_API TFA_CHECKED int tfa_statistics_read(const tfa_statistics *statistics,
                                            tfa_snapshot *snapshot);

#ifdef __cplusplus
}
#endif
#endif
