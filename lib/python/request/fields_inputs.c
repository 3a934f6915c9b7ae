/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tables of ops and of request fields.
 */
#include "errors.h"
#include "field_rows.h"
#include "read.h"
#include "robot_names.h"

#include <stddef.h>
#include <stdio.h>
#include <totalforce/text.h>

const op_row op_rows[OP_COUNT] = {
    {TFA_OP_FORWARD_DYNAMICS, "q, v=None, tau=None",
     "Joint accelerations of given joint forces.\n\n"
     "    M(q) qdd + h(q, v) = tau + sum J^T wrench\n\n"
     "With tips also lambda_inv = J M^-1 J^T from the same factors."},
    {TFA_OP_INVERSE_DYNAMICS, "q, v=None, qdd=None",
     "Joint forces of given joint accelerations.\n\n"
     "    tau = M(q) qdd + h(q, v) - sum J^T wrench"},
    {TFA_OP_OPERATIONAL_INERTIA, "q, tips",
     "Operational-space inverse inertia of the tips.\n\n"
     "    lambda_inv = J M^-1 J^T"},
    {TFA_OP_MASS_MATRIX, "q", "Mass matrix M(q) of all freedoms, those of a floating base first."},
    {TFA_OP_KINEMATICS, "q, v=None",
     "Answers of `want` alone: poses, twists, Jacobians, centre of mass, momenta, energy."},
    {TFA_OP_BIAS, "q, v=None",
     "Terms of the equation of motion, the base first.\n\n"
     "    tau = M qdd + gravity + velocity + damping + friction + external"},
    {TFA_OP_TASK_TORQUES, "q, v=None, acceleration=None",
     "Joint forces that give the tips the accelerations asked for; posture torques act where\n"
     "the tips do not feel them.\n\n"
     "    tau = posture + J^T Lambda (acceleration - bias_acceleration - J qdd_posture)"},
    {TFA_OP_DERIVATIVES, "q, v=None, tau=None",
     "Derivatives of the accelerations of forward dynamics: row i is the gradient of\n"
     "acceleration i, the base first."},
    {TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, "q, v=None, qdd=None",
     "Derivatives of the forces of inverse dynamics: row i is the gradient of force i, the base\n"
     "first. dtau/dqdd is the mass matrix."},
    {TFA_OP_CONSTRAINED_DYNAMICS, "q, v=None, tau=None",
     "Joint accelerations under the active constraints J_c, and the wrenches F that hold them.\n\n"
     "    M(q) qdd + h(q, v) = tau + sum J^T wrench + J_c^T F\n"
     "    J_c qdd + J_c-dot v = constraint_acceleration - k0 position - k1 velocity"},
    {TFA_OP_IMPACT, "q, v=None",
     "Velocities after a plastic impact: of the active constraints they are 0.\n\n"
     "    M(q) (v_after - v) = J_c^T F,  J_c v_after = 0"},
    {TFA_OP_CONSTRAINED_INVERSE_DYNAMICS, "q, v=None, qdd=None",
     "Joint forces of given joint accelerations under the active constraints: those of the\n"
     "smallest weighted square in the joints with a motor.\n\n"
     "    tau + J_c^T F = M(q) qdd + h(q, v) - sum J^T wrench,  min tau^T W tau"},
    {TFA_OP_REGRESSOR, "q, v=None, qdd=None",
     "Y of the links in tips: joint forces are linear in the inertial parameters p of each\n"
     "(Model.parameters), and in armature, damping and friction of each joint.\n\n"
     "    inverse dynamics = sum of Y p over all bodies + armature + damping + friction + "
     "external"},
};

/* Ops and flags of a key */
enum {
#define KEY(key, ops, flags) OPS_##key = ops, FLAGS_##key = flags,
    TFA_KEY_LIST(KEY)
#undef KEY
};

#define USE(key) OPS_##key, FLAGS_##key
#define STATES(member, width) PHASE_ARRAYS, width, offsetof(tfa_request, member)
#define CHOICE PHASE_CHOICES, EXTENT_NONE, 0

const input_row inputs[] = {
    {"q", read_joints, STATES(q, EXTENT_Q), USE(q), "(n_q,) or (count, n_q)",
     "coordinates, rad or m, in declared order; a floating joint has x y z and a quaternion\n"
     "x y z w. A dict {joint: value} leaves other joints at 0",
     0},
    {"v", read_joints, STATES(v, EXTENT_V), USE(v), "(n_v,) or (count, n_v)",
     "velocities, rad/s or m/s; None: at rest", 0},
    {"tau", read_joints, STATES(tau, EXTENT_V), USE(tau), "(n_v,) or (count, n_v)",
     "joint forces, N m or N; None: 0", 0},
    {"qdd", read_joints, STATES(qdd, EXTENT_V), USE(qdd), "(n_v,) or (count, n_v)",
     "accelerations, rad/s^2 or m/s^2: time derivatives of v; None: 0", 0},
    {"acceleration", read_acceleration, STATES(task_acceleration, EXTENT_ROWS), USE(acceleration),
     "{tip: (6,) or (3,)}, or (rows,) or (count, rows)",
     "desired accelerations of the tips in `frame`, m/s^2 and rad/s^2, as J qdd +\n"
     "bias_acceleration. A dict names the tips, and 3 numbers choose rows='point'",
     0},
    {"posture_torques", read_joints, STATES(tau, EXTENT_V), USE(posture_torques),
     "(n_v,) or (count, n_v)", "joint forces in the null space of the tips, N m or N; None: 0", 0},
    {"base_pose", read_states, STATES(base_pose, 7), USE(base_pose), "(7,) or (count, 7)",
     "pose of the root link in the world: x y z (m), quaternion x y z w; required with a\n"
     "floating base",
     0},
    {"base_twist", read_states, STATES(base_twist, 6), USE(base_twist), "(6,) or (count, 6)",
     "velocity of the root link's origin and angular velocity, in the root link's axes, m/s\n"
     "and rad/s; None: 0",
     0},
    {"base_wrench", read_states, STATES(base_wrench, 6), USE(base_wrench), "(6,) or (count, 6)",
     "wrench on the root link in its frame, N and N m; None: 0", 0},
    {"base_acceleration", read_states, STATES(base_acceleration, 6), USE(base_acceleration),
     "(6,) or (count, 6)",
     "time derivative of the components of base_twist, m/s^2 and rad/s^2; None: 0", 0},
    {"modes", read_states, STATES(modes, EXTENT_MODES), USE(modes),
     "(n_modes,) or (count, n_modes)", "modal coordinates of the flexible links; None: 0", 0},
    {"mode_velocities", read_states, STATES(mode_velocities, EXTENT_MODES), USE(mode_velocities),
     "(n_modes,) or (count, n_modes)", "their rates, 1/s; None: 0", 0},
    {"gravity", read_gravity, PHASE_ARRAYS, 3, offsetof(tfa_request, gravity), USE(gravity), "(3,)",
     "m/s^2, world axes; None: the model's", 0},
    {"wrench", read_wrench, PHASE_ARRAYS, EXTENT_NONE, offsetof(tfa_request, wrenches), USE(wrench),
     "{link: (6,) or (count, 6)}, or a list of pairs",
     "force (N), then moment (N m), on up to 8 links, exerted on the robot, in `frame`", 0},
    {"tips", read_tips, CHOICE, USE(tips), "list of links",
     "1 to 32 links by name or frame index, or one name", 0},
    {"rows", read_rows, CHOICE, USE(rows), "'pose' or 'point'",
     "6 rows for each tip (linear, angular) or 3 (linear)", 0},
    {"frame", read_frame, CHOICE, USE(frame), "'local_world_aligned', 'local' or 'world'",
     "frame of wrenches and of everything at a tip", 0},
    {"constraints", read_constraints, CHOICE, USE(constraints), "list of constraints",
     "active ones by name or index; None: all of the model", 0},
    {"constraint_acceleration", read_constraint_acceleration,
     STATES(constraint_acceleration, EXTENT_CONSTRAINTS), USE(constraint_acceleration),
     "{constraint: (6,) or (count, 6)}, or (6 c,) or (count, 6 c)",
     "wanted accelerations of the active constraints, m/s^2 and rad/s^2; of those that a dict\n"
     "leaves out, and of None: 0",
     0},
    {"stabilisation", read_stabilisation, CHOICE, USE(stabilisation), "(2,)",
     "gains k0 (1/s^2, of impact 1/s) and k1 (1/s) of the errors of position and velocity;\n"
     "None: 0",
     0},
    {"torque_weights", read_torque_weights, PHASE_ARRAYS, EXTENT_V,
     offsetof(tfa_request, torque_weights), USE(torque_weights), "(n_v,) or {joint: weight}",
     "weights W of the squared joint forces, above 0; of those that a dict leaves out, and of\n"
     "None: 1",
     0},
    {"rank_loss", read_rank_loss, CHOICE, USE(rank_loss),
     "'default', 'truncate', 'damp' or 'refuse'",
     "eigenvalues of lambda_inv up to the threshold; 'default': 'damp' for task_torques and\n"
     "constraints, otherwise 'truncate'",
     0},
    {"rank_threshold", read_rank_threshold, CHOICE, USE(rank_threshold), "float",
     "relative to the sum of the eigenvalues; None: 1e-6 where damped, else rounding", 0},
    {"characteristic_length", read_characteristic_length, CHOICE, USE(characteristic_length),
     "float", "what a radian of a tip counts, m; None: the model's", 0},
    {"method", read_method, CHOICE, USE(method), "str", "one of totalforce.methods(); None: 'auto'",
     0},
    {"refine", read_refine, CHOICE, USE(refine), "int",
     "refinement steps, 0 to 3; None: the method's", 0},
    {"estimate", read_estimate, CHOICE, USE(estimate), "'default', 'always' or 'never'",
     "error estimate of the answer", 0},
    {"payload", read_payload, PHASE_LAST, EXTENT_NONE, offsetof(tfa_request, payloads),
     USE(payload), "dict, or a list of dicts",
     "{'link': name, 'mass': kg, 'com': (3,) m, 'inertia': (6,) kg m^2}, up to 4 loads besides\n"
     "the model's; inertia ixx ixy ixz iyy iyz izz about the centre of mass, link axes",
     0},
    {"locked", read_locked, PHASE_LAST, EXTENT_NONE, offsetof(tfa_request, locked), USE(locked),
     "list of joints", "joints that do not accelerate, by name or index", 0},
    {"want", read_want, CHOICE, TFA_OPS_ALL, 0, "list of words",
     "further answers: 'pose', 'twist', 'jacobian', 'bias_acceleration' of the tips; 'poses',\n"
     "'com', 'momentum', 'energy', 'generalised_momentum'; with lambda_inv 'lambda', 'mu', 'p',\n"
     "'spectrum'; with\n"
     "constraints 'delassus'",
     0},
    {"only", read_only, PHASE_LAST, EXTENT_NONE, 0, TFA_OPS_ALL, 0, "list of names",
     "answers that are computed and allocated; None: all", 0},
    {"out", read_out, PHASE_LAST, EXTENT_NONE, 0, TFA_OPS_ALL, 0, "Reply, {name: array} or array",
     "memory of the answers: a reply of a request of the same shapes, arrays by name, or an\n"
     "array for the first answer; gravity and base_gravity are one array, (n,), base first",
     0},
    {"timeout", read_timeout, PHASE_LAST, EXTENT_NONE, 0, TFA_OPS_ALL, 0, "float",
     "s; None: until the daemon ends, or shows no progress for 3 s", 1},
};
const size_t input_count = sizeof inputs / sizeof inputs[0];

static PyObject *interned[INPUTS_MAX];

_Static_assert(sizeof inputs / sizeof inputs[0] <= INPUTS_MAX, "INPUTS_MAX is too small");

int fields_init(void)
{
    for (size_t k = 0; k < input_count; k++)
        if (!interned[k] && !(interned[k] = PyUnicode_InternFromString(inputs[k].name)))
            return -1;
    outputs_init();
    return 0;
}

int input_find(PyObject *name)
{
    for (size_t k = 0; k < input_count; k++)
        if (interned[k] == name)
            return (int)k;
    for (size_t k = 0; k < input_count; k++)
        if (PyUnicode_Check(name) && PyUnicode_Compare(interned[k], name) == 0)
            return (int)k;
    return -1;
}

int input_is_used(const input_row *input, tfa_op op, uint32_t flags)
{
    return (input->ops & TFA_OP_BIT(op)) || (input->flags & flags);
}

const char *op_name(tfa_op op)
{
    return tfa_word(TFA_WORDS_OP, (uint32_t)op);
}

static const char *op_at(const void *unused, size_t index)
{
    (void)unused;
    return op_name(op_rows[index].op);
}

int read_op(PyObject *value, tfa_op *op)
{
    const char *name = PyUnicode_Check(value) ? PyUnicode_AsUTF8AndSize(value, NULL) : NULL;
    if (!name)
        return PyErr_Occurred()
                   ? -1
                   : raise_type("op", "op: %.100s, must be the name of an op", type_name(value));
    const int32_t found = tfa_word_find(TFA_WORDS_OP, name);
    if (found >= 0) {
        *op = (tfa_op)found;
        return 0;
    }
    char nearest[160];
    tfa_suggest(name, NULL, OP_COUNT, op_at, nearest, sizeof nearest);
    return raise_status(TFA_E_ARGUMENT, "op", "op: no '%.200s'; nearest: %s", name, nearest);
}
