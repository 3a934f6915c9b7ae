/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See ros_domain.h.
 */
#include "dds/common/ros_domain.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* An empty variable is one that is not set, as in rmw. */
static const char *variable(const char *name)
{
    const char *text = getenv(name);
    return text && *text ? text : NULL;
}

/* rmw/src/discovery_options.c: it comes before the newer variable. */
bool tfa_ros2_is_local_only(void)
{
    const char *text = variable("ROS_LOCALHOST_ONLY");
    return text && strcmp(text, "1") == 0;
}

bool tfa_ros2_is_humble(const config_ros2 *from)
{
    const char *text = variable("ROS_DISTRO");
    if (from->release != CONFIG_RELEASE_ENVIRONMENT)
        return from->release == CONFIG_RELEASE_HUMBLE;
    return text && strcmp(text, "humble") == 0;
}

static int find_domain(const config_ros2 *from, uint32_t *id, char *error, size_t size)
{
    const char *text = variable("ROS_DOMAIN_ID");
    char *end;
    *id = from->domain;
    if (from->domain != CONFIG_ROS_DOMAIN_ID)
        return TFA_OK;
    *id = 0;
    if (!text)
        return TFA_OK;
    const unsigned long number = strtoul(text, &end, 10);
    snprintf(error, size, "ROS_DOMAIN_ID: '%.40s' is not a whole number from 0 to %d", text,
             CONFIG_DOMAIN_MAX);
    if (!isdigit((unsigned char)*text) || *end || number > CONFIG_DOMAIN_MAX)
        return TFA_E_ARGUMENT;
    *id = (uint32_t)number;
    return TFA_OK;
}

static int find_range(const config_ros2 *from, config_discovery *range, char *error, size_t size)
{
    static const struct {
        const char *name;
        config_discovery range;
    } ranges[] = {
        {"SUBNET", CONFIG_DISCOVERY_SUBNET},
        {"LOCALHOST", CONFIG_DISCOVERY_LOCALHOST},
        {"OFF", CONFIG_DISCOVERY_OFF},
        {"SYSTEM_DEFAULT", CONFIG_DISCOVERY_SYSTEM_DEFAULT},
    };
    const char *text = variable("ROS_AUTOMATIC_DISCOVERY_RANGE");
    *range = (config_discovery)from->discovery;
    if (*range != CONFIG_DISCOVERY_ENVIRONMENT)
        return TFA_OK;
    *range = CONFIG_DISCOVERY_LOCALHOST;
    if (tfa_ros2_is_local_only())
        return TFA_OK;
    *range = CONFIG_DISCOVERY_SUBNET;
    if (!text)
        return TFA_OK;
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
        if (strcmp(text, ranges[i].name) == 0) {
            *range = ranges[i].range;
            return TFA_OK;
        }
    snprintf(error, size,
             "ROS_AUTOMATIC_DISCOVERY_RANGE: '%.40s' is not SUBNET, LOCALHOST, OFF or "
             "SYSTEM_DEFAULT",
             text);
    return TFA_E_ARGUMENT;
}

/* A host as it may stand in an attribute of XML. */
static int write_peer(FILE *out, const char *key, const char *host, size_t length, char *error,
                      size_t size)
{
    for (size_t i = 0; i < length; i++)
        if (!isalnum((unsigned char)host[i]) && !strchr("-_.:%[]", host[i])) {
            snprintf(error, size, "%s: '%.*s' is not a host name or address", key,
                     length < 60 ? (int)length : 60, host);
            return TFA_E_ARGUMENT;
        }
    if (length)
        fprintf(out, "<Peer address=\"%.*s\"/>", (int)length, host);
    return TFA_OK;
}

static int write_peers(FILE *out, const config_ros2 *from, char *error, size_t size)
{
    static const char name[] = "ROS_STATIC_PEERS";
    int status = TFA_OK;
    for (size_t i = 0; i < from->peers_count && status == TFA_OK; i++)
        status = write_peer(out, "ros2.static_peers", from->peers[i], strlen(from->peers[i]), error,
                            size);
    const char *hosts = from->peers_count ? NULL : variable(name);
    while (hosts && status == TFA_OK) {
        const size_t length = strcspn(hosts, ";");
        status = write_peer(out, name, hosts, length, error, size);
        hosts = hosts[length] ? hosts + length + 1 : NULL;
    }
    return status;
}

/* rmw_cyclonedds_cpp/src/rmw_node.cpp, check_create_domain */
static int write_settings(FILE *out, config_discovery range, const config_ros2 *from, char *error,
                          size_t size)
{
    int status = TFA_OK;
    /* Fast DDS notices the end of a participant by key hashes only, or 10 s later by its lease
     * (2.9.1, test ros2_fastdds_gateway). */
    fprintf(out, "<CycloneDDS><Domain Id=\"any\"><Internal><GenerateKeyhash>true</GenerateKeyhash>"
                 "</Internal>");
    if (range == CONFIG_DISCOVERY_OFF) {
        fprintf(out,
                "<Discovery><ParticipantIndex>none</ParticipantIndex>"
                "<Tag>ros_discovery_off_%d</Tag></Discovery>",
                (int)getpid());
    } else if (range != CONFIG_DISCOVERY_SYSTEM_DEFAULT) {
        if (range == CONFIG_DISCOVERY_LOCALHOST)
            fprintf(out, "<General><AllowMulticast>false</AllowMulticast></General>");
        fprintf(out, "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
                     "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>");
        if (range == CONFIG_DISCOVERY_LOCALHOST)
            fprintf(out, "<Peer address=\"localhost\"/>");
        status = write_peers(out, from, error, size);
        fprintf(out, "</Peers></Discovery>");
    }
    fprintf(out, "</Domain></CycloneDDS>");
    return status;
}

int tfa_ros2_domain(const config_ros2 *from, uint32_t *id, char **settings, char *error,
                    size_t size)
{
    config_discovery range = CONFIG_DISCOVERY_SUBNET;
    size_t length;
    *settings = NULL;
    FILE *out = open_memstream(settings, &length);
    if (!out)
        return TFA_E_MEMORY;
    int status = find_domain(from, id, error, size);
    if (status == TFA_OK)
        status = find_range(from, &range, error, size);
    if (status == TFA_OK)
        status = write_settings(out, range, from, error, size);
    if (fclose(out) != 0 && status == TFA_OK)
        status = TFA_E_MEMORY;
    if (status != TFA_OK) {
        free(*settings);
        *settings = NULL;
    }
    return status;
}

uint32_t tfa_ros2_domain_of(const config_robot *robot, uint32_t common)
{
    return robot->ros2.domain == CONFIG_ROS_DOMAIN_ID ? common : robot->ros2.domain;
}

bool tfa_ros2_is_in(const config *settings, uint32_t domain, uint32_t common)
{
    for (size_t i = 0; settings->ros2.enabled && i < settings->robots_count; i++)
        if (settings->robots[i].ros2.enabled &&
            tfa_ros2_domain_of(&settings->robots[i], common) == domain)
            return true;
    return false;
}
