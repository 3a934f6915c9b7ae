#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
#   sh docs/charts/ellipsoid.sh BIN PICTURE.svg WORK    the arm with the ellipsoid of Lambda^-1 at its tool
#
# View: azimuth -60, elevation 20 degrees; 0.18 m for 1/kg; three postures. WORK: a file for the lines.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
"$1/demo_ellipsoid" "$here/../../config/robots/arm7.urdf" tool0 -60 20 0.18 0,-0.2,0,-2.2,0,2.0,0 \
    0,0.5,0,-1.4,0,1.2,0 0,1.0,0,-0.25,0,0.2,0 >"$3"
gnuplot -e "data='$3'; output='$2'" \
    -e "view='orthographic view: azimuth -60, elevation 20 degrees; 0.18 m for 1/kg'" "$here/ellipsoid.gp"
