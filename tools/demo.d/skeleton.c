/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward kinematics of a description, for pictures only.
 */
#include "skeleton.h"

#include <math.h>
#include <stdlib.h>

struct frame {
    double R[9], p[3];
    int known;
};

struct skeleton {
    tfa_description *robot;
    struct frame *frame; /* of each link */
};

struct skeleton *skeleton_load(const char *urdf)
{
    struct skeleton *s = calloc(1, sizeof *s);
    tfa_report report = {0};
    if (!s || tfa_urdf_load(urdf, &s->robot, &report) != TFA_OK) {
        fprintf(stderr, "demo: %s cannot be loaded\n", urdf);
        tfa_report_free(&report);
        free(s);
        return NULL;
    }
    tfa_report_free(&report);
    s->frame = calloc(s->robot->link_count, sizeof *s->frame);
    return s;
}

void skeleton_free(struct skeleton *s)
{
    if (!s)
        return;
    tfa_description_free(s->robot);
    free(s->frame);
    free(s);
}

/* R <- R * rotation of the quaternion (x y z w) */
static void rotate(double R[9], const double quat[4])
{
    double x = quat[0], y = quat[1], z = quat[2], w = quat[3];
    const double Q[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    double out[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = R[3 * i] * Q[j] + R[3 * i + 1] * Q[3 + j] + R[3 * i + 2] * Q[6 + j];
    for (int k = 0; k < 9; k++)
        R[k] = out[k];
}

/* p += R v */
static void move(struct frame *f, const double v[3])
{
    for (int i = 0; i < 3; i++)
        f->p[i] += f->R[3 * i] * v[0] + f->R[3 * i + 1] * v[1] + f->R[3 * i + 2] * v[2];
}

static void compute_child_frame(const struct skeleton *s, const tfa_joint *j,
                                const tfa_model *model, const double *q)
{
    struct frame *f = &s->frame[j->child];
    *f = s->frame[j->parent];
    move(f, j->xyz);
    rotate(f->R, j->quat);
    int32_t index = tfa_model_find_joint(model, j->name);
    if (index < 0)
        return;
    double x = q[tfa_model_joint(model, (uint32_t)index).q_index];
    if (j->type == TFA_JOINT_REVOLUTE || j->type == TFA_JOINT_CONTINUOUS) {
        double h = sin(x / 2);
        const double rotation[4] = {h * j->axis[0], h * j->axis[1], h * j->axis[2], cos(x / 2)};
        rotate(f->R, rotation);
    } else if (j->type == TFA_JOINT_PRISMATIC) {
        const double slide[3] = {x * j->axis[0], x * j->axis[1], x * j->axis[2]};
        move(f, slide);
    }
}

/* Joints may be declared in any order: pass over them until all links have their frame. */
static void compute_frames(const struct skeleton *s, const tfa_model *model, const double *q)
{
    const tfa_description *r = s->robot;
    for (size_t k = 0; k < r->link_count; k++)
        s->frame[k] = (struct frame){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}, 1};
    for (size_t j = 0; j < r->joint_count; j++)
        s->frame[r->joints[j].child].known = 0;
    for (size_t left = 1, pass = 0; left && pass <= r->joint_count; pass++) {
        left = 0;
        for (size_t j = 0; j < r->joint_count; j++) {
            const tfa_joint *joint = &r->joints[j];
            if (s->frame[joint->child].known)
                continue;
            if (s->frame[joint->parent].known)
                compute_child_frame(s, joint, model, q);
            else
                left = 1;
        }
    }
}

void skeleton_draw(const struct skeleton *s, const tfa_model *model, const double *q, FILE *out)
{
    compute_frames(s, model, q);
    for (size_t j = 0; j < s->robot->joint_count; j++) {
        const double *a = s->frame[s->robot->joints[j].parent].p;
        const double *b = s->frame[s->robot->joints[j].child].p;
        fprintf(out, "%.5f %.5f %.5f\n%.5f %.5f %.5f\n\n", a[0], a[1], a[2], b[0], b[1], b[2]);
    }
    fputs("\n", out);
}
