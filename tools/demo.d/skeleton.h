/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A robot as a stick figure: where its joints are, for the demonstration's pictures.
 */
#ifndef TFA_DEMO_SKELETON_H
#define TFA_DEMO_SKELETON_H

#include <stdio.h>
#include <totalforce/model.h>

struct skeleton;

/* NULL after an error message. */
struct skeleton *skeleton_load(const char *urdf);
void skeleton_free(struct skeleton *s);

/* Writes one figure: a line "x y z" for both ends of each joint-to-joint bone, bones separated by
 * empty lines, two empty lines at the end. Only joints with one coordinate move. */
void skeleton_draw(const struct skeleton *s, const tfa_model *model, const double *q, FILE *out);

#endif
