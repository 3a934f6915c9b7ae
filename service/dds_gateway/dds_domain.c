/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See dds_domain.h.
 */
#include "dds_domain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

dds_entity_t tfa_dds_make_domain(uint32_t id, const char *settings, size_t sample_bytes)
{
    const char *user = getenv("CYCLONEDDS_URI");
    char *all;

    settings = settings != NULL ? settings : "";
    user = user != NULL ? user : "";
    if (asprintf(&all,
                 "%s%s%s%s<CycloneDDS><Domain Id=\"any\"><Internal><MaxSampleSize>%zu B"
                 "</MaxSampleSize></Internal></Domain></CycloneDDS>",
                 settings, *settings ? "," : "", user, *user ? "," : "", sample_bytes) < 0)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    const dds_entity_t domain = dds_create_domain(id, all);
    free(all);
    return domain;
}

/* ---- the log ---- */

static void (*taker)(const char *text);

static void pass_on(void *arg, const dds_log_data_t *data)
{
    char text[200];

    (void)arg;
    snprintf(text, sizeof text, "%.*s", (int)strcspn(data->message, "\n"), data->message);
    taker(text);
}

void tfa_dds_log_to(void (*log)(const char *text))
{
    taker = log;
    dds_set_log_sink(pass_on, NULL);
}
