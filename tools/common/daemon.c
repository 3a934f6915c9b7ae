/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One way to a running daemon, over shared memory or over DDS.
 */
#include "daemon.h"

#include "commands.h"
#include "dds_client/dds_client.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint64_t default_timeout_ns = 10000000000;

struct daemon_link {
    tfa_client *shm; /* one of the two */
    tfa_dds_client *dds;
    uint64_t timeout_ns;
};

enum { KEY_RUNTIME_DIR = 768, KEY_DOMAIN, KEY_WAIT, KEY_TIMEOUT };

static const struct argp_option option_table[] = {
    {.name = "runtime-dir",
     .key = KEY_RUNTIME_DIR,
     .arg = "DIR",
     .doc = "Where the daemon's sockets are (shm; $TOTALFORCE_RUNTIME_DIR, else /run/totalforce)"},
    {.name = "domain", .key = KEY_DOMAIN, .arg = "N", .doc = "DDS domain (dds; 0)"},
    {.name = "wait",
     .key = KEY_WAIT,
     .arg = "default|spin|hybrid|block",
     .doc = "How to wait for a reply (the daemon's default)"},
    {.name = "timeout-ms",
     .key = KEY_TIMEOUT,
     .arg = "MS",
     .doc = "Longest wait for an answer (10000) and for a connection (1000; DDS: 5000)"},
    {0}};

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    daemon_options *options = state->input;
    switch (key) {
    case KEY_RUNTIME_DIR:
        options->runtime_dir = text;
        return 0;
    case KEY_DOMAIN:
        options->domain = (uint32_t)option_unsigned(state, "domain", text, 0, 230);
        return 0;
    case KEY_WAIT:
        options->wait = (tfa_wait)option_enum(state, "wait", text, TFA_WORDS_WAIT);
        return 0;
    case KEY_TIMEOUT:
        options->timeout_ns = option_unsigned(state, "timeout-ms", text, 1, 3600000) * 1000000;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

const struct argp daemon_argp = {.options = option_table, .parser = parse_option};

int daemon_connect(const daemon_options *options, daemon_via via, daemon_link **link)
{
    int status;
    *link = NULL;
    daemon_link *made = calloc(1, sizeof *made);
    if (!made)
        return TFA_E_MEMORY;
    made->timeout_ns = options->timeout_ns ? options->timeout_ns : default_timeout_ns;
    const int32_t connect_ms = (int32_t)(options->timeout_ns / 1000000); /* 0: the default */
    if (via == DAEMON_SHM) {
        tfa_client_options shm = {.runtime_dir = options->runtime_dir,
                                  .robot = options->robot,
                                  .max_batch = options->max_batch,
                                  .max_tips = options->max_tips,
                                  .slots = options->slots,
                                  .wait = options->wait,
                                  .connect_timeout_ms = connect_ms};
        status = tfa_client_connect(&shm, &made->shm);
    } else {
        tfa_dds_client_options dds = {.domain = options->domain,
                                      .robot = options->robot,
                                      .wait = options->wait,
                                      .connect_timeout_ms = connect_ms};
        status = tfa_dds_client_connect(&dds, &made->dds);
    }
    if (status == TFA_OK) {
        *link = made;
        return TFA_OK;
    }
    int saved = errno;
    free(made);
    errno = saved;
    return status;
}

const tfa_client_info *daemon_info(const daemon_link *link)
{
    return link->shm ? tfa_client_get_info(link->shm) : tfa_dds_client_get_info(link->dds);
}

int daemon_call(daemon_link *link, const tfa_request *request, tfa_reply *reply,
                tfa_exchange *exchange)
{
    if (link->shm)
        return tfa_client_call(link->shm, request, reply, link->timeout_ns, exchange);
    return tfa_dds_client_call(link->dds, request, reply, link->timeout_ns, exchange);
}

int daemon_send(daemon_link *link, const tfa_request *request, uint64_t *id)
{
    if (link->shm)
        return tfa_client_send(link->shm, request, id);
    return tfa_dds_client_send(link->dds, request, id);
}

int daemon_receive(daemon_link *link, tfa_reply *reply, uint64_t timeout_ns, tfa_exchange *exchange)
{
    *exchange = (tfa_exchange){0};
    if (link->shm)
        return tfa_client_receive(link->shm, reply, timeout_ns, exchange);
    return tfa_dds_client_receive(link->dds, reply, timeout_ns, exchange);
}

void daemon_close(daemon_link *link)
{
    if (!link)
        return;
    tfa_client_close(link->shm);
    tfa_dds_client_close(link->dds);
    free(link);
}

int daemon_lost(int status)
{
    return status == TFA_E_DISCONNECTED || status == TFA_E_PROTOCOL || status == TFA_E_LOST ||
           status == TFA_E_TIMEOUT || status == TFA_E_SYSTEM;
}

void daemon_explain(const daemon_options *options, daemon_via via, int status, char *text,
                    size_t size)
{
    const char *configuration =
        getenv("CYCLONEDDS_URI") ? getenv("CYCLONEDDS_URI") : "not set here";
    const tfa_client_options shm = {.runtime_dir = options->runtime_dir, .robot = options->robot};
    if (via == DAEMON_SHM)
        (void)tfa_client_explain(&shm, status, text, size);
    else if (status == TFA_E_TIMEOUT)
        snprintf(text, size,
                 "robot '%s': no daemon answers in DDS domain %u: is totalforced running with "
                 "'dds: {enabled: yes, domain: %u}', and has it the same CYCLONEDDS_URI (%s)?",
                 options->robot, options->domain, options->domain, configuration);
    else if (status == TFA_E_SYSTEM) /* errno is some library's: Cyclone has its own messages */
        snprintf(
            text, size,
            "robot '%s': no part in DDS domain %u: Cyclone gives the reason on standard error; "
            "CYCLONEDDS_URI is %s%s",
            options->robot, options->domain, configuration,
            getenv("ROBOT_TAG") ? ""
                                : "; ROBOT_TAG is not set, and dds/fleet.xml needs the robot's "
                                  "name there: export ROBOT_TAG=NAME");
    else
        snprintf(text, size, "robot '%s' in DDS domain %u: %s: %s", options->robot, options->domain,
                 tfa_status_text(status), tfa_status_cause(status));
}
