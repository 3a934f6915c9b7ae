/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What else the oracle knows of the state set last: energy, mass, poses, velocities.
 */
#include <stdlib.h>

#include "oracle_motion.h"

void oracle_energy(oracle *o, double *kinetic, double *potential)
{
    quad T = 0;
    for (uint32_t i = 0; i < o->n; i++)
        for (uint32_t k = 0; k < o->n; k++)
            T += o->v[i] * o->M[(size_t)i * o->n + k] * o->v[k] / 2;
    *kinetic = (double)T;
    *potential = (double)-vec_dot(o->gravity, o->moment);
}

static void vec_store(double *out, vec3 a)
{
    for (int i = 0; i < 3; i++)
        out[i] = (double)a.x[i];
}

void oracle_mass(const oracle *o, double *mass, double com[3])
{
    *mass = (double)o->mass;
    vec_store(com, vec_scale(1 / o->mass, o->moment));
}

double oracle_energy_norm(const oracle *o, const double *a, const double *a_base, const double *b,
                          const double *b_base)
{
    quad sum = 0, *x = calloc((size_t)o->rows + 1, sizeof *x);
    for (uint32_t k = 0; k < o->rows; k++) {
        const double *of = k < o->base ? a_base : a, *minus = k < o->base ? b_base : b;
        uint32_t at = k < o->base ? k : k - o->base;
        x[k] = of[at] - (minus ? (quad)minus[at] : 0);
    }
    for (uint32_t i = 0; i < o->rows; i++)
        for (uint32_t k = 0; k < o->rows; k++)
            sum += x[i] * o->Mt[(size_t)i * o->rows + k] * x[k];
    free(x);
    return (double)quad_sqrt(sum);
}

void oracle_pose(const oracle *o, uint32_t link, double position[3], double rotation[9])
{
    const struct body *b = &o->body[link];
    vec_store(position, b->p);
    for (int i = 0; i < 9; i++)
        rotation[i] = (double)b->R.col[i % 3].x[i / 3];
}
