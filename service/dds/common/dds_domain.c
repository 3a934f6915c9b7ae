/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See dds_domain.h.
 */
#include "dds/common/dds_domain.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int64_t tfa_dds_monotonic(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* ---- failures ---- */

static char last_error[384];

const char *tfa_dds_error(void)
{
    return last_error;
}

void tfa_dds_set_error(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(last_error, sizeof last_error, format, arguments);
    va_end(arguments);
}

bool tfa_dds_failed(dds_return_t entity_or_code, const char *step)
{
    if (entity_or_code >= 0)
        return false;
    tfa_dds_set_error(
        "%s: %s%s", step, dds_strretcode(entity_or_code),
        entity_or_code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY
            ? ": the permissions of this identity (CYCLONEDDS_URI) do not let it serve robots"
            : "");
    return true;
}

/* ---- join and leave ---- */

static dds_entity_t make_domain(uint32_t id, const char *settings, size_t sample_bytes)
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

static dds_entity_t make_participant(uint32_t domain, const char *user_data)
{
    dds_qos_t *qos = user_data != NULL ? dds_create_qos() : NULL;

    if (qos != NULL)
        dds_qset_userdata(qos, user_data, strlen(user_data));
    else if (user_data != NULL)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    const dds_entity_t participant = dds_create_participant(domain, qos, NULL);
    dds_delete_qos(qos); /* NULL is allowed */
    return participant;
}

int tfa_dds_join(uint32_t id, const char *settings, size_t sample_bytes, const char *user_data,
                 dds_member *member)
{
    if (sample_bytes != 0)
        member->domain = make_domain(id, settings, sample_bytes);
    if (tfa_dds_failed(member->domain, "domain (a bad CYCLONEDDS_URI?)"))
        return TFA_E_SYSTEM;
    member->participant = make_participant(id, user_data);
    return tfa_dds_failed(member->participant, "participant (a bad CYCLONEDDS_URI? no free index?)")
               ? TFA_E_SYSTEM
               : TFA_OK;
}

void tfa_dds_leave(const dds_member *member)
{
    if (member->participant > 0)
        (void)dds_delete(member->participant);
    if (member->domain > 0)
        (void)dds_delete(member->domain);
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
