/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Notes about links that are only frames.
 */
#include "model/report/report_messages.h"
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
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_link *link = &d->links[d->joints[j].child];
        if (d->joints[j].type != TFA_JOINT_FIXED || !is_frame(link))
            continue;
        tfa_report_add_grouped(log->report, TFA_NOTE, link->line, "no-inertial", "links",
                               link->name, "link '%s': no mass, on a fixed joint: kept as a frame",
                               link->name);
    }
}

void tfa_urdf_notes(const tfa_description *description, tfa_urdf_log *log)
{
    note_frames(description, log);
}
