/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Words and numbers of joint types.
 */
#include "model/joint_type.h"

tfa_joint_type_info tfa_joint_type_describe(uint32_t type)
{
#define WORD(type, word) [type] = word,
    static const char *const words[] = {TFA_JOINT_TYPE_WORDS(WORD)};
    const uint8_t kind = joint_type_of((tfa_joint_type)type);
    tfa_joint_type_info info = {
        .name = type < sizeof words / sizeof *words ? words[type] : "unknown", .quaternion = -1};
    if (kind == JOINT_TYPES)
        return info;
    const struct joint_type *row = &joint_types[kind];
    info.coordinates = row->coordinates;
    info.freedoms = row->freedoms;
    info.quaternion = row->quaternion;
    while (info.lengths < info.freedoms && !freedom_rotates(kind, info.lengths))
        info.lengths++;
    return info;
}
