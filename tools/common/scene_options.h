/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Options that say how a URDF becomes a model - policies and the scene - for every subcommand that
 * loads one.
 */
#ifndef TOOLS_COMMON_SCENE_OPTIONS_H
#define TOOLS_COMMON_SCENE_OPTIONS_H

#include <argp.h>
#include <totalforce/constraints.h>
#include <totalforce/modes.h>

/** A lock as it stands on the command line: whether its numbers fit shows when the joint's type is
 *  known. */
typedef struct scene_lock {
    tfa_lock lock;
    uint32_t numbers;
} scene_lock;

/** Zero-initialise; release with scene_options_free. `model` points into the rest: do not copy. */
typedef struct scene_options {
    tfa_model_options model;
    tfa_scene scene;
    double gravity[3];
    scene_lock *locks;
    tfa_lock *lock_list; /**< of `scene` */
    const char **tips;
    tfa_payload *payloads;
    tfa_rotor *rotors, *armature;
    const char **modes_files; /**< `modes` has the first modes_read of them */
    tfa_modes modes;
    const char **constraints_files; /**< as modes_files */
    tfa_constraints constraints;
    uint32_t lock_count, tip_count, payload_count, rotor_count, armature_count, modes_count,
        modes_read, constraints_count, constraints_read;
} scene_options;

/** --base, --gravity, --mimic, --inertia, --rotor-inertia, --damping, --friction,
 *  --friction-velocity, --lock-massless-leaves, --lock, --root, --tip, --payload, --rotor,
 *  --armature, --modes, --constraints; its input is a scene_options. Names are kept as pointers
 *  into the argument vector, which is changed. */
extern const struct argp scene_argp;

/**
 * Loads files of modes and constraints, loads and compiles a URDF as the options say and prints
 * what the report says at or above `lowest` on standard error.
 * @return the model, or NULL after an error message
 */
tfa_model *load_scene(const char *path, scene_options *options, tfa_severity lowest,
                      tfa_report *report);

/** Adds a lock whose name outlives the options; scene_options_finish follows the last one.
 *  @return TFA_OK, TFA_E_MEMORY */
int scene_options_lock(scene_options *options, const scene_lock *lock);

/** Points the model's options at the scene, if there is one. */
void scene_options_finish(scene_options *options);

/** The words of --mimic and --inertia, by number; NULL ends them. */

void scene_options_free(scene_options *options);

#endif
