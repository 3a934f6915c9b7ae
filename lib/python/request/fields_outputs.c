/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of reply fields; the words of `want`; extents.
 */
#include "fields.h"
#include "robot.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define MEMBER(name) offsetof(tfa_reply, name)
#define VECTOR(width) EXTENT_NONE, width, OUTPUT_NUMBERS
#define MATRIX(rows, columns) rows, columns, OUTPUT_NUMBERS

const output_row outputs[OUTPUT_COUNT] = {
    {"qdd", MEMBER(qdd), FD, 0, VECTOR(EXTENT_V),
     "accelerations, rad/s^2 or m/s^2: time derivatives of v"},
    {"base_acceleration", MEMBER(base_acceleration), FD, 0, VECTOR(EXTENT_BASE),
     "time derivatives of the components of base_twist, m/s^2 and rad/s^2"},
    {"tau", MEMBER(tau), ID | TASK, 0, VECTOR(EXTENT_V), "joint forces, N m or N"},
    {"base_wrench", MEMBER(base_wrench), ID | TASK, 0, VECTOR(EXTENT_BASE),
     "wrench on the root link in its frame, N and N m"},
    {"gravity", MEMBER(gravity_force), BIAS, 0, VECTOR(EXTENT_FREEDOMS),
     "forces that hold the robot against gravity, N m or N"},
    {"velocity", MEMBER(velocity_force), BIAS, 0, VECTOR(EXTENT_FREEDOMS),
     "Coriolis and centrifugal forces, N m or N"},
    {"damping", MEMBER(damping_force), BIAS, 0, VECTOR(EXTENT_FREEDOMS),
     "damping times v, N m or N; 0 unless the model has damping"},
    {"external", MEMBER(external_force), BIAS, 0, VECTOR(EXTENT_FREEDOMS),
     "- sum of J^T wrench, N m or N"},
    {"armature", MEMBER(armature_force), BIAS, 0, VECTOR(EXTENT_FREEDOMS),
     "armature times qdd, part of M qdd; with qdd or base_acceleration"},
    {"lambda_inv", MEMBER(lambda_inv), FD | OI | TASK, 0, MATRIX(EXTENT_ROWS, EXTENT_ROWS),
     "J M^-1 J^T of the tips in `frame`"},
    {"lambda", MEMBER(lambda), 0, TFA_WANT_LAMBDA, MATRIX(EXTENT_ROWS, EXTENT_ROWS),
     "inverse of lambda_inv, by rank_loss"},
    {"mu", MEMBER(mu), 0, TFA_WANT_MU, VECTOR(EXTENT_ROWS),
     "operational-space velocity, damping and wrench forces, N and N m"},
    {"p", MEMBER(p), 0, TFA_WANT_P, VECTOR(EXTENT_ROWS),
     "operational-space gravity forces, N and N m"},
    {"pose", MEMBER(poses), 0, TFA_WANT_POSES, MATRIX(EXTENT_TIPS, 7),
     "of the tips in the world: x y z (m), quaternion x y z w"},
    {"twist", MEMBER(twists), 0, TFA_WANT_TWISTS, MATRIX(EXTENT_TIPS, 6),
     "of the tips in `frame`: linear, angular, m/s and rad/s"},
    {"jacobian", MEMBER(jacobian), 0, TFA_WANT_JACOBIAN, MATRIX(EXTENT_ROWS, EXTENT_FREEDOMS),
     "of the tips in `frame`: twist = J v"},
    {"bias_acceleration", MEMBER(bias_acceleration), 0, TFA_WANT_BIAS_ACCELERATION,
     VECTOR(EXTENT_ROWS), "J-dot v; acceleration of the tips = J qdd + this"},
    {"poses", MEMBER(frame_poses), 0, TFA_WANT_FRAME_POSES, MATRIX(EXTENT_LINKS, 7),
     "of all links in the world, in the order of `links`"},
    {"com", MEMBER(com), 0, TFA_WANT_COM, VECTOR(3),
     "centre of mass of the bodies that move, m, world"},
    {"com_velocity", MEMBER(com_velocity), 0, TFA_WANT_COM, VECTOR(3), "m/s, world"},
    {"com_jacobian", MEMBER(com_jacobian), 0, TFA_WANT_COM, MATRIX(3, EXTENT_FREEDOMS),
     "com_velocity = com_jacobian v"},
    {"mass", MEMBER(mass), 0, TFA_WANT_COM, MATRIX(EXTENT_NONE, EXTENT_NONE),
     "kg, of the bodies that move"},
    {"momentum", MEMBER(momentum), 0, TFA_WANT_MOMENTUM, VECTOR(6),
     "linear (N s), angular about the centre of mass (N m s), axes of the world"},
    {"energy", MEMBER(energy), 0, TFA_WANT_ENERGY, VECTOR(2), "kinetic, potential, J"},
    {"M", MEMBER(mass_matrix), MASS, 0, MATRIX(EXTENT_FREEDOMS, EXTENT_FREEDOMS),
     "mass matrix, the base first"},
    {"dqdd_dq", MEMBER(dqdd_dq), DER, 0, MATRIX(EXTENT_FREEDOMS, EXTENT_FREEDOMS),
     "by motion along each freedom"},
    {"dqdd_dv", MEMBER(dqdd_dv), DER, 0, MATRIX(EXTENT_FREEDOMS, EXTENT_FREEDOMS),
     "by the velocity of each freedom"},
    {"dqdd_dtau", MEMBER(dqdd_dtau), DER, 0, MATRIX(EXTENT_FREEDOMS, EXTENT_FREEDOMS),
     "by the force of each freedom: M^-1"},
    {"spectrum", MEMBER(spectrum), 0, TFA_WANT_SPECTRUM, EXTENT_NONE, EXTENT_NONE, OUTPUT_SPECTRUM,
     "rank and extreme eigenvalues of lambda_inv, as rank, eig_min, eig_max"},
    {"rank", MEMBER(rank), TASK, WANT_LAMBDA, EXTENT_NONE, EXTENT_NONE, OUTPUT_RANK,
     "rank of lambda_inv as lambda and task torques used it, as rank, lost, threshold, condition,\n"
     "length, error_estimate"},
    {"lost", MEMBER(lost), TASK, WANT_LAMBDA, MATRIX(TFA_LOST_MAX, EXTENT_LOST),
     "directions at or below the threshold, by ascending singular value, the rest 0: singular\n"
     "value (1/sqrt(kg)), acceleration given up along it (m/s^2), direction"},
};

static const struct {
    const char *word;
    uint32_t flag;
} words[] = {
    {"jacobian", TFA_WANT_JACOBIAN},
    {"bias_acceleration", TFA_WANT_BIAS_ACCELERATION},
    {"twist", TFA_WANT_TWISTS},
    {"pose", TFA_WANT_POSES},
    {"poses", TFA_WANT_FRAME_POSES},
    {"com", TFA_WANT_COM},
    {"momentum", TFA_WANT_MOMENTUM},
    {"energy", TFA_WANT_ENERGY},
    {"lambda", TFA_WANT_LAMBDA},
    {"mu", TFA_WANT_MU},
    {"p", TFA_WANT_P},
    {"spectrum", TFA_WANT_SPECTRUM},
};
enum { WORD_COUNT = sizeof words / sizeof words[0] };

uint32_t want_flag(const char *word)
{
    for (size_t k = 0; k < WORD_COUNT; k++)
        if (strcmp(words[k].word, word) == 0)
            return words[k].flag;
    return 0;
}

const char *want_word(size_t k)
{
    return k < WORD_COUNT ? words[k].word : NULL;
}

void want_words(uint32_t flags, char *text, size_t size)
{
    size_t used = 0;
    uint32_t left = 0;
    for (size_t k = 0; k < WORD_COUNT; k++)
        left += (flags & words[k].flag) != 0;
    text[0] = '\0';
    for (size_t k = 0; k < WORD_COUNT && used < size; k++)
        if (flags & words[k].flag) {
            left--;
            used += (size_t)snprintf(text + used, size - used, "%s%s", words[k].word,
                                     left > 1    ? ", "
                                     : left == 1 ? " or "
                                                 : "");
        }
}

enum { FLAG_COUNT = 12 };
_Static_assert(TFA_WANT_ALL == (1u << FLAG_COUNT) - 1, "FLAG_COUNT is wrong");
_Static_assert(OUTPUT_COUNT <= 32, "outputs are bits of a word");

static uint32_t of_op[OP_COUNT + 1], of_flag[FLAG_COUNT];

void outputs_init(void)
{
    for (int k = 0; k < OUTPUT_COUNT; k++) {
        for (int op = 1; op <= OP_COUNT; op++)
            of_op[op] |= outputs[k].ops & TFA_OP_BIT(op) ? 1u << k : 0;
        for (int flag = 0; flag < FLAG_COUNT; flag++)
            of_flag[flag] |= outputs[k].flags >> flag & 1 ? 1u << k : 0;
    }
}

uint32_t output_candidates(tfa_op op, uint32_t flags)
{
    uint32_t bits = of_op[op];
    for (uint32_t left = flags; left; left &= left - 1)
        bits |= of_flag[__builtin_ctz(left)];
    return bits;
}

int output_is_answered(const output_row *output, const robot_names *robot,
                       const tfa_request *request)
{
    if (!(request->flags & output->flags) && !(TFA_OP_BIT(request->op) & output->ops))
        return 0;
    if (output->member == MEMBER(armature_force))
        return request->qdd || request->base_acceleration;
    if (output->columns == EXTENT_BASE)
        return robot->base_freedoms != 0;
    return (output->columns != EXTENT_ROWS && output->columns != EXTENT_LOST) || request->tip_count;
}

int output_find(const char *name)
{
    if (strcmp(name, "lambda_") == 0)
        name = "lambda";
    for (int k = 0; k < OUTPUT_COUNT; k++)
        if (outputs[k].kind == OUTPUT_NUMBERS && strcmp(outputs[k].name, name) == 0)
            return k;
    return -1;
}

uint32_t extent_size(int extent, const robot_names *robot, const tfa_request *request)
{
    switch (extent) {
    case EXTENT_Q:
        return robot->q_count;
    case EXTENT_V:
        return robot->v_count;
    case EXTENT_FREEDOMS:
        return robot->base_freedoms + robot->v_count;
    case EXTENT_TIPS:
        return request->tip_count;
    case EXTENT_ROWS:
        return (request->rows == TFA_ROWS_POINT ? 3u : 6u) * request->tip_count;
    case EXTENT_LOST:
        return 2 + extent_size(EXTENT_ROWS, robot, request);
    case EXTENT_LINKS:
        return robot->frame_count;
    case EXTENT_BASE:
        return 6;
    default:
        return (uint32_t)extent;
    }
}

const char *extent_name(int extent, char *text, size_t size)
{
    static const char *const names[] = {"", "n_q", "n_v", "n", "tips", "rows", "links", "6",
                                        "2 + rows"};
    if (extent <= 0)
        return names[-extent];
    snprintf(text, size, "%d", extent);
    return text;
}
