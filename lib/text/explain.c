/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Turns a refused request into a sentence: the entry, its joint or link, its value, the reason and
 * the remedy.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <totalforce/dynamics.h>
#include <totalforce/text.h>

/* What a sentence is made of, and where it goes */
struct refusal {
    const tfa_names *names;
    const tfa_request *request;
    const tfa_reply *reply;
    tfa_option_syntax syntax;
    tfa_place place;
    char entry[400]; /* "q[3] (elbow) of state 17"; "" if the refusal is about no field */
    char *text;
    size_t size;
};

static size_t say(const struct refusal *r, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static size_t say(const struct refusal *r, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    const int length = vsnprintf(r->text, r->size, format, list);
    va_end(list);
    return length < 0 ? 0 : (size_t)length;
}

static const char *op_of(const struct refusal *r)
{
    return tfa_word(TFA_WORDS_OP, (uint32_t)r->request->op);
}

static const char *method_of(const struct refusal *r)
{
    return tfa_method_name((uint32_t)r->request->method);
}

static const char *summary_of(const struct refusal *r)
{
    return tfa_status_text(r->reply->status);
}

static const char *cause_of(const struct refusal *r)
{
    return tfa_status_cause(r->reply->status);
}

/* ---- the place ---- */

static uint32_t tip_rows(const tfa_request *request)
{
    return (request->rows == TFA_ROWS_POINT ? 3u : 6u) * request->tip_count;
}

/* 1: the field has one entry for all states */
static int is_of_all_states(tfa_field field)
{
    return field == TFA_FIELD_GRAVITY || field == TFA_FIELD_STABILISATION ||
           field == TFA_FIELD_TORQUE_WEIGHTS;
}

/* Numbers of a field, and how many one state has; NULL: the field is no array. */
static const double *numbers_of(const tfa_names *names, const tfa_request *r, tfa_field field,
                                uint32_t *width)
{
    const struct {
        const double *numbers;
        uint32_t width;
    } arrays[] = {
        [TFA_FIELD_Q] = {r->q, names->q_count},
        [TFA_FIELD_V] = {r->v, names->v_count},
        [TFA_FIELD_TAU] = {r->tau, names->v_count},
        [TFA_FIELD_QDD] = {r->qdd, names->v_count},
        [TFA_FIELD_BASE_POSE] = {r->base_pose, 7},
        [TFA_FIELD_BASE_TWIST] = {r->base_twist, 6},
        [TFA_FIELD_BASE_WRENCH] = {r->base_wrench, 6},
        [TFA_FIELD_BASE_ACCELERATION] = {r->base_acceleration, 6},
        [TFA_FIELD_GRAVITY] = {r->gravity, 3},
        [TFA_FIELD_WRENCHES] = {r->wrenches, 6 * r->wrench_count},
        [TFA_FIELD_TASK_ACCELERATION] = {r->task_acceleration, tip_rows(r)},
        [TFA_FIELD_MODES] = {r->modes, names->mode_count},
        [TFA_FIELD_MODE_VELOCITIES] = {r->mode_velocities, names->mode_count},
        [TFA_FIELD_CONSTRAINT_ACCELERATION] = {r->constraint_acceleration,
                                               6 * (uint32_t)__builtin_popcount(r->constraints)},
        [TFA_FIELD_STABILISATION] = {r->stabilisation, 2},
        [TFA_FIELD_TORQUE_WEIGHTS] = {r->torque_weights, names->v_count},
    };
    if ((size_t)field >= sizeof arrays / sizeof *arrays)
        return NULL;
    *width = arrays[field].width;
    return arrays[field].numbers;
}

static const char *link_of(const tfa_names *names, const tfa_request *request,
                           const tfa_reply *reply)
{
    const uint32_t k = reply->index;
    switch (reply->field) {
    case TFA_FIELD_BODY:
        return tfa_names_frame(names, k);
    case TFA_FIELD_MODES:
    case TFA_FIELD_MODE_VELOCITIES:
        return k < names->mode_count ? tfa_names_frame(names, names->mode_frames[k]) : NULL;
    case TFA_FIELD_TIPS:
        return reply->status == TFA_E_LINK && k < request->tip_count
                   ? tfa_names_frame(names, request->tips[k])
                   : NULL;
    case TFA_FIELD_PAYLOADS:
        return k < request->payload_count ? tfa_names_frame(names, request->payload_frames[k])
                                          : NULL;
    case TFA_FIELD_WRENCHES:
        return reply->status == TFA_E_VALUE && k / 6 < request->wrench_count
                   ? tfa_names_frame(names, request->wrench_frames[k / 6])
                   : NULL;
    default:
        return NULL;
    }
}

tfa_place tfa_refused_place(const tfa_names *names, const tfa_request *request,
                            const tfa_reply *reply)
{
    const tfa_field field = reply->field;
    const int of_joints =
        (field >= TFA_FIELD_Q && field <= TFA_FIELD_QDD) || field == TFA_FIELD_TORQUE_WEIGHTS;
    const tfa_joint_span *joint =
        of_joints ? tfa_names_owner(names, field == TFA_FIELD_Q, reply->index) : NULL;
    uint32_t width = 0;
    const double *numbers = numbers_of(names, request, field, &width);
    return (tfa_place){
        .field = field == TFA_FIELD_TAU && request->op == TFA_OP_TASK_TORQUES
                     ? "posture_torques"
                     : tfa_field_name(field),
        .joint = joint ? joint->name : NULL,
        .link = link_of(names, request, reply),
        .constraint = field == TFA_FIELD_CONSTRAINT_ACCELERATION
                          ? tfa_names_active(names, request->constraints, reply->index / 6)
                      : reply->status == TFA_E_OPEN && reply->index < TFA_MAX_CONSTRAINTS
                          ? tfa_names_active(names, 1u << reply->index, 0)
                          : NULL,
        .number = numbers && reply->index < width && reply->state < request->count
                      ? numbers + (size_t)width * reply->state + reply->index
                      : NULL,
    };
}

static void write_entry(struct refusal *r)
{
    const tfa_place *at = &r->place;
    const char *owner = at->joint ? at->joint : at->link ? at->link : at->constraint;
    const int of_state = r->request->count > 1 && !is_of_all_states(r->reply->field);
    char number[16] = "", state[32] = "";
    snprintf(number, sizeof number, "[%u]", at->constraint ? r->reply->index % 6 : r->reply->index);
    if (of_state)
        snprintf(state, sizeof state, " of state %u", r->reply->state);
    if (at->number)
        snprintf(r->entry, sizeof r->entry, "%s%s%s%.200s%s%s", at->field, number,
                 owner ? " (" : "", owner ? owner : "", owner ? ")" : "", state);
    else
        snprintf(r->entry, sizeof r->entry, "%s", at->field);
}

/* ---- reasons; each returns 0 where it has nothing to say ---- */

static size_t say_quaternion(const struct refusal *r)
{
    double norm = 0;
    uint32_t width = 0;
    if (r->reply->status != TFA_E_QUATERNION || !r->place.number ||
        !numbers_of(r->names, r->request, r->reply->field, &width) || width < 4 ||
        r->reply->index > width - 4)
        return 0;
    for (int k = 0; k < 4; k++) /* the index is that of the first */
        norm = hypot(norm, r->place.number[k]);
    return say(r, "%s: quaternion of norm %.6g, must be 1 within 1e-3 (order x y z w)", r->entry,
               norm);
}

/* No answer, and an input that squares to more than single precision holds: the likely cause */
static size_t say_overflow(const struct refusal *r)
{
    tfa_reply at = *r->reply;
    struct refusal entry = *r;
    double most = 1e19;
    if (r->reply->status != TFA_E_NOT_COMPUTED)
        return 0;
    at.status = TFA_E_VALUE; /* is about a number, as of an input that is not finite */
    for (int field = TFA_FIELD_NONE; field <= TFA_FIELD_TORQUE_WEIGHTS; field++) {
        const uint32_t state = is_of_all_states((tfa_field)field) ? 0 : r->reply->state;
        uint32_t width = 0;
        const double *numbers = numbers_of(r->names, r->request, (tfa_field)field, &width);
        for (uint32_t k = 0; numbers && state < r->request->count && k < width; k++) {
            const double size = fabs(numbers[(size_t)width * state + k]);
            if (size <= most)
                continue;
            most = size;
            at.field = (tfa_field)field;
            at.state = state;
            at.index = k;
        }
    }
    if (most == 1e19)
        return 0;
    entry.reply = &at;
    entry.place = tfa_refused_place(r->names, r->request, &at);
    write_entry(&entry);
    return say(r, "%s: %g: %s: so large a number overflows", entry.entry, *entry.place.number,
               summary_of(r));
}

static size_t say_method(const struct refusal *r)
{
    char body[300] = "";
    if (r->reply->field == TFA_FIELD_BODY)
        snprintf(body, sizeof body, "body '%.200s': ", r->place.link);
    switch (r->reply->status) {
    case TFA_E_METHOD:
        return say(r, "method: %s does not answer %s%s", method_of(r), op_of(r),
                   r->reply->field == TFA_FIELD_LOCKED ? " with locked joints; aba does"
                   : r->reply->field == TFA_FIELD_TIPS ? " with tips; aba does"
                                                       : "");
    case TFA_E_SINGULAR:
        return say(r, "%s: %s%s: %s", method_of(r), body, summary_of(r), cause_of(r));
    case TFA_E_NOT_COMPUTED:
        return say(r, "%s: %s%s: %s", op_of(r), body, summary_of(r), cause_of(r));
    default:
        return 0;
    }
}

/* The methods that answer the op of a robot with flexible links: "aba, scan" */
static const char *write_flexible_methods(const struct refusal *r, char *list, size_t size)
{
    size_t used = 0;
    for (uint32_t k = 1; used < size && tfa_method_describe(k); k++) {
        const tfa_method_info *row = tfa_method_describe(k);
        if (row->ops & TFA_OP_BIT(r->request->op) && !(row->refuses & TFA_REFUSES_MODES))
            used += (size_t)snprintf(list + used, size - used, "%s%s", used ? ", " : "",
                                     tfa_method_name(k));
    }
    return list;
}

/* What a robot with flexible links refuses */
static size_t say_modes(const struct refusal *r)
{
    static const char because[] = "the robot has flexible links";
    const tfa_field field = r->reply->field;
    const tfa_method_info *row = tfa_method_describe((uint32_t)r->request->method);
    char methods[200] = "";
    if (!r->names->mode_count)
        return 0;
    if (r->reply->status == TFA_E_METHOD && field == TFA_FIELD_METHOD && row &&
        row->ops & TFA_OP_BIT(r->request->op))
        return say(r, "method: %s: %s; %s answer", method_of(r), because,
                   write_flexible_methods(r, methods, sizeof methods));
    if (r->reply->status != TFA_E_UNSUPPORTED)
        return 0;
    if (field == TFA_FIELD_OP)
        return say(r, "op: %s: %s; forward_dynamics, operational_inertia and kinematics answer",
                   op_of(r), because);
    if (field == TFA_FIELD_LOCKED)
        return say(r, "locked: %s; a scene locks joints of such a robot", because);
    if (field == TFA_FIELD_FLAGS)
        return say(r, "want: %s; joint_forces, lambda, mu and p are not answered", because);
    return 0;
}

static size_t say_payload(const struct refusal *r)
{
    const tfa_request *request = r->request;
    char entry[32] = "payload";
    if (r->reply->field != TFA_FIELD_PAYLOADS || !r->place.link || !request->payloads)
        return 0;
    if (request->payload_count > 1)
        snprintf(entry, sizeof entry, "payload[%u]", r->reply->index);
    if (r->reply->status == TFA_E_UNSUPPORTED)
        return say(r,
                   "%s: link '%.200s' moves with some joints%s of a body and not with others, "
                   "without mass of its own; load a link at its end",
                   entry, r->place.link, r->names->mode_count ? " or modes" : "");
    if (r->reply->status != TFA_E_ARGUMENT)
        return say(r, "%s: %s: %s", entry, summary_of(r), cause_of(r));
    const double mass = request->payloads[TFA_PAYLOAD_NUMBERS * (size_t)r->reply->index];
    if (mass < 0)
        return say(r, "%s.mass: %g: must not be negative", entry, mass);
    return say(r,
               "%s.inertia: no body of %g kg has it; give ixx,ixy,ixz,iyy,iyz,izz about the centre "
               "of mass, with eigenvalues that are not negative",
               entry, mass);
}

static size_t say_locked(const struct refusal *r)
{
    if (r->reply->status != TFA_E_UNSUPPORTED || r->reply->field != TFA_FIELD_LOCKED)
        return 0;
    return say(r, "locked: %s does not go with locked joints", op_of(r));
}

/* How to answer in spite of a lost rank */
static const char *const policies[] = {[TFA_SYNTAX_C] = "rank_loss = truncate or damp",
                                       [TFA_SYNTAX_COMMAND_LINE] = "--rank-loss=truncate or damp",
                                       [TFA_SYNTAX_YAML] = "rank_loss: truncate or damp",
                                       [TFA_SYNTAX_JSON] = "\"rank_loss\":\"truncate\" or \"damp\"",
                                       [TFA_SYNTAX_PYTHON] = "rank_loss='truncate' or 'damp'"};

/* The active constraints: "loop, foot" */
static const char *write_active(const struct refusal *r, char *list, size_t size)
{
    const uint32_t count = (uint32_t)__builtin_popcount(r->request->constraints);
    size_t used = 0;
    list[0] = 0;
    for (uint32_t k = 0; used < size && k < count; k++)
        used += (size_t)snprintf(list + used, size - used, "%s%s", k ? ", " : "",
                                 tfa_names_active(r->names, r->request->constraints, k));
    return list;
}

static size_t say_constraints(const struct refusal *r)
{
    const tfa_reply *reply = r->reply;
    char robot[600], active[300];
    if (reply->field != TFA_FIELD_CONSTRAINTS)
        return 0;
    (void)tfa_names_describe_constraints(r->names, robot, sizeof robot);
    if (reply->status == TFA_E_SIZE && !r->request->constraints)
        return say(r, "constraints: none active; the robot has %s", robot);
    if (reply->status == TFA_E_ARGUMENT)
        return say(r, "constraints: bit %u is set, the robot has %s", reply->index, robot);
    if (reply->status == TFA_E_OPEN)
        return say(r,
                   "constraints: %s stays open: no posture near this start meets it; start nearer, "
                   "or lock fewer joints",
                   r->place.constraint);
    if (reply->status == TFA_E_RANK)
        return say(r, "constraints: rows of %s depend on each other, rank %u here; %s answers",
                   write_active(r, active, sizeof active), reply->index, policies[r->syntax]);
    if (reply->status == TFA_E_UNSUPPORTED)
        return say(r,
                   "constraints: %d active; of them, and of their links, there is memory for %u "
                   "(max_tips)",
                   __builtin_popcount(r->request->constraints), reply->index);
    if (reply->status == TFA_E_SIZE)
        return say(r, "constraints: %d active, more than max_tips",
                   __builtin_popcount(r->request->constraints));
    return 0;
}

/* Gains and weights out of their range */
static size_t say_gain(const struct refusal *r)
{
    const int is_weight = r->reply->field == TFA_FIELD_TORQUE_WEIGHTS;
    if (r->reply->status != TFA_E_ARGUMENT || !r->place.number ||
        (!is_weight && r->reply->field != TFA_FIELD_STABILISATION))
        return 0;
    return say(r, "%s: %g: must %s", r->entry, *r->place.number,
               is_weight ? "be above 0" : "not be negative");
}

static size_t say_tips(const struct refusal *r)
{
    if (r->reply->field != TFA_FIELD_TIPS)
        return 0;
    if (r->reply->status == TFA_E_RANK)
        return say(r, "tips: lambda_inv has rank %u of %u here; %s answers", r->reply->index,
                   tip_rows(r->request), policies[r->syntax]);
    if (r->reply->status == TFA_E_UNSUPPORTED && r->request->tip_count > r->reply->index)
        return say(r, "tips: %u links, there is memory for %u (max_tips)", r->request->tip_count,
                   r->reply->index);
    return 0;
}

/* Limits of the robot's size, and memory that was not reserved */
static size_t say_limit(const struct refusal *r)
{
    const char *limit = tfa_limit_text(r->reply);
    const int of_method = r->reply->field == TFA_FIELD_METHOD;
    const char *what = of_method ? method_of(r) : op_of(r);
    const char *field = r->place.field;
    if (r->reply->status != TFA_E_UNSUPPORTED || (!of_method && r->reply->field != TFA_FIELD_OP))
        return 0;
    if (limit[0])
        return say(r, "%s: %s of a robot of %u freedoms: %s", field, what,
                   r->names->base_freedoms + r->names->v_count, limit);
    if (!of_method && r->request->op != TFA_OP_MASS_MATRIX)
        return 0;
    if (r->syntax == TFA_SYNTAX_PYTHON)
        return say(r,
                   "%s: no memory was reserved for %s; methods=['%s'] of a Workspace or Pool "
                   "reserves it, of a daemon methods: all in its configuration",
                   field, what, of_method ? what : "crba");
    return say(r,
               "%s: no memory was reserved for %s; in the daemon's configuration, methods: all of "
               "the robot reserves it",
               field, what);
}

static size_t say_cost(const struct refusal *r)
{
    const int constrained = (TFA_OP_BIT(r->request->op) & TFA_OPS_CONSTRAINED) != 0;
    const uint32_t count =
        constrained ? (uint32_t)__builtin_popcount(r->request->constraints) : r->request->tip_count;
    char tips[40] = "";
    if (r->reply->field != TFA_FIELD_COST)
        return 0;
    if (count)
        snprintf(tips, sizeof tips, " with %u %s", count, constrained ? "constraints" : "tips");
    return say(
        r,
        "cost: a state of this kind (%s by %s%s) takes about %u us, the daemon admits %u us; "
        "ask for less, or raise max_state_us in its configuration",
        op_of(r), method_of(r), tips, r->reply->index, r->reply->state);
}

static size_t say_status(const struct refusal *r)
{
    if (r->reply->status == TFA_E_VALUE && r->place.number)
        return say(r, "%s: %g: %s", r->entry, *r->place.number, summary_of(r));
    if (r->entry[0])
        return say(r, "%s: %s: %s", r->entry, summary_of(r), cause_of(r));
    return say(r, "%s of robot '%s': %s: %s", op_of(r), r->names->robot ? r->names->robot : "?",
               summary_of(r), cause_of(r));
}

size_t tfa_explain(const tfa_names *names, const tfa_request *request, const tfa_reply *reply,
                   tfa_option_syntax syntax, char *text, size_t size)
{
    static size_t (*const reasons[])(const struct refusal *) = {
        say_quaternion, say_modes, say_overflow,    say_method, say_payload, say_locked,
        say_tips,       say_gain,  say_constraints, say_limit,  say_cost,    say_status};
    struct refusal r = {names, request, reply, syntax, {0}, "", text, size};
    r.place = tfa_refused_place(names, request, reply);
    write_entry(&r);
    size_t length = 0;
    for (size_t k = 0; !length && k < sizeof reasons / sizeof *reasons; k++)
        length = reasons[k](&r);
    return length;
}
