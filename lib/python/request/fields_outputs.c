/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of reply fields; extents.
 */
#include "field_rows.h"
#include "robot_names.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

const output_row outputs[OUTPUT_COUNT] = {
#define OUTPUT(name, idl, key, layout, text) {key, LAYOUT_##layout, TFA_WIRE_##name, text},
    TFA_OUTPUT_WORD_LIST(OUTPUT)
#undef OUTPUT
};

enum { FLAG_COUNT = 32 - __builtin_clz(TFA_WANT_ALL) };
_Static_assert(OUTPUT_COUNT < 64, "outputs are bits of a word");

static uint64_t of_op[OP_COUNT + 1], of_flag[FLAG_COUNT];

void outputs_init(void)
{
    for (int k = 0; k < OUTPUT_COUNT; k++) {
        const tfa_output *output = &tfa_outputs[outputs[k].block];
        for (int op = 1; op <= OP_COUNT; op++)
            of_op[op] |= output->ops & TFA_OP_BIT(op) ? UINT64_C(1) << k : 0;
        for (int flag = 0; flag < FLAG_COUNT; flag++)
            of_flag[flag] |= output->flags >> flag & 1 ? UINT64_C(1) << k : 0;
    }
}

uint64_t output_candidates(tfa_op op, uint32_t flags)
{
    uint64_t bits = of_op[op];
    for (uint32_t left = flags; left; left &= left - 1)
        bits |= of_flag[__builtin_ctz(left)];
    return bits;
}

int output_is_answered(int k, const robot_names *robot, const tfa_request *request)
{
    return tfa_is_printed(&tfa_outputs[outputs[k].block], robot->names.base_freedoms,
                          robot->names.mode_count, request);
}

int output_find(const char *name)
{
    if (strcmp(name, "lambda_") == 0)
        name = "lambda";
    const char *of_base = strncmp(name, "base_", 5) == 0 ? name + 5 : "";
    for (int k = 0; k < OUTPUT_COUNT; k++)
        if (output_has_numbers(k) &&
            (strcmp(outputs[k].name, name) == 0 ||
             (outputs[k].layout == LAYOUT_FREEDOMS && strcmp(outputs[k].name, of_base) == 0)))
            return k;
    return -1;
}

uint32_t extent_size(int extent, const robot_names *robot, const tfa_request *request)
{
    const tfa_extents n =
        tfa_extents_of(robot->names.q_count, robot->names.v_count, robot->names.base_freedoms,
                       robot->names.frame_count, robot->names.mode_count, request);
    return extent == EXTENT_NONE ? 0 : (uint32_t)tfa_extent(extent, &n);
}

const char *extent_name(int extent, char *text, size_t size)
{
    static const char *const names[] = {"",
                                        "n_q",
                                        "n_v",
                                        "n",
                                        "tips",
                                        "rows",
                                        "links",
                                        "6",
                                        "2 + rows",
                                        [-EXTENT_MODES] = "n_modes",
                                        [-EXTENT_CONSTRAINTS] = "6 c",
                                        [-EXTENT_PARAMETERS] = "10 tips"};
    if (extent <= 0)
        return names[-extent];
    snprintf(text, size, "%d", extent);
    return text;
}
