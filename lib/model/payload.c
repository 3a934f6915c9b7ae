/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Payloads: validation, addition to bodies, and the test whether an inertia can be inverted.
 */
#include "model/payload.h"

#include <math.h>
#include <totalforce/dynamics.h>

#include "model/eigen.h"
#include "model/ext.h"
#include "model/model.h"

/* Smallest pivot of a regular inertia, scaled to unit diagonal: below it the inverse has fewer than
 * about two correct digits in double. */
#define REGULAR_PIVOT 1e-13

static int is_positive(const double inertia[6])
{
    long double I[6], value[3];
    for (int k = 0; k < 6; k++)
        I[k] = inertia[k];
    tfa_eigen(I, value, NULL);
    return !tfa_eigen_negative(value);
}

uint8_t tfa_payload_is_physical(const double numbers[10])
{
    return numbers[0] >= 0 && is_positive(numbers + 4);
}

const char *tfa_payload_error(const tfa_payload *payload)
{
    int finite = isfinite(payload->mass) != 0;
    for (int k = 0; k < 3; k++)
        finite &= isfinite(payload->com[k]) != 0;
    for (int k = 0; k < 6; k++)
        finite &= isfinite(payload->inertia[k]) != 0;
    if (!finite)
        return "has a number that is not finite; correct it";
    if (payload->mass < 0)
        return "has a negative mass; correct it";
    if (!is_positive(payload->inertia))
        return "has an inertia with a negative eigenvalue, which no body has; correct it";
    return NULL;
}

void tfa_mass_properties_add(struct tfa_mass_properties *properties, ext m, const ext c[3],
                             const ext R[9], const ext s[6])
{
    ext t[9], Rt[9], I[9];
    const ext Ic[9] = {s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]};
    const ext cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    ext_mul(t, R, Ic);
    ext_transpose(Rt, R);
    ext_mul(I, t, Rt);
    for (int k = 0; k < 6; k++) {
        const int i = ext_row[k], j = ext_col[k];
        properties->I[k] +=
            (I[3 * i + j] + I[3 * j + i]) / 2 + m * ((i == j ? cc : 0) - c[i] * c[j]);
    }
    properties->mass += m;
    for (int i = 0; i < 3; i++)
        properties->h[i] += m * c[i];
}

void tfa_mass_properties_add_payload(struct tfa_mass_properties *properties,
                                     const struct tfa_xform_quad *frame, const tfa_payload *payload)
{
    ext com[3], c[3], inertia[6];
    ext_from_double(com, payload->com, 3);
    ext_from_double(inertia, payload->inertia, 6);
    ext_apply(c, frame->E, com, frame->r);
    tfa_mass_properties_add(properties, payload->mass, c, frame->E, inertia);
}

void tfa_body_add_payload_inertia(struct tfa_body *body, const struct tfa_frame *frame,
                                  const double numbers[10])
{
    const double *R = frame->R, *com = numbers + 1, *s = numbers + 4, m = numbers[0];
    const double Ic[9] = {s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]};
    double c[3], t[9];
    for (int i = 0; i < 3; i++) {
        c[i] = R[3 * i] * com[0] + R[3 * i + 1] * com[1] + R[3 * i + 2] * com[2] + frame->p[i];
        for (int j = 0; j < 3; j++)
            t[3 * i + j] = R[3 * i] * Ic[j] + R[3 * i + 1] * Ic[3 + j] + R[3 * i + 2] * Ic[6 + j];
    }
    const double cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    for (int k = 0; k < 6; k++) { /* I += R Ic R^T + m (c.c 1 - c c^T) */
        const int i = ext_row[k], j = ext_col[k];
        const double turned =
            t[3 * i] * R[3 * j] + t[3 * i + 1] * R[3 * j + 1] + t[3 * i + 2] * R[3 * j + 2];
        body->I[k] += turned + m * ((i == j ? cc : 0) - c[i] * c[j]);
    }
    body->mass += m;
    for (int i = 0; i < 3; i++)
        body->h[i] += m * c[i];
}

void tfa_body_add_payload(struct tfa_body *body, const struct tfa_frame *frame,
                          const double numbers[10])
{
    tfa_body_add_payload_inertia(body, frame, numbers);
    body->regular = tfa_inertia_is_regular(body);
}

uint8_t tfa_inertia_is_regular(const struct tfa_body *body)
{
    const double *I = body->I, *h = body->h, m = body->mass;
    long double a[6][6] = {{I[0], I[1], I[2], 0, -h[2], h[1]}, {I[1], I[3], I[4], h[2], 0, -h[0]},
                           {I[2], I[4], I[5], -h[1], h[0], 0}, {0, h[2], -h[1], m, 0, 0},
                           {-h[2], 0, h[0], 0, m, 0},          {h[1], -h[0], 0, 0, 0, m}};
    long double s[6];
    for (int i = 0; i < 6; i++) {
        if (!(a[i][i] > 0))
            return 0;
        s[i] = 1 / sqrtl(a[i][i]);
    }
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            a[i][j] *= s[i] * s[j];
    for (int k = 0; k < 6; k++) {
        if (!(a[k][k] > REGULAR_PIVOT))
            return 0;
        for (int i = k + 1; i < 6; i++)
            for (int j = k + 1; j < 6; j++)
                a[i][j] -= a[i][k] * a[k][j] / a[k][k];
    }
    return 1;
}

void tfa_payload_size(const struct tfa_model *m, uint32_t count, const double *numbers,
                      double size[2])
{
    size[0] = size[1] = 0;
    for (const double *n = numbers; n < numbers + TFA_PAYLOAD_NUMBERS * (size_t)count;
         n += TFA_PAYLOAD_NUMBERS) {
        const double lever = n[1] * n[1] + n[2] * n[2] + n[3] * n[3] + 1.5 * m->lever;
        size[0] += n[4] + n[7] + n[9] + 2 * n[0] * lever;
        size[1] += 3 * n[0];
    }
}
