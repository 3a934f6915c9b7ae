/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type Specialised: a kernel compiled for one robot.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"
#include "python/request/records.h"

#include <errno.h>
#include <stddef.h>

enum { REASON = 1024 };

static void specialised_dealloc(PyObject *self)
{
    specialised_object *s = (specialised_object *)self;
    tfa_specialised_free(s->specialised);
    Py_XDECREF(s->model);
    object_free(self);
}

static PyObject *failed(int status, const char *path, const char *reason)
{
    raise_status(status, NULL, "%s: %s", path, reason[0] ? reason : tfa_status_cause(status));
    return NULL;
}

static PyObject *specialised_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"", "", NULL};
    PyObject *path = NULL, *model;
    char reason[REASON] = "";
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O&O!:Specialised", names, PyUnicode_FSConverter,
                                     &path, model_type, &model)) {
        Py_XDECREF(path);
        return NULL;
    }
    specialised_object *s = (specialised_object *)PyType_GenericAlloc(type, 0);
    if (s) {
        const char *name = PyBytes_AsString(path);
        const tfa_model *m = ((model_object *)model)->model;
        int status, error;
        s->model = Py_NewRef(model);
        Py_BEGIN_ALLOW_THREADS status =
            tfa_specialised_load(name, m, &s->specialised, reason, sizeof reason);
        error = errno;
        Py_END_ALLOW_THREADS if (status != TFA_OK)
        {
            Py_CLEAR(s);
            errno = error;
            failed(status, name, reason);
        }
    }
    Py_DECREF(path);
    return (PyObject *)s;
}

static int read_build_options(PyObject *algorithm, tfa_specialise_options *o)
{
    unsigned k;
    if (choose_word("algorithm", algorithm, TFA_WORDS_ALGORITHM, &k))
        return -1;
    o->algorithm = (tfa_specialise_algorithm)k;
    return 0;
}

static PyObject *specialised_build(PyObject *unused, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"",        "",           "single",   "compiler",  "sources",
                            "seconds", "memory_mib", "file_mib", "algorithm", NULL};
    PyObject *model, *path = NULL, *algorithm = NULL, *made = NULL;
    tfa_specialise_options o = {0};
    int single = 0;
    char reason[REASON] = "";
    (void)unused;
    if (PyArg_ParseTupleAndKeywords(args, kwargs, "O!O&|$pzzO&O&O&O:build", names, model_type,
                                    &model, PyUnicode_FSConverter, &path, &single, &o.compiler,
                                    &o.sources, convert_u32, &o.seconds, convert_u32, &o.memory_mib,
                                    convert_u32, &o.file_mib, &algorithm) &&
        read_build_options(algorithm, &o) == 0) {
        const tfa_model *m = ((model_object *)model)->model;
        const char *name = PyBytes_AsString(path);
        tfa_specialise_result result = {0};
        int status, error;
        o.single = single != 0;
        Py_BEGIN_ALLOW_THREADS status =
            tfa_specialised_build(m, &o, name, &result, reason, sizeof reason);
        error = errno;
        Py_END_ALLOW_THREADS errno = error;
        made = status == TFA_OK ? record_build(&result) : failed(status, name, reason);
    }
    Py_XDECREF(path);
    return made;
}

static PyObject *specialised_file_name(PyObject *unused, PyObject *model)
{
    char name[TFA_SPECIALISED_NAME_SIZE];
    (void)unused;
    if (!Py_IS_TYPE(model, model_type)) {
        raise_type("model", "model: %.100s, must be a Model", type_name(model));
        return NULL;
    }
    tfa_specialised_name(((model_object *)model)->model, name);
    return PyUnicode_FromString(name);
}

static PyObject *get_info(PyObject *self, void *unused)
{
    (void)unused;
    const tfa_specialised_info info =
        tfa_specialised_describe(((specialised_object *)self)->specialised);
    return record_specialised(&info);
}

static PyGetSetDef attributes[] = {
    {"info", get_info, NULL, "Description of the kernel (SpecialisedInfo).", NULL}, {0}};

static PyMethodDef methods[] = {
    {"build", (PyCFunction)(void (*)(void))specialised_build,
     METH_VARARGS | METH_KEYWORDS | METH_STATIC,
     "build(model, path, /, *, single=False, compiler=None, sources=None, seconds=0, "
     "memory_mib=0, file_mib=0, algorithm=None)\n--\n\n"
     "Compiles a kernel of the model into the file `path`. Returns BuildResult.\n\n"
     "single: without code for batches. compiler: program, None: clang, gcc or cc. sources:\n"
     "folder of the sources, None: as installed. seconds, memory_mib, file_mib: limits, 0: 300 s,\n"
     "4096 MiB, 64 MiB. algorithm: 'fastest', 'aba' or 'crba'."},
    {"file_name", specialised_file_name, METH_O | METH_STATIC,
     "file_name(model, /)\n--\n\n"
     "Name of a model's kernel for this machine's instruction set, HASH-ISA.so."},
    {0}};

PyTypeObject *specialised_type;

static const type_members specialised_members = {
    .name = "totalforce.Specialised",
    .doc = "Specialised(path, model, /)\n--\n\n"
           "A kernel compiled for one robot, loaded and tested; for Workspace and Pool.\n\n"
           "Owner and mode of the file, checksum, version, model and instruction set are checked\n"
           "before any of its code runs.",
    .size = sizeof(specialised_object),
    .dealloc = specialised_dealloc,
    .methods = methods,
    .attributes = attributes,
    .make = specialised_new,
};

int specialised_init(PyObject *module)
{
    return add_type(module, &specialised_members, &specialised_type);
}
