/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The types of the module and what they read of one another.
 */
#ifndef PYTHON_OBJECTS_H
#define PYTHON_OBJECTS_H

#include "solver_object.h"

#include <totalforce/batch_pool.h>
#include <totalforce/constraints.h>
#include <totalforce/dynamics.h>
#include <totalforce/modes.h>
#include <totalforce/specialised.h>

typedef struct model_object {
    PyObject_HEAD robot_names robot;
    tfa_model *model;
    PyObject *parent;   /**< model whose constants it shares; NULL: none */
    PyObject *messages; /**< tuple of Message */
    PyObject *texts;    /**< tuple of the same as text */
    PyObject *source;   /**< bytes of the URDF; of a derived model NULL */
    PyObject *file;     /**< its name, or None */
    PyObject *options;  /**< dict as given; NULL: it cannot be copied, nor the model pickled */
} model_object;

typedef struct workspace_object {
    solver_object head;
    tfa_workspace *workspace;
    PyObject *model;       /**< model_object */
    PyObject *specialised; /**< NULL: none */
    const char *precision;
} workspace_object;

typedef struct specialised_object {
    PyObject_HEAD tfa_specialised *specialised;
    PyObject *model;
} specialised_object;

extern PyTypeObject *model_type, *workspace_type, *pool_type, *thread_pool_type, *client_type,
    *specialised_type, *sweep_type;

/* Each prepares its type and adds it to the module. @return 0; -1 with an exception */
int model_init(PyObject *module);
int workspace_init(PyObject *module);
int pool_init(PyObject *module);
int client_init(PyObject *module);
int specialised_init(PyObject *module);
int sweep_init(PyObject *module);
int snapshots_init(PyObject *module);
int observer_init(PyObject *module);

/** model_options.c: options of a model, with the memory that they point to */
typedef struct model_options model_options;

/** Names of the options for PyArg_ParseTupleAndKeywords, after one of the type itself */
struct model_options {
    PyObject *base, *gravity, *rotor_inertia, *damping, *friction, *friction_velocity,
        *lock_massless_leaves, *inertia, *mimic, *snap, *root, *tips, *locked, *payload, *armature,
        *rotors, *modes, *constraints, *actuated;
    tfa_model_options c;
    tfa_scene scene;
    double gravity_numbers[3];
    tfa_lock *locks;
    tfa_payload *payloads;
    tfa_rotor *rotor_list;
    const char **tip_names, **actuated_names;
    tfa_modes link_modes;
    tfa_constraints constraint_lists;
    PyObject *modes_texts; /**< list of the files' bytes: what makes the model again; or NULL */
    PyObject *constraints_texts; /**< as above; NULL: dicts */
    PyObject *names; /**< list that keeps strings alive */
};

/** Reads the values of the Python options into `c`. @return 0; -1 with an exception.
 *  model_options_clear in either case. */
int model_options_read(model_options *options);
void model_options_clear(model_options *options);
/** Gives joints armature, damping and friction of dicts. @return 0; -1 with an exception */
int set_joint_values(const model_options *options, tfa_description *description);

/** Payloads of a dict or a list of dicts. @return 0; -1 with an exception; `*payloads` is
 *  allocated by PyMem, `keep` gets the names. */
int read_payloads(PyObject *value, PyObject *keep, tfa_payload **payloads, size_t *count);

/** Function of the module: messages of loading name options of a command line from then on. */
PyObject *model_speak_command_line(PyObject *module, PyObject *unused);

/** Raises LoadError of a report and releases that. @return NULL */
PyObject *raise_load_error(int status, const char *path, tfa_report *report);

/** Bytes of a URDF: itself as str or bytes, or read from a file, whose name `*file` gets (free it;
 *  else NULL). A new reference; NULL with an exception */
PyObject *read_source(PyObject *source, char **file);

/** model_info.c */
extern PyGetSetDef model_attributes[];
extern PyMethodDef model_methods[];

/** model_configuration.c */
extern PyMethodDef configuration_methods[];
/** {joint: JointLimits} of the URDF in bytes, for a tuple of names; NULL with an exception */
PyObject *limits_of_joints(PyObject *source, PyObject *names);

/** Options of workspaces and pools that are words. @return 0; -1 with an exception */
int read_precision(PyObject *precision, PyObject *residual, tfa_precision *p, tfa_residual *r);
/** Methods to reserve memory for: None or a list of names */
int read_methods(PyObject *value, uint32_t *methods);
/** The kernel of a Specialised for this model, or NULL for None */
int read_specialised(PyObject *value, const tfa_specialised **specialised);

/** Workspace.close_loops (posture.c) */
PyObject *workspace_close_loops(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                                PyObject *keywords);

/** An array of its own memory */
PyObject *array_of(const double *numbers, uint32_t count);

/* Functions of the module for totalforce_tools: */

/** _mechanisms(): names of the test mechanisms (trials.c) */
PyObject *list_mechanisms(PyObject *module, PyObject *unused);
/** _mechanism(name, bodies, *, radius, ratio, taper, curl, seed): its URDF as bytes (trials.c) */
PyObject *make_mechanism(PyObject *module, PyObject *args, PyObject *kwargs);
/** _suggest(wrong, words): the text of tfa_suggest_words (trials.c) */
PyObject *suggest(PyObject *module, PyObject *args);
/** _race(first, second, seconds, clock): times of two contestants in turns (race.c) */
PyObject *race(PyObject *module, PyObject *args, PyObject *kwargs);

#endif
