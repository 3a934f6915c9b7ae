/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Words, numbers and lists of names.
 */
#include "errors.h"
#include "interface/want_words.h"
#include "read.h"

#include <math.h>
#include <stdio.h>
#include <totalforce/text.h>

int choose(const char *field, PyObject *value, const char *const *list, size_t count,
           unsigned *choice)
{
    const char *word = PyUnicode_Check(value) ? PyUnicode_AsUTF8AndSize(value, NULL) : NULL;
    if (!word)
        return PyErr_Occurred()
                   ? -1
                   : raise_type(field, "%s: %.100s, must be a str", field, type_name(value));
    for (size_t k = 0; k < count; k++)
        if (strcmp(list[k], word) == 0) {
            *choice = (unsigned)k;
            return 0;
        }
    char text[600];
    tfa_suggest_words(word, list, count, text, sizeof text);
    return raise_status(TFA_E_ARGUMENT, field, "%s: no '%.200s'; %s", field, word, text);
}

int choose_word(const char *field, PyObject *value, tfa_words of, unsigned *choice)
{
    uint32_t count;
    const char *const *words = tfa_word_list(of, &count);
    *choice = 0;
    return value && value != Py_None ? choose(field, value, words, count, choice) : 0;
}

int read_numbers(const char *field, PyObject *value, uint32_t count, double *numbers)
{
    PyArrayObject *array =
        (PyArrayObject *)PyArray_FromAny(value, PyArray_DescrFromType(NPY_DOUBLE), 0, 0,
                                         NPY_ARRAY_CARRAY_RO | NPY_ARRAY_ENSUREARRAY, NULL);
    char what[80];
    snprintf(what, sizeof what, "must be %u number%s", count, count == 1 ? "" : "s");
    if (!array)
        return raise_from_current(field, what);
    const npy_intp size = PyArray_SIZE(array);
    const int fits = size == (npy_intp)count && PyArray_NDIM(array) <= 1;
    if (fits)
        memcpy(numbers, PyArray_DATA(array), count * sizeof *numbers);
    const int axes = PyArray_NDIM(array);
    Py_DECREF(array);
    return fits ? 0
                : raise_status(TFA_E_SIZE, field, "%s: %td numbers in %d axes, must be %u in one",
                               field, (ptrdiff_t)size, axes, count);
}

int convert_u32(PyObject *value, void *number)
{
    PyObject *whole = PyNumber_Index(value);
    if (!whole)
        return 0;
    const unsigned long k = PyLong_AsUnsignedLong(whole);
    Py_DECREF(whole);
    if (!PyErr_Occurred() && k <= UINT32_MAX) {
        *(uint32_t *)number = (uint32_t)k;
        return 1;
    }
    PyErr_Clear();
    raise_status(TFA_E_ARGUMENT, NULL, "%s", "a number is not within 0 to 4294967295");
    return 0;
}

/* Calls `add` for each element of a list, or for a single str. */
static int for_each(request_call *call, const char *field, PyObject *value, const char *what,
                    int (*add)(struct request_call *, const char *, PyObject *, Py_ssize_t))
{
    if (PyUnicode_Check(value))
        return add(call, field, value, 0);
    PyObject *list = PySequence_Tuple(value);
    int bad = 0;
    if (!list)
        return raise_from_current(field, what);
    for (Py_ssize_t k = 0; !bad && k < PyTuple_Size(list); k++)
        bad = add(call, field, PyTuple_GetItem(list, k), k);
    Py_DECREF(list);
    return bad;
}

static int add_tip(request_call *call, const char *field, PyObject *value, Py_ssize_t k)
{
    if (k >= TFA_MAX_TIPS)
        return raise_status(TFA_E_SIZE, field, "tips: more than %d links", TFA_MAX_TIPS);
    call->request.tip_count = (uint32_t)k + 1;
    return robot_find_link(call->robot, field, value, &call->request.tips[k]);
}

int read_tips(request_call *call, const input_row *input, PyObject *value)
{
    return for_each(call, input->name, value, "must be a list of links", add_tip);
}

static int add_constraint(request_call *call, const char *field, PyObject *value, Py_ssize_t k)
{
    uint32_t constraint;
    (void)k;
    if (robot_find_constraint(call->robot, field, value, &constraint))
        return -1;
    if (call->request.constraints >> constraint & 1)
        return raise_named(TFA_E_ARGUMENT, field, "constraint",
                           call->robot->names.constraints[constraint],
                           "constraints: '%.200s' twice; name it once",
                           call->robot->names.constraints[constraint]);
    call->request.constraints |= 1u << constraint;
    return 0;
}

int read_constraints(request_call *call, const input_row *input, PyObject *value)
{
    call->request.constraints = 0;
    return for_each(call, input->name, value, "must be a list of constraints", add_constraint);
}

int read_stabilisation(request_call *call, const input_row *input, PyObject *value)
{
    call->request.stabilisation = call->stabilisation;
    return read_numbers(input->name, value, 2, call->stabilisation);
}

int read_rows(request_call *call, const input_row *input, PyObject *value)
{
    unsigned k;
    const int bad = choose_word(input->name, value, TFA_WORDS_ROWS, &k);
    call->request.rows = (tfa_rows)k;
    call->rows_given = 1;
    return bad;
}

int read_frame(request_call *call, const input_row *input, PyObject *value)
{
    unsigned k;
    const int bad = choose_word(input->name, value, TFA_WORDS_FRAME, &k);
    call->request.frame = (tfa_reference_frame)k;
    return bad;
}

int read_rank_loss(request_call *call, const input_row *input, PyObject *value)
{
    unsigned k;
    const int bad = choose_word(input->name, value, TFA_WORDS_RANK_LOSS, &k);
    call->request.rank_loss = (tfa_rank_loss)k;
    return bad;
}

int read_rank_threshold(request_call *call, const input_row *input, PyObject *value)
{
    call->request.rank_threshold = &call->rank_threshold;
    call->rank_threshold = PyFloat_AsDouble(value);
    if (call->rank_threshold == -1 && PyErr_Occurred())
        return raise_from_current(input->name, "must be a number");
    if (!(call->rank_threshold > 0 && call->rank_threshold < 1))
        return raise_status(isfinite(call->rank_threshold) ? TFA_E_ARGUMENT : TFA_E_VALUE,
                            input->name,
                            "rank_threshold: %g, must be above 0 and below 1: relative to the "
                            "sum of the eigenvalues of lambda_inv",
                            call->rank_threshold);
    return 0;
}

int read_characteristic_length(request_call *call, const input_row *input, PyObject *value)
{
    const double x = call->characteristic_length = PyFloat_AsDouble(value);
    call->request.characteristic_length = &call->characteristic_length;
    if (x == -1 && PyErr_Occurred())
        return raise_from_current(input->name, "must be a number");
    if (!(x > 0 && isfinite(x)))
        return raise_status(isfinite(x) ? TFA_E_ARGUMENT : TFA_E_VALUE, input->name,
                            "characteristic_length: %g, must be a number of metres above 0", x);
    return 0;
}

int read_method(request_call *call, const input_row *input, PyObject *value)
{
    const char *names[32];
    const char *word = PyUnicode_Check(value) ? PyUnicode_AsUTF8AndSize(value, NULL) : NULL;
    const int32_t method = word ? tfa_method_find(word) : -1;
    if (method >= 0) {
        call->request.method = (tfa_method)method;
        return 0;
    }
    unsigned count = 0, k = 0;
    for (const tfa_method_info *row; count < 32 && (row = tfa_method_describe(count)); count++)
        names[count] = row->name;
    if (word && choose(input->name, value, names, count, &k) && PyErr_Occurred()) {
        PyObject *type, *error, *trace;
        PyErr_Fetch(&type, &error, &trace);
        PyErr_NormalizeException(&type, &error, &trace);
        PyObject *text = error ? PyObject_Str(error) : NULL;
        raise_status(TFA_E_METHOD, input->name, "%s",
                     text ? PyUnicode_AsUTF8AndSize(text, NULL) : "method");
        Py_XDECREF(text);
        Py_XDECREF(type);
        Py_XDECREF(error);
        Py_XDECREF(trace);
        return -1;
    }
    return choose(input->name, value, names, count, &k);
}

int read_refine(request_call *call, const input_row *input, PyObject *value)
{
    const long steps = PyLong_Check(value) && !PyBool_Check(value) ? PyLong_AsLong(value) : -1;
    if (!PyLong_Check(value) || PyBool_Check(value))
        return raise_type(input->name, "refine: %.100s, must be an int, 0 to %d", type_name(value),
                          TFA_MAX_REFINE);
    PyErr_Clear(); /* of a number beyond long */
    if (steps < 0 || steps > TFA_MAX_REFINE)
        return raise_status(TFA_E_ARGUMENT, input->name, "refine: must be 0 to %d", TFA_MAX_REFINE);
    call->request.refine = (uint32_t)steps;
    return 0;
}

int read_estimate(request_call *call, const input_row *input, PyObject *value)
{
    unsigned k;
    const int bad = choose_word(input->name, value, TFA_WORDS_ESTIMATE, &k);
    call->request.estimate = (tfa_estimate)k;
    return bad;
}

static int add_word(request_call *call, const char *field, PyObject *value, Py_ssize_t k)
{
    unsigned choice = 0;
    (void)k;
    if (choose(field, value, tfa_want_words, TFA_WANT_WORD_COUNT, &choice))
        return -1;
    call->request.flags |= tfa_want_flags[choice];
    return 0;
}

int read_want(request_call *call, const input_row *input, PyObject *value)
{
    return for_each(call, input->name, value, "must be a list of words", add_word);
}

static int add_name(request_call *call, const char *field, PyObject *value, Py_ssize_t k)
{
    const char *list[OUTPUT_COUNT];
    unsigned choice = 0;
    (void)k;
    for (int i = 0; i < OUTPUT_COUNT; i++)
        list[i] = outputs[i].name;
    if (choose(field, value, list, OUTPUT_COUNT, &choice))
        return -1;
    call->only |= UINT64_C(1) << choice;
    return 0;
}

int read_only(request_call *call, const input_row *input, PyObject *value)
{
    return for_each(call, input->name, value, "must be a list of names of answers", add_name);
}

int read_timeout(request_call *call, const input_row *input, PyObject *value)
{
    const double s = PyFloat_AsDouble(value);
    if (s == -1 && PyErr_Occurred())
        return raise_from_current(input->name, "must be a number of seconds");
    if (!(s > 0))
        return raise_status(TFA_E_ARGUMENT, input->name,
                            "timeout: %g, must be above 0 seconds; None waits", s);
    const double ns = s * 1e9;
    call->timeout_ns = ns >= 9e18 ? (uint64_t)9e18 : ns < 1 ? 1 : (uint64_t)ns;
    return 0;
}
