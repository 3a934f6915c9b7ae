/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The peers for `totalforce chart` (tools/python/totalforce_tools/chart_peers.py).
 */
#include "peer.h"

#include <stdint.h>
#include <stdio.h>
#include <totalforce/description.h>
#include <totalforce/status.h>

/** Number k of the table, NULL behind the last */
const struct peer *peer_at(uint32_t k);
/** The robot of a URDF file; NULL, and `why` says why in one line */
void *peer_make(const struct peer *peer, const char *path, char *why, size_t size);
/** Its function for Lambda^-1, or NULL */
int (*peer_lambda_of(const struct peer *peer))(void *, const double *, const char *, double *);

const struct peer *peer_at(uint32_t k)
{
    return peer_table[k];
}

void *peer_make(const struct peer *peer, const char *path, char *why, size_t size)
{
    tfa_report report = {0};
    tfa_description *description = NULL;
    void *robot = NULL;
    const int status = tfa_urdf_load(path, &description, &report);
    if (status == TFA_OK)
        robot = peer->make(path, description, why, size);
    else
        snprintf(why, size, "%s", tfa_status_text(status));
    tfa_description_free(description);
    tfa_report_free(&report);
    return robot;
}

int (*peer_lambda_of(const struct peer *peer))(void *, const double *, const char *, double *)
{
    const struct peer_lambda *row = peer_lambda_table;
    while (row->peer && row->peer != peer)
        row++;
    return row->peer ? row->lambda : NULL;
}
