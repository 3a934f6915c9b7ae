/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Arrays of states. A contiguous, aligned array of native float64 is used in place; any other is
 * converted once.
 */
#include "errors.h"
#include "read.h"

#include <stdio.h>

static int is_usable(PyArrayObject *array)
{
    return PyArray_TYPE(array) == NPY_DOUBLE && PyArray_IS_C_CONTIGUOUS(array) &&
           PyArray_ISALIGNED(array) && PyArray_ISNOTSWAPPED(array);
}

/* "(6,)", "(512, 7)" */
static void shape_text(PyArrayObject *array, char *text, size_t size)
{
    const int axes = PyArray_NDIM(array);
    size_t used = (size_t)snprintf(text, size, "(");
    for (int k = 0; k < axes && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%td", k ? ", " : "",
                                 (ptrdiff_t)PyArray_DIM(array, k));
    if (used < size)
        snprintf(text + used, size - used, "%s", axes == 1 ? ",)" : ")");
}

/* Says which shape an array has and which one the robot needs. */
static int raise_shape(const request_call *call, const char *field, int extent, uint32_t width,
                       PyArrayObject *array)
{
    char shape[160], joints[600] = "", why[800] = "";
    const int axes = PyArray_NDIM(array), of_q = extent == EXTENT_Q;
    shape_text(array, shape, sizeof shape);
    if (of_q || extent == EXTENT_V) {
        (void)tfa_names_describe(&call->robot->names, of_q, joints, sizeof joints);
        const int used = snprintf(why, sizeof why, ": the robot has %s", joints);
        if (axes && PyArray_DIM(array, axes - 1) == (npy_intp)width + (of_q ? 7 : 6))
            snprintf(why + used, sizeof why - (size_t)used,
                     "; a floating base has a field of its own, %s%s%s", tfa_base_field_name(field),
                     of_q ? " (x y z, quaternion x y z w)" : "",
                     call->robot->names.base_freedoms ? "" : "; this robot's base is fixed");
    } else if (extent == EXTENT_ROWS) {
        snprintf(why, sizeof why, ": %d rows for each of %u tips", rows_of(&call->request),
                 call->request.tip_count);
    } else if (extent == EXTENT_CONSTRAINTS) {
        snprintf(why, sizeof why, ": 6 for each of %u active constraints", width / 6);
    }
    return raise_status(TFA_E_SIZE, field, "%s: shape %s, must be (%u,) or (count, %u)%s", field,
                        shape, width, width, why);
}

/* Takes the number of states from an array with an axis of them. */
static int agree_on_count(request_call *call, const char *field, PyArrayObject *array)
{
    const npy_intp count = PyArray_DIM(array, 0);
    if (count < 1 || count > (npy_intp)UINT32_MAX)
        return raise_status(TFA_E_SIZE, field, "%s: %td states, must be 1 to %u", field,
                            (ptrdiff_t)count, UINT32_MAX);
    if (call->is_batch && (npy_intp)call->request.count != count)
        return raise_status(TFA_E_SIZE, field, "%s: %td states, other arrays have %u", field,
                            (ptrdiff_t)count, call->request.count);
    call->is_batch = 1;
    call->request.count = (uint32_t)count;
    return 0;
}

static int check_shape(request_call *call, const char *field, int extent, uint32_t width,
                       PyArrayObject *array)
{
    const int axes = PyArray_NDIM(array);
    if ((axes != 1 && axes != 2) || PyArray_DIM(array, axes - 1) != (npy_intp)width)
        return raise_shape(call, field, extent, width, array);
    return axes == 2 ? agree_on_count(call, field, array) : 0;
}

/* A usable array of any value, a new reference; NULL with an exception. */
static PyArrayObject *converted(const char *field, PyObject *value)
{
    PyArrayObject *array =
        (PyArrayObject *)PyArray_FromAny(value, PyArray_DescrFromType(NPY_DOUBLE), 0, 0,
                                         NPY_ARRAY_CARRAY_RO | NPY_ARRAY_ENSUREARRAY, NULL);
    if (!array)
        raise_from_current(field, "cannot be read as an array of float64");
    return array;
}

/* Appends a piece: an array whose last axis has `width` numbers. Shape and data are read once:
 * other threads may reshape an array while numpy converts or the request is computed. */
static int add_piece(request_call *call, const char *field, int extent, uint32_t width,
                     PyObject *value)
{
    PyArrayObject *array;
    if (PyArray_Check(value)) {
        /* before a conversion, which may be long */
        if (check_shape(call, field, extent, width, (PyArrayObject *)value))
            return -1;
        array = is_usable((PyArrayObject *)value) ? (PyArrayObject *)Py_NewRef(value)
                                                  : converted(field, value);
    } else {
        array = converted(field, value);
    }
    if (!array)
        return -1;
    const int is_batch = PyArray_NDIM(array) == 2;
    call->pieces[call->piece_count++] = (array_piece){array, PyArray_DATA(array), is_batch};
    return check_shape(call, field, extent, width, array);
}

static staged_array *stage(request_call *call, size_t member, uint32_t width)
{
    staged_array *s = &call->staged[call->staged_count++];
    *s = (staged_array){.member = member, .width = width, .first = call->piece_count, .pieces = 1};
    /* not NULL: answers that depend on the presence of an input are counted before
     * finish_arrays */
    *(const double **)(void *)((char *)&call->request + member) = &call->rank_threshold;
    return s;
}

int read_states(request_call *call, const input_row *input, PyObject *value)
{
    const uint32_t width = extent_size(input->width, call->robot, &call->request);
    const int of_modes = input->width == EXTENT_MODES;
    if (of_modes ? !width : call->robot->names.base_freedoms == 0)
        return raise_status(TFA_E_ARGUMENT, input->name, "%s: the robot%s", input->name,
                            of_modes ? " has no flexible links" : "'s base is fixed");
    stage(call, input->member, width);
    return add_piece(call, input->name, input->width, width, value);
}

/* Writes the numbers of one joint. */
static int read_joint_value(const char *field, PyObject *name, PyObject *value, uint32_t count,
                            double *numbers)
{
    char key[320];
    const char *joint = PyUnicode_Check(name) ? PyUnicode_AsUTF8AndSize(name, NULL) : "?";
    snprintf(key, sizeof key, "%s.%.200s", field, joint ? joint : "?");
    if (count == 1 && PyFloat_Check(value)) {
        numbers[0] = PyFloat_AsDouble(value);
        return 0;
    }
    return read_numbers(key, value, count, numbers);
}

/* {joint: value}; joints left out have the number `others`, floating ones in q no rotation. */
static PyObject *joints_by_name(const request_call *call, const input_row *input, PyObject *dict,
                                double others)
{
    const robot_names *robot = call->robot;
    const int of_q = input->width == EXTENT_Q;
    npy_intp size = of_q ? robot->names.q_count : robot->names.v_count;
    PyObject *items = PyDict_Items(dict);
    PyObject *array = items ? PyArray_ZEROS(1, &size, NPY_DOUBLE, 0) : NULL;
    double *numbers = array ? PyArray_DATA((PyArrayObject *)array) : NULL;
    for (npy_intp k = 0; array && k < size; k++)
        numbers[k] = others;
    for (uint32_t k = 0; array && of_q && k < robot->names.joint_count; k++)
        if (robot->names.joints[k].quaternion >= 0)
            numbers[robot->names.joints[k].q_index + (uint32_t)robot->names.joints[k].quaternion +
                    3] = 1;
    for (Py_ssize_t i = 0; array && i < PyList_Size(items); i++) {
        PyObject *name = PyTuple_GetItem(PyList_GetItem(items, i), 0);
        PyObject *value = PyTuple_GetItem(PyList_GetItem(items, i), 1);
        uint32_t k;
        int bad = robot_find_joint(robot, input->name, name, &k);
        if (!bad) {
            const tfa_joint_span *span = &robot->names.joints[k];
            bad = read_joint_value(input->name, name, value, of_q ? span->q_count : span->v_count,
                                   numbers + (of_q ? span->q_index : span->v_index));
        }
        if (bad)
            Py_CLEAR(array);
    }
    Py_XDECREF(items);
    return array;
}

int read_joints(request_call *call, const input_row *input, PyObject *value)
{
    const uint32_t width = extent_size(input->width, call->robot, &call->request);
    stage(call, input->member, width);
    if (!PyDict_Check(value))
        return add_piece(call, input->name, input->width, width, value);
    PyObject *array = joints_by_name(call, input, value, 0);
    if (!array)
        return -1;
    call->pieces[call->piece_count++] =
        (array_piece){(PyArrayObject *)array, PyArray_DATA((PyArrayObject *)array), 0};
    return 0;
}

int read_gravity(request_call *call, const input_row *input, PyObject *value)
{
    call->request.gravity = call->gravity;
    return read_numbers(input->name, value, 3, call->gravity);
}

/* A tuple of (link, value) of a dict or of a sequence of pairs, a new reference. */
static PyObject *pairs_of(const char *field, PyObject *value)
{
    PyObject *items = PyDict_Check(value) ? PyDict_Items(value) : Py_NewRef(value);
    PyObject *pairs = items ? PySequence_Tuple(items) : NULL;
    Py_XDECREF(items);
    for (Py_ssize_t k = 0; pairs && k < PyTuple_Size(pairs); k++) {
        PyObject *pair = PyTuple_GetItem(pairs, k);
        if (!PyTuple_Check(pair) || PyTuple_Size(pair) != 2) {
            Py_CLEAR(pairs);
            PyErr_SetString(PyExc_TypeError, "an entry is not a pair (link, numbers)");
        }
    }
    if (!pairs)
        raise_from_current(field, "must be {link: numbers} or a list of pairs (link, numbers)");
    return pairs;
}

/* Appends a piece for each pair, `width` numbers each. */
static int add_pairs(request_call *call, const input_row *input, PyObject *pairs, uint32_t width)
{
    for (Py_ssize_t k = 0; k < PyTuple_Size(pairs); k++) {
        PyObject *pair = PyTuple_GetItem(pairs, k);
        PyObject *name = PyTuple_GetItem(pair, 0);
        char key[320];
        const char *link = PyUnicode_Check(name) ? PyUnicode_AsUTF8AndSize(name, NULL) : "?";
        snprintf(key, sizeof key, "%s.%.200s", input->name, link ? link : "?");
        if (add_piece(call, key, EXTENT_NONE, width, PyTuple_GetItem(pair, 1)))
            return -1;
    }
    return 0;
}

int read_wrench(request_call *call, const input_row *input, PyObject *value)
{
    PyObject *pairs = pairs_of(input->name, value);
    if (!pairs)
        return -1;
    const Py_ssize_t count = PyTuple_Size(pairs);
    int bad = 0;
    if (count > TFA_MAX_WRENCHES)
        bad = raise_status(TFA_E_SIZE, input->name, "wrench: %zd links, at most %d", count,
                           TFA_MAX_WRENCHES);
    for (Py_ssize_t k = 0; !bad && k < count; k++)
        bad =
            robot_find_link(call->robot, input->name, PyTuple_GetItem(PyTuple_GetItem(pairs, k), 0),
                            &call->request.wrench_frames[k]);
    if (!bad && count) {
        stage(call, input->member, 6)->pieces = (uint32_t)count;
        call->request.wrench_count = (uint32_t)count;
        bad = add_pairs(call, input, pairs, 6);
    }
    Py_DECREF(pairs);
    return bad;
}

/* The links of an acceleration become the tips, or must be these in their order. */
static int tips_of(request_call *call, const input_row *input, PyObject *pairs)
{
    const Py_ssize_t count = PyTuple_Size(pairs);
    const uint32_t given = call->request.tip_count;
    if (count < 1 || count > TFA_MAX_TIPS || (given && count != (Py_ssize_t)given))
        return raise_status(TFA_E_SIZE, input->name,
                            "acceleration: %zd links for %u tips; leave tips out, or name the same "
                            "links in both, in the same order",
                            count, given);
    for (Py_ssize_t k = 0; k < count; k++) {
        uint32_t frame;
        PyObject *name = PyTuple_GetItem(PyTuple_GetItem(pairs, k), 0);
        if (robot_find_link(call->robot, input->name, name, &frame))
            return -1;
        if (given && frame != call->request.tips[k])
            return raise_named(TFA_E_LINK, input->name, "link",
                               tfa_names_frame(&call->robot->names, frame),
                               "acceleration: '%.200s' is not tip %zd; leave tips out, or name the "
                               "same links in both, in the same order",
                               tfa_names_frame(&call->robot->names, frame), k);
        call->request.tips[k] = frame;
    }
    call->request.tip_count = (uint32_t)count;
    return 0;
}

/* Without `rows`, three numbers of the first tip choose points. */
static int guess_rows(request_call *call, PyObject *pairs)
{
    PyObject *numbers = PyTuple_GetItem(PyTuple_GetItem(pairs, 0), 1);
    Py_ssize_t length;
    if (PyArray_Check(numbers)) {
        PyArrayObject *array = (PyArrayObject *)numbers;
        length = PyArray_NDIM(array) ? PyArray_DIM(array, PyArray_NDIM(array) - 1) : 0;
    } else {
        length = PySequence_Size(numbers);
        if (length < 0)
            return raise_from_current("acceleration", "must be 6 numbers for each tip, or 3");
    }
    if (!call->rows_given && length == 3)
        call->request.rows = TFA_ROWS_POINT;
    return 0;
}

int read_acceleration(request_call *call, const input_row *input, PyObject *value)
{
    if (!PyDict_Check(value)) {
        const uint32_t width = extent_size(input->width, call->robot, &call->request);
        if (!call->request.tip_count)
            return raise_status(TFA_E_SIZE, "tips",
                                "tips: missing; 1 to %d links, or acceleration "
                                "as a dict of links",
                                TFA_MAX_TIPS);
        stage(call, input->member, width);
        return add_piece(call, input->name, input->width, width, value);
    }
    PyObject *pairs = pairs_of(input->name, value);
    int bad = !pairs || tips_of(call, input, pairs) || guess_rows(call, pairs);
    if (!bad) {
        stage(call, input->member, 0)->pieces = call->request.tip_count;
        call->staged[call->staged_count - 1].width = rows_of(&call->request);
        bad = add_pairs(call, input, pairs, call->staged[call->staged_count - 1].width);
    }
    Py_XDECREF(pairs);
    return bad ? -1 : 0;
}

/* The six numbers of each active constraint: a piece that the dict has, or zeros */
static int add_active(request_call *call, const input_row *input, PyObject *const *given)
{
    const uint32_t active = call->request.constraints;
    stage(call, input->member, 6)->pieces = (uint32_t)__builtin_popcount(active);
    for (uint32_t left = active; left; left &= left - 1) {
        const int k = __builtin_ctz(left);
        npy_intp six = 6;
        char key[320];
        snprintf(key, sizeof key, "%s.%.200s", input->name, call->robot->names.constraints[k]);
        PyObject *value = given[k] ? Py_NewRef(given[k]) : PyArray_ZEROS(1, &six, NPY_DOUBLE, 0);
        const int bad = !value || add_piece(call, key, EXTENT_NONE, 6, value);
        Py_XDECREF(value);
        if (bad)
            return -1;
    }
    return 0;
}

int read_constraint_acceleration(request_call *call, const input_row *input, PyObject *value)
{
    PyObject *given[TFA_MAX_CONSTRAINTS] = {NULL}; /* borrowed of pairs */
    if (!PyDict_Check(value)) {
        const uint32_t width = extent_size(input->width, call->robot, &call->request);
        stage(call, input->member, width);
        return add_piece(call, input->name, input->width, width, value);
    }
    PyObject *pairs = pairs_of(input->name, value);
    int bad = !pairs;
    for (Py_ssize_t i = 0; !bad && i < PyTuple_Size(pairs); i++) {
        PyObject *pair = PyTuple_GetItem(pairs, i);
        uint32_t k = 0;
        bad = robot_find_constraint(call->robot, input->name, PyTuple_GetItem(pair, 0), &k);
        const char *name = bad ? "" : call->robot->names.constraints[k];
        if (!bad && !(call->request.constraints >> k & 1))
            bad = raise_named(TFA_E_ARGUMENT, input->name, "constraint", name,
                              "constraint_acceleration: '%.200s' is not active; name it in "
                              "constraints",
                              name);
        if (!bad)
            given[k] = PyTuple_GetItem(pair, 1);
    }
    if (!bad && call->request.constraints)
        bad = add_active(call, input, given);
    Py_XDECREF(pairs);
    return bad ? -1 : 0;
}

int read_torque_weights(request_call *call, const input_row *input, PyObject *value)
{
    const uint32_t width = extent_size(input->width, call->robot, &call->request);
    double *numbers = PyMem_Calloc((size_t)width + 1, sizeof *numbers);
    if (!numbers) {
        PyErr_NoMemory();
        return -1;
    }
    call->buffers[call->buffer_count++] = numbers;
    call->request.torque_weights = numbers;
    PyObject *array =
        PyDict_Check(value) ? joints_by_name(call, input, value, 1) : Py_NewRef(value);
    const int bad = !array || read_numbers(input->name, array, width, numbers);
    Py_XDECREF(array);
    return bad ? -1 : 0;
}

/* Copies pieces side by side for each state; a piece of one state is repeated. */
static double *gather(request_call *call, const staged_array *s)
{
    const size_t count = call->request.count, stride = (size_t)s->width * s->pieces;
    double *buffer = PyMem_Calloc(count * stride + 1, sizeof *buffer);
    if (!buffer) {
        PyErr_NoMemory();
        return NULL;
    }
    call->buffers[call->buffer_count++] = buffer;
    for (uint32_t i = 0; i < s->pieces; i++) {
        const array_piece *from = &call->pieces[s->first + i];
        const size_t step = from->is_batch ? s->width : 0;
        for (size_t k = 0; k < count; k++)
            memcpy(buffer + k * stride + (size_t)i * s->width, from->numbers + k * step,
                   s->width * sizeof *buffer);
    }
    return buffer;
}

int finish_arrays(request_call *call)
{
    for (uint32_t i = 0; i < call->staged_count; i++) {
        const staged_array *s = &call->staged[i];
        const array_piece *first = &call->pieces[s->first];
        const double *numbers = first->numbers;
        if (s->pieces > 1 || (call->request.count > 1 && !first->is_batch))
            numbers = gather(call, s);
        if (!numbers)
            return -1;
        *(const double **)(void *)((char *)&call->request + s->member) = numbers;
    }
    return 0;
}
