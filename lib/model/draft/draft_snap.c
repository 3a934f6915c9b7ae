/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Snapping of rotations: a rotation within a given angle of right angles (a file says 1.5708)
 * becomes exactly that, so that constants are 0 and 1.
 */
#include <math.h>

#include "model/draft/draft.h"

/* C: the nearest matrix with one +-1 in each row and column. Returns 0 if there is none. */
static int nearest_right_angle(const ext R[9], ext C[9])
{
    for (int k = 0; k < 9; k++)
        C[k] = roundl((long double)R[k]);
    for (int i = 0; i < 3; i++) {
        const ext in_row = ext_abs(C[3 * i]) + ext_abs(C[3 * i + 1]) + ext_abs(C[3 * i + 2]);
        const ext in_column = ext_abs(C[i]) + ext_abs(C[3 + i]) + ext_abs(C[6 + i]);
        if (in_row != 1 || in_column != 1)
            return 0;
    }
    return 1; /* reflections are too far away: the limit excludes them */
}

long double draft_snap(ext R[9], double limit)
{
    ext C[9], sum = 0;
    if (!(limit > 0) || !nearest_right_angle(R, C))
        return 0;
    for (int k = 0; k < 9; k++)
        sum += (R[k] - C[k]) * (R[k] - C[k]);
    /* |R - C| = 2 sqrt(2) sin(angle / 2) */
    const long double angle = 2 * asinl(fminl(sqrtl((long double)sum / 8), 1));
    if (!(angle <= (long double)limit))
        return 0;
    memcpy(R, C, sizeof C);
    return angle;
}

struct tally {
    size_t count;
    long double largest;
    const char *name;
};

static void count_snap(struct tally *t, const double quat[4], const double low[4], double limit,
                       const char *name)
{
    ext q[4], R[9];
    ext_from_parts(q, quat, low, 4);
    ext_rotation(R, q);
    const long double angle = draft_snap(R, limit);
    t->count += angle > 1e-15L; /* rounding of pi / 2 and pi */
    if (angle > t->largest) {
        t->largest = angle;
        t->name = name;
    }
}

void draft_note_snaps(const struct draft *d, tfa_report *report)
{
    const tfa_description *s = d->description;
    const double limit = d->options->snap;
    struct tally t = {.name = "none"};
    if (!(limit > 0))
        return;
    for (size_t j = 0; j < s->joint_count; j++)
        if (d->joint[j].fate != TFA_FATE_ABSENT)
            count_snap(&t, s->joints[j].quat, s->joints[j].quat_low, limit, s->joints[j].name);
    for (size_t k = 0; k < s->link_count; k++)
        if (d->link[k].present)
            count_snap(&t, s->links[k].quat, s->links[k].quat_low, limit, s->links[k].name);
    tfa_report_add(
        report, TFA_NOTE, 0, "snapped",
        "rotations made right angles: %zu, within %g rad; the largest change is %.3Lg rad, at '%s'",
        t.count, limit, t.largest, t.name);
}
