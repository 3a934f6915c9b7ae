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

/**
 * Joins the domain of context->settings->dds and creates every entity, but nothing answers yet.
 * @param context      its functions are not called, its settings are read here only; `statistics`
 *                     and `states` may be NULL
 * @param robot_count  the first robots of the context, and of the worker; each model must live
 *                     until another was announced
 * @param xml          Cyclone's settings, if ROS 2 joins the domain, too; NULL: it does not
 * @param slots        requests under way for each robot, power of two; 0: 16
 * @return TFA_OK; TFA_E_ARGUMENT (no robot, a name too long); TFA_E_MEMORY; TFA_E_SYSTEM (the
 *         domain cannot be joined: see tfa_dds_error). On error *dds is NULL.
 */
TFA_CHECKED int tfa_dds_create(const gateway_context *context, uint32_t robot_count,
                               const char *xml, uint32_t slots, tfa_dds **dds);

/** Attaches to the worker, starts the threads, opens the gateway. Each robot is announced, and its
 *  requests are answered, when no other leader of it has advertised for a lease.
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
