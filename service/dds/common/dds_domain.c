/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See dds_domain.h.
 */
#include "dds/common/dds_domain.h"

#include <ctype.h>
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
    if (tfa_dds_failed(member->domain,
                       getenv("ROBOT_TAG") != NULL
                           ? "domain (a bad CYCLONEDDS_URI?)"
                           : "domain (a bad CYCLONEDDS_URI? dds/fleet.xml needs the robot's name: "
                             "export ROBOT_TAG=NAME)"))
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

/* ---- who others are ---- */

static void append_property(FILE *out, const dds_qos_t *qos, const char *name, const char *label)
{
    char *value = NULL;

    if (!dds_qget_prop(qos, name, &value))
        return;
    fputs(label, out);
    for (const char *c = value; *c != '\0'; c++)
        fputc(isprint((unsigned char)*c) && strchr("\"\\'", *c) == NULL ? *c : '?', out);
    dds_free(value);
}

static void write_origin(const dds_qos_t *qos, char *text, size_t size)
{
    FILE *out = fmemopen(text, size, "w");

    if (out == NULL)
        return;
    append_property(out, qos, "__ProcessName", "process ");
    append_property(out, qos, "__Pid", " ");
    append_property(out, qos, "__Hostname", " on ");
    append_property(out, qos, "__NetworkAddresses", ", ");
    fclose(out);
    if (*text == '\0')
        snprintf(text, size, "unknown");
}

void tfa_dds_describe_origin(dds_entity_t participant, const uint8_t guid[16],
                             char text[TFA_DDS_ORIGIN_SIZE])
{
    const dds_entity_t reader =
        dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL);
    dds_builtintopic_participant_t *found = NULL;
    dds_sample_info_t info;

    snprintf(text, TFA_DDS_ORIGIN_SIZE, "unknown");
    while (dds_take(reader, (void **)&found, &info, 1, 1) == 1) {
        if (info.valid_data && memcmp(found->key.v, guid, sizeof found->key.v) == 0)
            write_origin(found->qos, text, TFA_DDS_ORIGIN_SIZE);
        (void)dds_return_loan(reader, (void **)&found, 1);
        found = NULL;
    }
    if (reader > 0)
        (void)dds_delete(reader);
}

/* ---- security ---- */

/* An element of Cyclone's settings, by either of its names */
static bool has_element(const char *xml)
{
    return strcasestr(xml, "<Security") != NULL || strcasestr(xml, "<DDSSecurity") != NULL;
}

static bool file_has_security(const char *path)
{
    FILE *in = fopen(path, "r");
    char *line = NULL;
    size_t size = 0;
    bool found = false;

    while (in != NULL && !found && getline(&line, &size, in) > 0)
        found = has_element(line);
    free(line);
    if (in != NULL)
        fclose(in);
    return found;
}

/* Cyclone's list of files and XML, separated by commas */
bool tfa_dds_has_security(void)
{
    const char *uri = getenv("CYCLONEDDS_URI");
    char *items = strdup(uri != NULL ? uri : ""), *rest = items;
    bool found = items != NULL && has_element(items);

    for (char *item; !found && rest != NULL && (item = strsep(&rest, ",")) != NULL;)
        found = file_has_security(strncmp(item, "file://", 7) == 0 ? item + 7 : item);
    free(items);
    return found;
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
