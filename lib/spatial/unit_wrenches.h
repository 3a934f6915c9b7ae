/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The six unit wrenches of a tip.
 */
#ifndef TFA_SPATIAL_UNIT_WRENCHES_H
#define TFA_SPATIAL_UNIT_WRENCHES_H

#include "spatial/spatial.h"

/* Three unit forces, then three unit moments, at p along the axes that are the columns of R */
static inline void unit_wrenches(mat3 R, vec3 p, svec P[6])
{
    const vec3 axis[3] = {{R.xx, R.yx, R.zx}, {R.xy, R.yy, R.zy}, {R.xz, R.yz, R.zz}};
    for (int k = 0; k < 3; k++) {
        P[k] = (svec){v3_cross(p, axis[k]), axis[k]};
        P[3 + k] = (svec){axis[k], v3_zero()};
    }
}

#endif
