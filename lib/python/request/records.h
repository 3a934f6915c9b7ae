/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Named tuples: joints, bodies, messages, times of an exchange and others.
 */
#ifndef PYTHON_RECORDS_H
#define PYTHON_RECORDS_H

#include "python_api.h"

#include <totalforce/limits.h>
#include <totalforce/specialised.h>
#include <totalforce/text.h>

/** Adds the types to the module. @return 0; -1 with an exception */
int records_init(PyObject *module);

/* Each returns a new reference; NULL with an exception. */
PyObject *record_joint(const tfa_joint_info *joint);
PyObject *record_body(const tfa_body_info *body);
PyObject *record_declared(const tfa_declared_joint *joint);
PyObject *record_summary(const tfa_model_summary *summary);
PyObject *record_message(const tfa_report *report, size_t index);
PyObject *record_exchange(const tfa_exchange *exchange);
PyObject *record_method(const tfa_method_info *method);
PyObject *record_specialised(const tfa_specialised_info *info);
PyObject *record_build(const tfa_specialise_result *result);
/** Of a tuple with the fields of Posture, whose reference it takes */
PyObject *record_posture(PyObject *tuple);
/** Configuration and Velocity of two arrays, or None for the base, whose references they take */
PyObject *record_configuration(PyObject *q, PyObject *base_pose);
PyObject *record_velocity(PyObject *v, PyObject *base_twist);
/** 1: a Configuration or a Velocity */
int is_record_pair(PyObject *value);
PyObject *record_limits(const tfa_joint_limits *limits);
/** `joints`: list of names */
PyObject *record_advice(PyObject *joints, uint32_t freedoms, PyObject *q, PyObject *single_error,
                        double error, uint32_t state);

/** Sets an entry of a dict, and takes the reference of its value; NULL: an exception is set.
 *  @return 0; -1 with an exception */
int set_entry(PyObject *dict, const char *key, PyObject *value);

#endif
