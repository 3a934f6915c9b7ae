/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Module totalforce._totalforce: types, functions, constants.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/records.h"
#include "python/request/reply.h"

#include <totalforce/client.h>
#include <totalforce/version.h>

static PyObject *list_methods(PyObject *module, PyObject *unused)
{
    PyObject *list = PyList_New(0);
    (void)module;
    (void)unused;
    for (uint32_t k = 0; list && tfa_method_describe(k); k++) {
        PyObject *row = record_method(tfa_method_describe(k));
        if (!row || PyList_Append(list, row) < 0)
            Py_CLEAR(list);
        Py_XDECREF(row);
    }
    return list;
}

static PyObject *isa(PyObject *module, PyObject *unused)
{
    (void)module;
    (void)unused;
    return PyUnicode_FromString(tfa_isa_name());
}

static PyObject *daemon_command(PyObject *module, PyObject *args, PyObject *kwargs)
{
    enum { ANSWER = 65536 };
    static char *names[] = {"command", "runtime_dir", "timeout", NULL};
    const char *command;
    PyObject *value = Py_None, *path = NULL, *answer = NULL;
    double timeout = 10;
    (void)module;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "s|$Od:daemon_command", names, &command, &value,
                                     &timeout) ||
        (value != Py_None && !PyUnicode_FSConverter(value, &path)))
        return NULL;
    char *text = PyMem_Calloc(1, ANSWER);
    if (!(timeout > 0 && timeout < 2e6)) {
        raise_status(TFA_E_ARGUMENT, "timeout", "timeout: %g, must be above 0 s", timeout);
    } else if (text) {
        const char *directory = path ? PyBytes_AsString(path) : NULL;
        int status;
        Py_BEGIN_ALLOW_THREADS status =
            tfa_daemon_command(directory, command, (int32_t)(timeout * 1e3) + 1, text, ANSWER);
        Py_END_ALLOW_THREADS if (status == TFA_OK) answer =
            PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
        else raise_status(status, NULL, "%s: %s", command,
                          text[0] ? text : tfa_status_cause(status));
    } else {
        PyErr_NoMemory();
    }
    PyMem_Free(text);
    Py_XDECREF(path);
    return answer;
}

static PyObject *joint_limits(PyObject *module, PyObject *args)
{
    PyObject *source, *names, *made;
    char *file;
    (void)module;
    if (!PyArg_ParseTuple(args, "OO!:_joint_limits", &source, &PyTuple_Type, &names) ||
        !(source = read_source(source, &file)))
        return NULL;
    made = limits_of_joints(source, names);
    Py_DECREF(source);
    free(file);
    return made;
}

static PyMethodDef functions[] = {
    {"methods", list_methods, METH_NOARGS,
     "methods()\n--\n\nThe table of methods: a list of Method (name, ops, cost, refusals)."},
    {"isa", isa, METH_NOARGS,
     "isa()\n--\n\nInstruction set of the kernels: 'avx512', 'avx2' or 'base'."},
    {"daemon_command", (PyCFunction)(void (*)(void))daemon_command, METH_VARARGS | METH_KEYWORDS,
     "daemon_command(command, *, runtime_dir=None, timeout=10.0)\n--\n\n"
     "Gives a command to a running daemon and returns its answer.\n\n"
     "'status': JSON of robots, workers, clients, counters; 'reload': reads configuration and\n"
     "robots again; 'stop'. runtime_dir as of Client; timeout in s."},
    {"_mechanism", (PyCFunction)(void (*)(void))make_mechanism, METH_VARARGS | METH_KEYWORDS, NULL},
    {"_mechanisms", list_mechanisms, METH_NOARGS, NULL},
    {"_race", (PyCFunction)(void (*)(void))race, METH_VARARGS | METH_KEYWORDS, NULL},
    {"_suggest", suggest, METH_VARARGS, NULL},
    {"_speak_command_line", model_speak_command_line, METH_NOARGS, NULL},
    {"_joint_limits", joint_limits, METH_VARARGS, NULL},
    {"_restore_reply", reply_restore, METH_VARARGS, NULL},
    {0}};

static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, .m_name = "totalforce._totalforce",
                                        .m_doc = "Extension module of the package totalforce.",
                                        .m_size = -1, .m_methods = functions};

static int add_constants(PyObject *module)
{
    static const struct {
        const char *name;
        long value;
    } constants[] = {
        {"ANSWER_ESTIMATED", TFA_ANSWER_ESTIMATED},
        {"ANSWER_FALLBACK", TFA_ANSWER_FALLBACK},
        {"ANSWER_INACCURATE", TFA_ANSWER_INACCURATE},
        {"ANSWER_STALLED", TFA_ANSWER_STALLED},
        {"ANSWER_NOT_FINITE", TFA_ANSWER_NOT_FINITE},
        {"ANSWER_RESIDUAL_PRECISION", TFA_ANSWER_RESIDUAL_PRECISION},
        {"ANSWER_SENTINEL", TFA_ANSWER_SENTINEL},
        {"ANSWER_RANK_LOSS", TFA_ANSWER_RANK_LOSS},
        {"ANSWER_MODE_LIMIT", TFA_ANSWER_MODE_LIMIT},
        {"ANSWER_PULLS", TFA_ANSWER_PULLS},
        {"MAX_TIPS", TFA_MAX_TIPS},
        {"MAX_WRENCHES", TFA_MAX_WRENCHES},
        {"MAX_PAYLOADS", TFA_MAX_PAYLOADS},
        {"MAX_REFINE", TFA_MAX_REFINE},
    };
    for (size_t k = 0; k < sizeof constants / sizeof *constants; k++)
        if (PyModule_AddIntConstant(module, constants[k].name, constants[k].value) < 0)
            return -1;
    PyObject *ops = PyTuple_New(OP_COUNT);
    for (int k = 0; ops && k < OP_COUNT; k++) {
        PyObject *name = PyUnicode_FromString(op_name(op_rows[k].op));
        if (!name)
            return -1;
        PyTuple_SetItem(ops, k, name);
    }
    if (!ops || PyModule_AddObject(module, "OPS", ops) < 0)
        return -1;
    return PyModule_AddStringConstant(module, "__version__", TFA_VERSION);
}

__attribute__((visibility("default"))) PyMODINIT_FUNC PyInit__totalforce(void);

PyMODINIT_FUNC PyInit__totalforce(void)
{
    PyObject *module = PyModule_Create(&definition);
    if (module &&
        (import_numpy() || fields_init() || solver_init() || reply_init(module) ||
         records_init(module) || model_init(module) || specialised_init(module) ||
         workspace_init(module) || pool_init(module) || client_init(module) || sweep_init(module) ||
         snapshots_init(module) || observer_init(module) || add_constants(module)))
        Py_CLEAR(module);
    return module;
}
