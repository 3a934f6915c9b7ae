/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a description and the configuration to models: of a robot and of its scenes.
 */
#ifndef TFA_SERVICE_ROBOTS_SCENE_H
#define TFA_SERVICE_ROBOTS_SCENE_H

#include <totalforce/description.h>
#include <totalforce/modes.h>

#include "config/config.h"

/**
 * A model and its holders. One that was derived from another holds that one, whose constants
 * it shares. Counted without atomics: one thread at a time, the control thread or the reload's.
 */
typedef struct tfa_shared_model {
    tfa_model *model;
    tfa_modes modes;                 /**< that it was compiled with */
    struct tfa_shared_model *origin; /**< NULL: it has constants of its own */
    uint32_t holders;
} tfa_shared_model;

/** Drops a reference to a model; the last one frees it. NULL is allowed. */
void tfa_shared_model_drop(tfa_shared_model *shared);

/** Source of a model that is served under one name. */
typedef struct tfa_robot_source {
    const config *settings;
    const config_robot *robot;
    const config_scene *scene; /**< NULL: the robot itself */
} tfa_robot_source;

/** Writes the robot's armatures into the description.
 *  @return TFA_OK; TFA_E_JOINT: there is no such joint (said in the log). */
TFA_CHECKED int tfa_robot_source_set_armature(const tfa_robot_source *robot,
                                              tfa_description *description);

/**
 * Compiles a robot or a scene, or derives it from one that was compiled before and differs in
 * gravity and payloads only. Names that do not exist are said in the log, with the nearest that do.
 *
 * @param before, before_count  models compiled of this robot so far, the robot itself first
 * @return TFA_OK and *made with one holder; TFA_E_LINK, TFA_E_JOINT, TFA_E_VALUE (a lock with the
 *         wrong number of coordinates); TFA_E_MEMORY; errors of tfa_modes_load, tfa_model_create
 *         and _derive.
 */
TFA_CHECKED int tfa_robot_source_compile(const tfa_robot_source *source,
                                         const tfa_description *description,
                                         const tfa_robot_source *before,
                                         tfa_shared_model *const *models, size_t before_count,
                                         tfa_report *report, tfa_shared_model **made);

#endif
