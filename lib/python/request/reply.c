/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Attributes of a reply: one for each row of the table of outputs, and the quality of the answer.
 */
#include "reply.h"

#include "call.h"
#include "records.h"

#include <inttypes.h>
#include <stdio.h>

typedef struct reply_object {
    PyObject_HEAD tfa_op op;
    int is_batch;
    int has_exchange;
    uint32_t base; /**< freedoms of a floating base, else 0 */
    uint64_t model;
    tfa_answer answer;
    tfa_exchange exchange;
    PyObject *outputs[OUTPUT_COUNT];
    PyObject *answers; /**< of a batch; of one state made when it is asked for */
} reply_object;

PyObject *reply_spectrum_type, *reply_rank_type, *reply_answer_type;

static void drop_arrays(reply_object *r)
{
    for (int k = 0; k < OUTPUT_COUNT; k++)
        Py_CLEAR(r->outputs[k]);
    Py_CLEAR(r->answers);
}

static void reply_dealloc(PyObject *self)
{
    drop_arrays((reply_object *)self);
    object_free(self);
}

PyObject *call_reply(request_call *call, const tfa_exchange *exchange)
{
    reply_object *r = (reply_object *)call->reused;
    PyObject *old[OUTPUT_COUNT + 1] = {NULL};
    if (r) {
        Py_INCREF((PyObject *)r);
        memcpy(old, r->outputs, sizeof r->outputs);
        old[OUTPUT_COUNT] = r->answers;
    } else if (!(r = PyObject_New(reply_object, reply_type))) {
        return NULL;
    }
    r->op = call->request.op;
    r->is_batch = call->is_batch;
    r->base = call->robot->names.base_freedoms;
    r->model = call->reply.model;
    r->answer = call->answer;
    r->has_exchange = exchange != NULL;
    r->exchange = exchange ? *exchange : (tfa_exchange){0};
    memcpy(r->outputs, call->outputs, sizeof r->outputs);
    memset(call->outputs, 0, sizeof call->outputs);
    r->answers = call->answers;
    call->answers = NULL;
    for (int k = 0; call->reused && k <= OUTPUT_COUNT; k++)
        Py_XDECREF(old[k]);
    return (PyObject *)r;
}

int reply_check(PyObject *object)
{
    return Py_IS_TYPE(object, reply_type);
}

PyObject *reply_output(PyObject *reply, int k)
{
    return ((reply_object *)reply)->outputs[k];
}

/* An array, or a number where there is one only: a new reference. */
static PyObject *array_or_number(PyObject *array)
{
    return PyArray_Return((PyArrayObject *)Py_NewRef(array));
}

/* 1: output k is of base and joints, and the base floats: two answers */
static int has_base(const reply_object *r, int k)
{
    return outputs[k].layout == LAYOUT_FREEDOMS && r->base;
}

/* Output k as an answer, a new reference; of one with two answers the view of that part. NULL
 * without an exception where there is none. */
static PyObject *answer_of(const reply_object *r, int k, int of_base)
{
    PyObject *array = r->outputs[k];
    if (!array || (of_base && !has_base(r, k)))
        return NULL;
    if (!has_base(r, k))
        return array_or_number(array);
    PyObject *six = PyLong_FromUnsignedLong(r->base);
    PyObject *slice = six ? PySlice_New(of_base ? NULL : six, of_base ? six : NULL, NULL) : NULL;
    PyObject *key = slice ? PyTuple_Pack(2, Py_Ellipsis, slice) : NULL;
    PyObject *view = key ? PyObject_GetItem(array, key) : NULL;
    Py_XDECREF(key);
    Py_XDECREF(slice);
    Py_XDECREF(six);
    return view;
}

static PyObject *get_part(PyObject *self, const output_row *output, int of_base)
{
    PyObject *answer = answer_of((reply_object *)self, (int)(output - outputs), of_base);
    if (answer || PyErr_Occurred())
        return answer;
    return PyErr_Format(PyExc_AttributeError, "%s answered no %s%s to this request",
                        op_name(((reply_object *)self)->op), of_base ? "base_" : "", output->name);
}

static PyObject *get_output(PyObject *self, void *closure)
{
    return get_part(self, closure, 0);
}

static PyObject *get_base_output(PyObject *self, void *closure)
{
    return get_part(self, closure, 1);
}

/* Members of spectrum and rank; the rank of lambda comes before that of the spectrum. */
static PyObject *get_member(PyObject *self, const char *member, enum tfa_layout first,
                            enum tfa_layout second)
{
    const enum tfa_layout layouts[] = {first, second};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < OUTPUT_COUNT; k++) {
            PyObject *array = ((reply_object *)self)->outputs[k];
            if (!array || outputs[k].layout != layouts[i] || layouts[i] < LAYOUT_SPECTRUM)
                continue;
            PyObject *name = PyUnicode_FromString(member);
            PyObject *part = name ? PyObject_GetItem(array, name) : NULL;
            Py_XDECREF(name);
            return part && PyArray_Check(part) ? PyArray_Return((PyArrayObject *)part) : part;
        }
    return PyErr_Format(PyExc_AttributeError, "%s answered no %s to this request",
                        op_name(((reply_object *)self)->op), member);
}

static PyObject *get_rank(PyObject *self, void *unused)
{
    (void)unused;
    return get_member(self, "rank", LAYOUT_RANK, LAYOUT_SPECTRUM);
}

static PyObject *get_of_rank(PyObject *self, void *closure)
{
    return get_member(self, closure, LAYOUT_RANK, LAYOUT_VECTOR);
}

static PyObject *get_of_spectrum(PyObject *self, void *closure)
{
    return get_member(self, closure, LAYOUT_SPECTRUM, LAYOUT_VECTOR);
}

/* ---- quality ---- */

static PyObject *get_answers(PyObject *self, void *unused)
{
    reply_object *r = (reply_object *)self;
    (void)unused;
    if (!r->answers) {
        r->answers =
            PyArray_NewFromDescr(&PyArray_Type, (PyArray_Descr *)Py_NewRef(reply_answer_type), 0,
                                 NULL, NULL, NULL, 0, NULL);
        if (r->answers)
            memcpy(PyArray_DATA((PyArrayObject *)r->answers), &r->answer, sizeof r->answer);
    }
    return Py_XNewRef(r->answers);
}

/* A str of each state's answer: of one state itself, of a batch a list */
static PyObject *texts(PyObject *self, const char *(*text)(const tfa_answer *))
{
    const reply_object *r = (const reply_object *)self;
    if (!r->is_batch)
        return PyUnicode_FromString(text(&r->answer));
    const npy_intp count = PyArray_DIM((PyArrayObject *)r->answers, 0);
    const tfa_answer *answers = PyArray_DATA((PyArrayObject *)r->answers);
    PyObject *list = PyList_New(count);
    for (npy_intp k = 0; list && k < count; k++) {
        PyObject *entry = PyUnicode_FromString(text(&answers[k]));
        if (entry)
            PyList_SetItem(list, k, entry);
        else
            Py_CLEAR(list);
    }
    return list;
}

static const char *method_text(const tfa_answer *answer)
{
    return tfa_method_name(answer->method);
}

static const char *fallback_text(const tfa_answer *answer)
{
    return tfa_fallback_text(answer->flags);
}

static PyObject *get_method(PyObject *self, void *unused)
{
    (void)unused;
    return texts(self, method_text);
}

static PyObject *get_fallback(PyObject *self, void *unused)
{
    (void)unused;
    return texts(self, fallback_text);
}

static PyObject *get_answer_member(PyObject *self, void *closure)
{
    PyObject *answers = get_answers(self, NULL);
    PyObject *name = answers ? PyUnicode_FromString(closure) : NULL;
    PyObject *part = name ? PyObject_GetItem(answers, name) : NULL;
    Py_XDECREF(name);
    Py_XDECREF(answers);
    return part && PyArray_Check(part) ? PyArray_Return((PyArrayObject *)part) : part;
}

static PyObject *get_model(PyObject *self, void *unused)
{
    char text[20];
    (void)unused;
    snprintf(text, sizeof text, "%016" PRIx64, ((reply_object *)self)->model);
    return PyUnicode_FromString(text);
}

static PyObject *get_op(PyObject *self, void *unused)
{
    (void)unused;
    return PyUnicode_FromString(op_name(((reply_object *)self)->op));
}

static PyObject *get_exchange(PyObject *self, void *unused)
{
    const reply_object *r = (const reply_object *)self;
    (void)unused;
    return r->has_exchange ? record_exchange(&r->exchange) : Py_NewRef(Py_None);
}

/* ---- as a mapping ---- */

static PyObject *reply_keys(PyObject *self, PyObject *unused)
{
    PyObject *keys = PyList_New(0);
    (void)unused;
    for (int k = 0; keys && k < OUTPUT_COUNT; k++) {
        if (!((reply_object *)self)->outputs[k] || !output_has_numbers(k))
            continue;
        for (int of_base = 0; keys && of_base <= has_base((reply_object *)self, k); of_base++) {
            PyObject *name = PyUnicode_FromFormat("%s%s", of_base ? "base_" : "", outputs[k].name);
            if (!name || PyList_Append(keys, name) < 0)
                Py_CLEAR(keys);
            Py_XDECREF(name);
        }
    }
    return keys;
}

/* The answer of a name as answer_of; sets no exception for a name that is none */
static PyObject *find_answer(PyObject *self, PyObject *name)
{
    const char *key = PyUnicode_Check(name) ? PyUnicode_AsUTF8AndSize(name, NULL) : NULL;
    const int k = key ? output_find(key) : -1;
    if (k < 0)
        PyErr_Clear();
    return k < 0 ? NULL
                 : answer_of((reply_object *)self, k,
                             outputs[k].layout == LAYOUT_FREEDOMS && key[0] == 'b' &&
                                 strcmp(key, outputs[k].name) != 0);
}

static PyObject *reply_item(PyObject *self, PyObject *name)
{
    PyObject *answer = find_answer(self, name);
    if (!answer && !PyErr_Occurred())
        PyErr_SetObject(PyExc_KeyError, name);
    return answer;
}

static int reply_contains(PyObject *self, PyObject *name)
{
    PyObject *answer = find_answer(self, name);
    PyErr_Clear();
    Py_XDECREF(answer);
    return answer != NULL;
}

static Py_ssize_t reply_length(PyObject *self)
{
    PyObject *keys = reply_keys(self, NULL);
    const Py_ssize_t length = keys ? PyList_Size(keys) : -1;
    Py_XDECREF(keys);
    return length;
}

static PyObject *reply_iter(PyObject *self)
{
    PyObject *keys = reply_keys(self, NULL);
    PyObject *iterator = keys ? PyObject_GetIter(keys) : NULL;
    Py_XDECREF(keys);
    return iterator;
}

static PyObject *reply_repr(PyObject *self)
{
    const reply_object *r = (const reply_object *)self;
    PyObject *keys = reply_keys(self, NULL), *comma = PyUnicode_FromString(", ");
    PyObject *names = keys && comma ? PyUnicode_Join(comma, keys) : NULL;
    PyObject *text = NULL;
    if (names && r->is_batch)
        text = PyUnicode_FromFormat("<totalforce.Reply to %s of %zd states: %U>", op_name(r->op),
                                    (Py_ssize_t)PyArray_DIM((PyArrayObject *)r->answers, 0), names);
    else if (names)
        text = PyUnicode_FromFormat("<totalforce.Reply to %s: %U>", op_name(r->op), names);
    Py_XDECREF(names);
    Py_XDECREF(comma);
    Py_XDECREF(keys);
    return text;
}

/* ---- pickling ---- */

/* dict of all arrays by name */
static PyObject *all_outputs(const reply_object *r)
{
    PyObject *dict = PyDict_New();
    for (int k = 0; dict && k < OUTPUT_COUNT; k++)
        if (r->outputs[k] && PyDict_SetItemString(dict, outputs[k].name, r->outputs[k]) < 0)
            Py_CLEAR(dict);
    return dict;
}

static PyObject *reply_reduce(PyObject *self, PyObject *unused)
{
    const reply_object *r = (const reply_object *)self;
    PyObject *module = PyImport_ImportModule("totalforce._totalforce");
    PyObject *restore = module ? PyObject_GetAttrString(module, "_restore_reply") : NULL;
    PyObject *arrays = restore ? all_outputs(r) : NULL;
    (void)unused;
    Py_XDECREF(module);
    if (!arrays) {
        Py_XDECREF(restore);
        return NULL;
    }
    return Py_BuildValue("N(iiIKy#y#ON)", restore, (int)r->op, r->is_batch, r->base,
                         (unsigned long long)r->model, (const char *)&r->answer,
                         (Py_ssize_t)sizeof r->answer, (const char *)&r->exchange,
                         r->has_exchange ? (Py_ssize_t)sizeof r->exchange : 0,
                         r->answers ? r->answers : Py_None, arrays);
}

/* Takes the arrays; other entries are an error. */
static int take_outputs(reply_object *r, PyObject *arrays)
{
    Py_ssize_t found = 0;
    for (int k = 0; k < OUTPUT_COUNT; k++) {
        PyObject *array = PyDict_GetItemString(arrays, outputs[k].name);
        if (!array || !PyArray_Check(array))
            continue;
        r->outputs[k] = Py_NewRef(array);
        found++;
    }
    return found == PyDict_Size(arrays);
}

/* 1: each state of a batch has its answer, as the attributes read them */
static int are_answers(PyObject *answers, int is_batch)
{
    PyArrayObject *array = (PyArrayObject *)answers;
    if (answers == Py_None)
        return !is_batch;
    return PyArray_Check(answers) && PyArray_NDIM(array) == is_batch && PyArray_ISCARRAY(array) &&
           PyArray_EquivTypes(PyArray_DESCR(array), (PyArray_Descr *)reply_answer_type);
}

PyObject *reply_restore(PyObject *module, PyObject *args)
{
    int op, is_batch;
    unsigned base;
    unsigned long long model;
    Py_buffer answer = {0}, exchange = {0};
    PyObject *answers, *arrays;
    (void)module;
    if (!PyArg_ParseTuple(args, "iiIKy*y*OO!:_restore_reply", &op, &is_batch, &base, &model,
                          &answer, &exchange, &answers, &PyDict_Type, &arrays))
        return NULL;
    reply_object *r = PyObject_New(reply_object, reply_type);
    if (r)
        memset((char *)r + sizeof(PyObject), 0, sizeof *r - sizeof(PyObject));
    if (r && answer.len == (Py_ssize_t)sizeof r->answer &&
        (!exchange.len || exchange.len == (Py_ssize_t)sizeof r->exchange) &&
        are_answers(answers, is_batch) && take_outputs(r, arrays)) {
        r->op = (tfa_op)op;
        r->is_batch = is_batch;
        r->base = base;
        r->model = model;
        r->has_exchange = exchange.len != 0;
        memcpy(&r->answer, answer.buf, sizeof r->answer);
        memcpy(&r->exchange, exchange.buf, (size_t)exchange.len);
        r->answers = answers == Py_None ? NULL : Py_NewRef(answers);
    } else if (r) {
        PyErr_SetString(PyExc_ValueError, "a Reply that another version pickled");
        Py_CLEAR(r);
    }
    PyBuffer_Release(&answer);
    PyBuffer_Release(&exchange);
    return (PyObject *)r;
}

/* ---- the type ---- */

static PyGetSetDef attributes[2 * OUTPUT_COUNT + 18] = {
    {"op", get_op, NULL, "Name of the op.", NULL},
    {"method", get_method, NULL, "Method that answered; of a batch a list.", NULL},
    {"fallback", get_fallback, NULL,
     "Reason why another method than the one asked for answered; '': none did. Of a batch a list.",
     NULL},
    {"error_estimate", get_answer_member, NULL,
     "Relative error of qdd or lambda_inv, 2-norm; nan where it was not measured.",
     "error_estimate"},
    {"flags", get_answer_member, NULL, "ANSWER_ flags, uint16.", "flags"},
    {"answers", get_answers, NULL,
     "Structured array of status, method, flags and error_estimate, () or (count,).", NULL},
    {"model", get_model, NULL, "First 16 digits of the hash of the model that answered.", NULL},
    {"exchange", get_exchange, NULL, "Times of a client's exchange (Exchange); None otherwise.",
     NULL},
    {"rank", get_rank, NULL, "Rank of lambda_inv; with want spectrum, lambda, mu, p.", NULL},
    {"threshold", get_of_rank, NULL, "Eigenvalues above it count; with want lambda, mu, p.",
     "threshold"},
    {"condition", get_of_rank, NULL,
     "Sum of the eigenvalues times that of their inverses; inf if there is none.", "condition"},
    {"length", get_of_rank, NULL, "What a radian of a tip counts, m.", "length"},
    {"lambda_error_estimate", get_of_rank, NULL,
     "Relative error of lambda, mu, p and of the forces of a task.", "error_estimate"},
    {"eig_min", get_of_spectrum, NULL, "Smallest eigenvalue of lambda_inv; with want spectrum.",
     "eig_min"},
    {"eig_max", get_of_spectrum, NULL, "Largest eigenvalue of lambda_inv; with want spectrum.",
     "eig_max"},
};

static PyMethodDef methods[] = {
    {"keys", reply_keys, METH_NOARGS, "keys($self, /)\n--\n\nNames of the arrays of this reply."},
    {"__reduce__", reply_reduce, METH_NOARGS, NULL},
    {0}};

PyTypeObject *reply_type;

static const type_members reply_members = {
    .name = "totalforce.Reply",
    .doc = "Answers of one request.\n\n"
           "Every answer is an attribute and an item by its name: reply.qdd, reply['qdd'].\n"
           "Because `lambda` is a word of Python, its attribute is `lambda_`. dict(reply) has\n"
           "all arrays. An answer that the request did not ask for is an AttributeError.\n"
           "A batch has an axis of states first. n is the number of freedoms, those of a\n"
           "floating base (6) first; n_v those of the joints alone; rows are 6 or 3 for each\n"
           "tip. Matrices are row major.",
    .size = sizeof(reply_object),
    .dealloc = reply_dealloc,
    .repr = reply_repr,
    .iter = reply_iter,
    .length = reply_length,
    .item = reply_item,
    .contains = reply_contains,
    .methods = methods,
    .attributes = attributes,
};

/* dtype of a struct of the library: names, formats, offsets */
static PyObject *struct_type(const char *format, size_t size, ...)
{
    va_list list;
    va_start(list, size);
    PyObject *spec = Py_VaBuildValue(format, list);
    va_end(list);
    PyObject *number = spec ? PyLong_FromSize_t(size) : NULL;
    PyArray_Descr *type = NULL;
    if (number && PyDict_SetItemString(spec, "itemsize", number) == 0)
        PyArray_DescrConverter(spec, &type);
    Py_XDECREF(number);
    Py_XDECREF(spec);
    return (PyObject *)type;
}

static char *output_doc(const output_row *output)
{
    char rows[16], columns[16], text[400];
    const char *r = extent_name(tfa_outputs[output->block].rows, rows, sizeof rows);
    const char *c = extent_name(tfa_outputs[output->block].columns, columns, sizeof columns);
    if (output->layout == LAYOUT_FREEDOMS)
        c = extent_name(EXTENT_V, columns, sizeof columns);
    snprintf(text, sizeof text, "(%s%s%s%s): %s", r, *r ? ", " : "", c, *c && !*r ? "," : "",
             output->text);
    return strdup(text);
}

/* The attribute of the base's part of an output */
static PyGetSetDef base_attribute(const output_row *output)
{
    char name[64], text[100];
    snprintf(name, sizeof name, "base_%s", output->name);
    snprintf(text, sizeof text, "(6,): those of a floating base, as %s.", output->name);
    return (PyGetSetDef){strdup(name), get_base_output, NULL, strdup(text),
                         (void *)(uintptr_t)output};
}

int reply_init(PyObject *module)
{
    int at = 0;
    while (attributes[at].name)
        at++;
    for (int k = 0; k < OUTPUT_COUNT; k++)
        if (output_has_numbers(k))
            attributes[at++] = (PyGetSetDef){
                strcmp(outputs[k].name, "lambda") == 0 ? "lambda_" : outputs[k].name, get_output,
                NULL, output_doc(&outputs[k]), (void *)(uintptr_t)&outputs[k]};
    for (int k = 0; k < OUTPUT_COUNT; k++)
        if (outputs[k].layout == LAYOUT_FREEDOMS)
            attributes[at++] = base_attribute(&outputs[k]);
    const size_t d = offsetof(tfa_spectrum, eig_min), e = offsetof(tfa_spectrum, eig_max);
    reply_spectrum_type =
        struct_type("{s:(sss),s:(sss),s:(iii)}", sizeof(tfa_spectrum), "names", "rank", "eig_min",
                    "eig_max", "formats", "u4", "f8", "f8", "offsets", 0, (int)d, (int)e);
    reply_rank_type =
        struct_type("{s:(ssssss),s:(ssssss),s:(iiiiii)}", sizeof(tfa_rank), "names", "rank", "lost",
                    "threshold", "condition", "length", "error_estimate", "formats", "u4", "u4",
                    "f8", "f8", "f8", "f8", "offsets", 0, (int)offsetof(tfa_rank, lost),
                    (int)offsetof(tfa_rank, threshold), (int)offsetof(tfa_rank, condition),
                    (int)offsetof(tfa_rank, length), (int)offsetof(tfa_rank, error_estimate));
    reply_answer_type =
        struct_type("{s:(ssss),s:(ssss),s:(iiii)}", sizeof(tfa_answer), "names", "status", "method",
                    "flags", "error_estimate", "formats", "i4", "u2", "u2", "f8", "offsets", 0,
                    (int)offsetof(tfa_answer, method), (int)offsetof(tfa_answer, flags),
                    (int)offsetof(tfa_answer, error_estimate));
    if (!reply_spectrum_type || !reply_rank_type || !reply_answer_type)
        return -1;
    return add_type(module, &reply_members, &reply_type);
}
