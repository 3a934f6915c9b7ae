/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Notes about what the description holds and dynamics does not use, one for each kind.
 */
#include "urdf/urdf.h"

#include <stdbool.h>

static bool is_frame(const tfa_link *link)
{
    bool massless = link->mass == 0.0;
    for (int i = 0; i < 6; i++)
        massless = massless && link->inertia[i] == 0.0;
    return massless;
}

/* Without <inertial> or with zeros in it: the same robot. */
static void note_frames(const tfa_description *d, tfa_urdf_log *log)
{
    const tfa_link *first = NULL;
    size_t count = 0;
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_link *link = &d->links[d->joints[j].child];
        if (d->joints[j].type != TFA_JOINT_FIXED || !is_frame(link))
            continue;
        first = first ? first : link;
        count++;
    }
    if (first)
        tfa_urdf_say(log, TFA_NOTE, first->line, "no-inertial",
                     "link '%s': no mass, on a fixed joint: kept as a frame; links like it: %zu",
                     first->name, count);
}

static void note_friction(const tfa_description *d, tfa_urdf_log *log)
{
    size_t count = 0;
    for (size_t j = 0; j < d->joint_count; j++)
        count += d->joints[j].friction != 0.0;
    if (count > 0)
        tfa_urdf_say(log, TFA_NOTE, 0, "friction",
                     "robot: friction of <dynamics> is ignored; joints that have it: %zu", count);
}

void tfa_urdf_notes(const tfa_description *description, tfa_urdf_log *log)
{
    note_frames(description, log);
    note_friction(description, log);
}
