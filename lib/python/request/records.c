/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Each record is a PyStructSequence: fields by name and by position.
 */
#include "records.h"

#include "field_rows.h"

#include <math.h>

#define FIELD(name, doc)                                                                           \
    {                                                                                              \
        name, doc                                                                                  \
    }
#define RECORD(name, doc, fields, count)                                                           \
    {                                                                                              \
        "totalforce." name, doc, fields, count                                                     \
    }

static PyStructSequence_Field joint_fields[] = {
    FIELD("name", "of the URDF file"),
    FIELD("type", "'revolute', 'continuous', 'prismatic', 'planar' or 'floating'"),
    FIELD("q_index", "of its first coordinate in q"),
    FIELD("q_count", "coordinates"),
    FIELD("v_index", "of its first freedom in v, tau, qdd"),
    FIELD("v_count", "freedoms"),
    FIELD("body", "index of the body that it moves"),
    FIELD("armature", "reflected rotor inertia in use, kg m^2 or kg"),
    FIELD("damping", "in use, N m s/rad or N s/m"),
    FIELD("friction", "in use, N m or N"),
    {0}};
static PyStructSequence_Field body_fields[] = {
    FIELD("name", "child link of its last joint"),
    FIELD("parent", "index; -1: the world"),
    FIELD("freedoms", "of its joint"),
    FIELD("mass", "kg"),
    FIELD("com", "centre of mass, m, in the frame of that link"),
    FIELD("gyration_min", "smallest radius of gyration, m"),
    FIELD("gyration_max", "largest radius of gyration, m"),
    FIELD("condition", "largest over smallest principal moment"),
    FIELD("regular", "True: the inertia can be inverted"),
    {0}};
static PyStructSequence_Field declared_fields[] = {
    FIELD("name", "of the URDF file"),
    FIELD("type", "as Joint.type, or 'fixed'"),
    FIELD("fate", "'moves', 'fixed', 'locked', 'fused', 'follows' or 'absent'"),
    FIELD("body", "index of the body of its child link; -1: the world or absent"),
    FIELD("joint", "index in Model.joints; -1: it has no coordinates of its own"),
    FIELD("leader", "joint that it follows; -1: none"),
    FIELD("multiplier", "q = multiplier q[leader] + offset"),
    FIELD("offset", "rad or m"),
    FIELD("coordinates", "of a position in `locked`"),
    {0}};
static PyStructSequence_Field summary_fields[] = {
    FIELD("links", "as declared"),
    FIELD("joints", "as declared, fixed joints included"),
    FIELD("bodies", "after merging, a floating base included"),
    FIELD("q_count", "coordinates of the joints"),
    FIELD("v_count", "freedoms of the joints"),
    FIELD("depth", "bodies on the longest path from the root"),
    FIELD("main_chain", "bodies on the longest main chain"),
    FIELD("moving_mass", "kg"),
    FIELD("total_mass", "kg, a fixed base included"),
    FIELD("com", "centre of mass at q = 0, m, in the root link's frame"),
    FIELD("fixed", "joints of this fate"),
    FIELD("locked", "joints of this fate"),
    FIELD("fused", "joints of this fate"),
    FIELD("follows", "joints of this fate"),
    FIELD("absent", "joints of this fate"),
    FIELD("base", "'fixed' or 'floating'"),
    FIELD("gravity", "m/s^2, world axes"),
    FIELD("singular_body", "on a main chain, with an inertia that has no inverse; -1: none"),
    FIELD("mimics", "freedoms that follow others"),
    {0}};
static PyStructSequence_Field message_fields[] = {
    FIELD("severity", "'note', 'warning' or 'error'"),
    FIELD("file", "None: none"),
    FIELD("line", "from 1; 0: none"),
    FIELD("code", "stable code, for instance 'bad-number'"),
    FIELD("text", "problem and remedy"),
    FIELD("occurrences", "links, joints or elements that it is about"),
    FIELD("entity", "first link or joint; '': none"),
    {0}};
static PyStructSequence_Field exchange_fields[] = {
    FIELD("id", "of the request"),
    FIELD("t_sent", "client: request written, ns of CLOCK_MONOTONIC"),
    FIELD("t_received", "worker: request seen, ns"),
    FIELD("t_start", "worker: computing starts, ns"),
    FIELD("t_done", "worker: answer computed, ns"),
    FIELD("t_reply", "client: reply copied, ns"),
    FIELD("daemon", "'OK'; otherwise why the daemon did not answer and the fallback did"),
    {0}};
static PyStructSequence_Field method_fields[] = {
    FIELD("name", "for the argument `method`"),
    FIELD("ops", "names of the ops that it answers"),
    FIELD("cost", "order of operations"),
    FIELD("refuses", "list of requests and robots that it refuses"),
    FIELD("summary", "one line"),
    {0}};
static PyStructSequence_Field specialised_fields[] = {
    FIELD("path", "of the file"),
    FIELD("isa", "instruction set"),
    FIELD("compiler", "with its version"),
    FIELD("algorithms", "of each kind of request"),
    FIELD("bodies", "of the robot"),
    FIELD("lanes", "states of one SIMD batch"),
    FIELD("lanes_f32", "the same in single precision"),
    FIELD("error", "largest relative difference from the generic kernel"),
    FIELD("error_f32", "the same in single precision"),
    FIELD("digest", "SHA-256 of the file"),
    {0}};
static PyStructSequence_Field build_fields[] = {
    FIELD("compile_s", "wall-clock time of the compiler, s"),
    FIELD("bytes", "of the file"),
    FIELD("compiler", "its version line"),
    {0}};
static PyStructSequence_Field advice_fields[] = {
    FIELD("joints", "names of joints that may be locked together, ascending single error"),
    FIELD("freedoms", "their freedoms"),
    FIELD("q", "(n_q,): position at which each joint would be locked"),
    FIELD("single_error", "(joints,): error bound with that joint alone locked"),
    FIELD("error", "error bound with all `joints` locked, relative, energy norm"),
    FIELD("state", "index of the state with that error"),
    {0}};

static PyStructSequence_Field posture_fields[] = {
    FIELD("q", "(n_q,): meets the constraints"),
    FIELD("v", "(n_v,): their rates too"),
    FIELD("base_pose", "(7,), or None with a fixed base"),
    FIELD("base_twist", "(6,), or None with a fixed base"),
    FIELD("iterations", "steps of the posture"),
    FIELD("position", "largest error of a held row, m or rad; pi: met half a turn away"),
    FIELD("velocity", "largest error of a held row, m/s or rad/s"),
    FIELD("rank", "of the held rows, by the joints that are free"),
    FIELD("lost", "held rows less the rank"),
    {0}};

static PyStructSequence_Field configuration_fields[] = {
    FIELD("q", "(n_q,): coordinates of the joints"),
    FIELD("base_pose", "(7,), or None with a fixed base"),
    {0}};
static PyStructSequence_Field velocity_fields[] = {
    FIELD("v", "(n_v,): velocities of the joints"),
    FIELD("base_twist", "(6,), or None with a fixed base"),
    {0}};
static PyStructSequence_Field limits_fields[] = {
    FIELD("lower", "rad or m; -inf: none"),
    FIELD("upper", "rad or m; inf: none"),
    FIELD("velocity", "largest speed, rad/s or m/s; inf: none"),
    FIELD("effort", "largest force, N m or N; inf: none"),
    {0}};

static PyStructSequence_Desc descriptions[] = {
    RECORD("Joint", "A joint with its places in the arrays.", joint_fields, 10),
    RECORD("Body", "Mass properties of a body.", body_fields, 9),
    RECORD("DeclaredJoint", "A joint of the URDF file and its fate.", declared_fields, 9),
    RECORD("Summary", "Sizes and totals of a model.", summary_fields, 19),
    RECORD("Message", "A message of loading or compiling a robot.", message_fields, 7),
    RECORD("Exchange", "Times of one exchange with a daemon.", exchange_fields, 7),
    RECORD("Method", "A row of the table of methods.", method_fields, 5),
    RECORD("SpecialisedInfo", "A loaded specialised kernel.", specialised_fields, 10),
    RECORD("BuildResult", "Result of building a specialised kernel.", build_fields, 3),
    RECORD("Advice", "Joints that a scene may lock.", advice_fields, 6),
    RECORD("Posture", "A posture that meets the constraints.", posture_fields, 9),
    RECORD("Configuration", "A configuration, or one for each state of a batch.",
           configuration_fields, 2),
    RECORD("Velocity", "Velocities, or those of each state of a batch.", velocity_fields, 2),
    RECORD("JointLimits", "Limits of a joint, as its file states them.", limits_fields, 4),
};
enum {
    JOINT,
    BODY,
    DECLARED,
    SUMMARY,
    MESSAGE,
    EXCHANGE,
    METHOD,
    SPECIALISED,
    BUILD,
    ADVICE,
    POSTURE,
    CONFIGURATION,
    VELOCITY,
    LIMITS
};
enum { RECORD_COUNT = sizeof descriptions / sizeof descriptions[0] };

static PyTypeObject *types[RECORD_COUNT];

int records_init(PyObject *module)
{
    for (int k = 0; k < RECORD_COUNT; k++) {
        if (!types[k] && !(types[k] = PyStructSequence_NewType(&descriptions[k])))
            return -1;
        if (PyModule_AddObjectRef(module, strchr(descriptions[k].name, '.') + 1,
                                  (PyObject *)types[k]) < 0)
            return -1;
    }
    return 0;
}

/* A record of the values of a tuple, whose reference it takes; NULL: an exception is set. */
static PyObject *record(int type, PyObject *tuple)
{
    PyObject *made = tuple ? PyStructSequence_New(types[type]) : NULL;
    for (Py_ssize_t k = 0; made && k < PyTuple_Size(tuple); k++)
        PyStructSequence_SetItem(made, k, Py_NewRef(PyTuple_GetItem(tuple, k)));
    Py_XDECREF(tuple);
    return made;
}

PyObject *record_joint(const tfa_joint_info *j)
{
    return record(JOINT,
                  Py_BuildValue("(ssIIIIIddd)", j->name, tfa_joint_type_describe(j->type).name,
                                j->q_index, j->q_count, j->v_index, j->v_count, j->body,
                                j->armature, j->damping, j->friction));
}

PyObject *record_body(const tfa_body_info *b)
{
    return record(BODY, Py_BuildValue("(siId(ddd)dddN)", b->name, b->parent, b->freedoms, b->mass,
                                      b->com[0], b->com[1], b->com[2], b->gyration_min,
                                      b->gyration_max, b->condition, PyBool_FromLong(b->regular)));
}

PyObject *record_declared(const tfa_declared_joint *j)
{
    const tfa_joint_type_info type = tfa_joint_type_describe(j->type);
    return record(DECLARED, Py_BuildValue("(sssiiiddI)", j->name, type.name,
                                          tfa_word(TFA_WORDS_FATE, j->fate), j->body, j->joint,
                                          j->leader, j->multiplier, j->offset, type.coordinates));
}

PyObject *record_summary(const tfa_model_summary *s)
{
    return record(SUMMARY,
                  Py_BuildValue("(IIIIIIIdd(ddd)IIIIIs(ddd)iI)", s->links, s->joints, s->bodies,
                                s->q_count, s->v_count, s->depth, s->main_chain, s->moving_mass,
                                s->total_mass, s->com[0], s->com[1], s->com[2], s->fixed, s->locked,
                                s->fused, s->follows, s->absent, tfa_word(TFA_WORDS_BASE, s->base),
                                s->gravity[0], s->gravity[1], s->gravity[2], s->singular_body,
                                s->mimics));
}

static PyObject *lenient(const char *text)
{
    return PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
}

PyObject *record_message(const tfa_report *report, size_t index)
{
    const tfa_message *m = &report->messages[index];
    return record(MESSAGE,
                  Py_BuildValue("(sNIsNIN)", tfa_word(TFA_WORDS_SEVERITY, m->severity),
                                report->file ? lenient(report->file) : Py_NewRef(Py_None), m->line,
                                m->code, lenient(m->text), m->count, lenient(m->entity)));
}

PyObject *record_exchange(const tfa_exchange *e)
{
    return record(EXCHANGE,
                  Py_BuildValue("(KKKKKKs)", (unsigned long long)e->id,
                                (unsigned long long)e->t_sent, (unsigned long long)e->t_received,
                                (unsigned long long)e->t_start, (unsigned long long)e->t_done,
                                (unsigned long long)e->t_reply, tfa_status_name(e->daemon)));
}

PyObject *record_method(const tfa_method_info *m)
{
    PyObject *ops = PyList_New(0), *refuses = PyList_New(0);
    for (int op = 1; op <= TFA_OP_LAST; op++)
        if (ops && m->ops & TFA_OP_BIT(op)) {
            PyObject *name = PyUnicode_FromString(op_name((tfa_op)op));
            if (name)
                PyList_Append(ops, name);
            Py_XDECREF(name);
        }
    for (unsigned bit = 1; refuses && bit <= m->refuses; bit <<= 1)
        if (m->refuses & bit) {
            PyObject *text = PyUnicode_FromString(tfa_refusal_text(bit));
            if (text)
                PyList_Append(refuses, text);
            Py_XDECREF(text);
        }
    return record(METHOD, Py_BuildValue("(sNsNs)", m->name, ops, m->cost, refuses, m->summary));
}

PyObject *record_specialised(const tfa_specialised_info *i)
{
    return record(SPECIALISED,
                  Py_BuildValue("(ssssIIIddy#)", i->path, i->isa, i->compiler, i->algorithms,
                                i->bodies, i->lanes, i->lanes_f32, i->error, i->error_f32,
                                (const char *)i->digest, (Py_ssize_t)32));
}

PyObject *record_build(const tfa_specialise_result *r)
{
    return record(BUILD, Py_BuildValue("(dns)", r->compile_s, (Py_ssize_t)r->bytes, r->compiler));
}

PyObject *record_advice(PyObject *joints, uint32_t freedoms, PyObject *q, PyObject *single_error,
                        double error, uint32_t state)
{
    return record(ADVICE,
                  Py_BuildValue("(OIOOdI)", joints, freedoms, q, single_error, error, state));
}

PyObject *record_posture(PyObject *tuple)
{
    return record(POSTURE, tuple);
}

PyObject *record_configuration(PyObject *q, PyObject *base_pose)
{
    return record(CONFIGURATION, Py_BuildValue("(NN)", q, base_pose));
}

PyObject *record_velocity(PyObject *v, PyObject *base_twist)
{
    return record(VELOCITY, Py_BuildValue("(NN)", v, base_twist));
}

int is_record_pair(PyObject *value)
{
    return Py_IS_TYPE(value, types[CONFIGURATION]) || Py_IS_TYPE(value, types[VELOCITY]);
}

PyObject *record_limits(const tfa_joint_limits *l)
{
    return record(LIMITS, Py_BuildValue("(dddd)", l->limited ? l->lower : -INFINITY,
                                        l->limited ? l->upper : INFINITY, l->velocity, l->effort));
}

int set_entry(PyObject *dict, const char *key, PyObject *value)
{
    const int bad = !value || PyDict_SetItemString(dict, key, value) < 0;
    Py_XDECREF(value);
    return bad ? -1 : 0;
}
