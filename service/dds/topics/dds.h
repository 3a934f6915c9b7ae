/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway of the daemon: the topics of idl/totalforce.idl for all its robots.
 *
 * Short requests are answered in Cyclone's receiving thread, by solvers of the gateway's own; for
 * long ones the gateway is one more client of the worker, by address: nothing is encoded. It shares
 * nothing with the shared-memory clients.
 */
#ifndef TFA_SERVICE_DDS_DDS_H
#define TFA_SERVICE_DDS_DDS_H

#include "gateway/gateway.h"

typedef struct tfa_dds tfa_dds;

extern const struct gateway tfa_gateway_dds;

typedef struct tfa_dds_options {
    uint32_t domain;         /**< DDS domain id, 0..230 */
    const char *settings;    /**< Cyclone's XML, before CYCLONEDDS_URI; NULL: none */
    size_t sample_bytes;     /**< samples up to this size are taken, or larger ones if the
                                      robots need them */
    const tfa_robot *robots; /**< the first of the worker, in its order; each model must live
                                      until another was announced */
    uint32_t robot_count;
    uint32_t slots;      /**< requests under way for each robot, power of two; 0: 16 */
    uint32_t max_age_us; /**< torques with an older stamp are refused (TFA_E_LATE); 0: none is */
    uint32_t priority;   /**< among daemons that serve the same robot: the higher one leads */
    uint32_t lease_ms;   /**< a leader that is silent for so long is replaced; 0: 200 */
    /** Takes changes of leadership; `warning`: somebody should look. Any thread. NULL: none */
    void (*notice)(bool warning, const char *text);
    tfa_shared_dds *messages;     /**< where it counts */
    tfa_shared_robot *statistics; /**< by robot; NULL: robots are not counted */
    tfa_shared_state *states;     /**< by robot; NULL: none */
} tfa_dds_options;

/**
 * Joins the domain and creates every entity, but nothing answers yet.
 * @return TFA_OK; TFA_E_ARGUMENT (no robot, a name too long); TFA_E_MEMORY; TFA_E_SYSTEM (the
 *         domain cannot be joined: see tfa_dds_error). On error *dds is NULL.
 */
TFA_CHECKED int tfa_dds_create(const tfa_dds_options *options, tfa_dds **dds);

/** Attaches to the worker, starts the threads, opens the gateway. Each robot is announced, and its
 *  requests are answered, when no other daemon was heard for a lease that leads it.
 *  `solvers` (copied), one for each robot, are the gateway's own.
 *  @return TFA_OK; TFA_E_MEMORY; TFA_E_SYSTEM; the worker's status. */
TFA_CHECKED int tfa_dds_start(tfa_dds *dds, struct tfa_worker *worker,
                              const tfa_worker_robot *solvers);

/* The exchange of a model: see gateway.h. Until the worker has taken it over, replies may come from
 * the model before or the next one. */
void tfa_dds_exchange(void *dds, uint32_t robot, const tfa_model *next,
                      const tfa_worker_robot *solver);
void tfa_dds_set_tap(void *dds, uint32_t robot, struct tfa_tap *tap);
/** Requests that come meanwhile are refused with TFA_E_AGAIN. */
bool tfa_dds_detach(void *dds, uint32_t robot);
/** @return TFA_OK; TFA_E_SYSTEM; TFA_E_MEMORY or the worker's status: this daemon resigned, and
 *          begins again with the next model */
TFA_CHECKED int tfa_dds_announce(void *dds, uint32_t robot, const tfa_model *model);

/** Resigns, so that a standby takes over at once, withdraws the robots, closes the gateway, joins
 *  the threads, leaves the domain, frees. The worker must still run. NULL is allowed, and so is a
 *  gateway that was created and never started. */
void tfa_dds_stop(tfa_dds *dds);

bool tfa_dds_get_leadership(void *dds, uint32_t robot, gateway_leadership *leadership);

#endif
