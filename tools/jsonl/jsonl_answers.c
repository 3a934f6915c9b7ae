/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of the answers: which request has which, of which size.
 */
#include "jsonl_answers.h"

#include "jsonl_values.h"

#include <stddef.h>
#include <stdlib.h>

/* Sizes known with the robot and the request only */
enum {
    JOINTS = -1,   /* v_count */
    BASE = -2,     /* 6 with a floating base, else 0 */
    FREEDOMS = -3, /* base and joints */
    TIPS = -4,
    ROWS = -5, /* of all tips: 6 or 3 each */
    FRAMES = -6,
};

enum {
    FD = TFA_OPS_FD,
    ID = TFA_OPS_ID,
    OI = TFA_OPS_OSIM,
    MM = TFA_OPS_M,
    BIAS = TFA_OP_BIT(TFA_OP_BIAS),
    TASK = TFA_OPS_TASK,
    DER = TFA_OPS_DERIVATIVES,
};

#define MEMBER(name) offsetof(tfa_reply, name)

const jsonl_answer jsonl_answers[] = {
    {"qdd", MEMBER(qdd), FD, 0, 1, JOINTS, JSONL_VECTOR},
    {"base_acceleration", MEMBER(base_acceleration), FD, 0, 1, BASE, JSONL_VECTOR},
    {"tau", MEMBER(tau), ID | TASK, 0, 1, JOINTS, JSONL_VECTOR},
    {"base_wrench", MEMBER(base_wrench), ID | TASK, 0, 1, BASE, JSONL_VECTOR},
    {"gravity", MEMBER(gravity_force), BIAS, 0, 1, FREEDOMS, JSONL_FREEDOMS},
    {"velocity", MEMBER(velocity_force), BIAS, 0, 1, FREEDOMS, JSONL_FREEDOMS},
    {"damping", MEMBER(damping_force), BIAS, 0, 1, FREEDOMS, JSONL_FREEDOMS},
    {"external", MEMBER(external_force), BIAS, 0, 1, FREEDOMS, JSONL_FREEDOMS},
    {"armature", MEMBER(armature_force), BIAS, 0, 1, FREEDOMS, JSONL_FREEDOMS},
    {"lambda_inv", MEMBER(lambda_inv), FD | OI | TASK, 0, ROWS, ROWS, JSONL_MATRIX},
    {"lambda", MEMBER(lambda), 0, TFA_WANT_LAMBDA, ROWS, ROWS, JSONL_MATRIX},
    {"mu", MEMBER(mu), 0, TFA_WANT_MU, 1, ROWS, JSONL_VECTOR},
    {"p", MEMBER(p), 0, TFA_WANT_P, 1, ROWS, JSONL_VECTOR},
    {"pose", MEMBER(poses), 0, TFA_WANT_POSES, TIPS, 7, JSONL_MATRIX},
    {"twist", MEMBER(twists), 0, TFA_WANT_TWISTS, TIPS, 6, JSONL_MATRIX},
    {"jacobian", MEMBER(jacobian), 0, TFA_WANT_JACOBIAN, ROWS, FREEDOMS, JSONL_MATRIX},
    {"bias_acceleration", MEMBER(bias_acceleration), 0, TFA_WANT_BIAS_ACCELERATION, 1, ROWS,
     JSONL_VECTOR},
    {"poses", MEMBER(frame_poses), 0, TFA_WANT_FRAME_POSES, FRAMES, 7, JSONL_BY_LINK},
    {"com", MEMBER(com), 0, TFA_WANT_COM, 1, 3, JSONL_VECTOR},
    {"com_velocity", MEMBER(com_velocity), 0, TFA_WANT_COM, 1, 3, JSONL_VECTOR},
    {"com_jacobian", MEMBER(com_jacobian), 0, TFA_WANT_COM, 3, FREEDOMS, JSONL_MATRIX},
    {"mass", MEMBER(mass), 0, TFA_WANT_COM, 1, 1, JSONL_NUMBER},
    {"momentum", MEMBER(momentum), 0, TFA_WANT_MOMENTUM, 1, 6, JSONL_VECTOR},
    {"energy", MEMBER(energy), 0, TFA_WANT_ENERGY, 1, 2, JSONL_ENERGY},
    {"M", MEMBER(mass_matrix), MM, 0, FREEDOMS, FREEDOMS, JSONL_MATRIX},
    {"dqdd_dq", MEMBER(dqdd_dq), DER, 0, FREEDOMS, FREEDOMS, JSONL_MATRIX},
    {"dqdd_dv", MEMBER(dqdd_dv), DER, 0, FREEDOMS, FREEDOMS, JSONL_MATRIX},
    {"dqdd_dtau", MEMBER(dqdd_dtau), DER, 0, FREEDOMS, FREEDOMS, JSONL_MATRIX},
};
const size_t jsonl_answer_count = sizeof jsonl_answers / sizeof jsonl_answers[0];

static size_t size_of(int size, const robot_names *names, const tfa_request *request)
{
    switch (size) {
    case JOINTS:
        return names->v_count;
    case BASE:
        return names->base_freedoms;
    case FREEDOMS:
        return (size_t)names->base_freedoms + names->v_count;
    case TIPS:
        return request->tip_count;
    case ROWS:
        return (request->rows == TFA_ROWS_POINT ? 3 : 6) * (size_t)request->tip_count;
    case FRAMES:
        return names->frame_count;
    default:
        return (size_t)size;
    }
}

void jsonl_answer_size(const jsonl_answer *answer, const robot_names *names,
                       const tfa_request *request, size_t *rows, size_t *columns)
{
    *rows = size_of(answer->rows, names, request);
    *columns = size_of(answer->columns, names, request);
}

int jsonl_is_answered(const jsonl_answer *answer, const robot_names *names,
                      const tfa_request *request)
{
    if (answer->flags ? !(request->flags & answer->flags)
                      : !(TFA_OP_BIT(request->op) & answer->ops))
        return 0;
    if (answer->member == MEMBER(armature_force))
        return request->qdd || request->base_acceleration;
    /* an array without joints is printed, one of a fixed base or of no tips is not */
    return answer->columns != BASE ? answer->columns != ROWS || request->tip_count
                                   : names->base_freedoms != 0;
}

double **jsonl_answer_buffer(const jsonl_answer *answer, tfa_reply *reply)
{
    return (double **)(void *)((char *)reply + answer->member);
}

const double *jsonl_answer_numbers(const jsonl_answer *answer, const tfa_reply *reply)
{
    return *(double *const *)(const void *)((const char *)reply + answer->member);
}

/* Memory of one answer, at least of this size */
static int reserve(jsonl_reader *r, size_t index, size_t rows, size_t columns)
{
    jsonl_array *array = &r->buffers->answers[index];
    if (array->numbers && rows * columns <= array->size)
        return TFA_OK;
    free(array->numbers);
    array->size = rows * columns;
    array->numbers = calloc(rows ? rows : 1, (columns ? columns : 1) * sizeof(double));
    return array->numbers
               ? TFA_OK
               : jsonl_fail(r->error, TFA_E_MEMORY, "%s: no memory for %zu x %zu numbers",
                            jsonl_answers[index].key, rows, columns);
}

int jsonl_point_reply(jsonl_reader *r, tfa_reply *reply)
{
    jsonl_buffers *b = r->buffers;
    *reply = (tfa_reply){.answers = &b->answer};
    for (size_t i = 0; i < jsonl_answer_count; i++) {
        size_t rows, columns;
        if (!jsonl_is_answered(&jsonl_answers[i], r->names, r->request))
            continue;
        jsonl_answer_size(&jsonl_answers[i], r->names, r->request, &rows, &columns);
        int status = reserve(r, i, rows, columns);
        if (status != TFA_OK)
            return status;
        *jsonl_answer_buffer(&jsonl_answers[i], reply) = b->answers[i].numbers;
    }
    if (r->request->flags & TFA_WANT_SPECTRUM)
        reply->spectrum = &b->spectrum;
    if (r->request->op == TFA_OP_TASK_TORQUES ||
        r->request->flags & (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P)) {
        reply->rank = &b->rank;
        reply->lost = b->lost;
    }
    return TFA_OK;
}
