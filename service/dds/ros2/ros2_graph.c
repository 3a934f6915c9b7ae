/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Topic ros_discovery_info: the gateway's participant has one node for each robot, with these
 * readers and writers (rmw_dds_common). Without it `ros2 node list` shows nothing, and
 * `ros2 topic info` an endpoint of an unknown node.
 */
#include "dds/ros2/ros2_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct node {
    rmw_dds_common_msg_dds__Gid_ readers[ROS2_INPUTS_MAX], writers[ROS2_OUTPUT_KINDS + 2];
} node;

/* A GUID of DDS is the gid of ROS. */
static bool append_gid(dds_entity_t entity, rmw_dds_common_msg_dds__Gid_ *gids, uint32_t *count)
{
    dds_guid_t guid;
    if (dds_get_guid(entity, &guid) != DDS_RETCODE_OK)
        return false;
    memcpy(gids[(*count)++].data, guid.v, sizeof guid.v);
    return true;
}

static bool describe_node(const tfa_ros2 *gateway, const ros2_robot *robot, node *gids,
                          rmw_dds_common_msg_dds__NodeEntitiesInfo_ *info)
{
    bool good = true;
    snprintf(info->node_namespace, sizeof info->node_namespace, "%s", robot->node_namespace);
    snprintf(info->node_name, sizeof info->node_name, "%s", robot->node);
    info->reader_gid_seq._buffer = gids->readers;
    info->writer_gid_seq._buffer = gids->writers;
    for (uint32_t k = 0; k < robot->input_count; k++)
        good = good &&
               append_gid(robot->inputs[k].reader, gids->readers, &info->reader_gid_seq._length);
    for (int k = 0; k < ROS2_OUTPUT_KINDS; k++)
        if (robot->writers[k] > 0)
            good =
                good && append_gid(robot->writers[k], gids->writers, &info->writer_gid_seq._length);
    return good &&
           append_gid(gateway->diagnostics_writer, gids->writers, &info->writer_gid_seq._length);
}

/* ---- Humble: 24 bytes of a gid, of which a GUID has 16 ---- */

typedef struct humble_node {
    rmw_dds_common_msg_dds__HumbleGid_ readers[ROS2_INPUTS_MAX], writers[ROS2_OUTPUT_KINDS + 2];
} humble_node;

static void widen_gids(rmw_dds_common_msg_dds__HumbleGid_ *to,
                       const rmw_dds_common_msg_dds__Gid_ *from, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        memcpy(to[k].data, from[k].data, sizeof from[k].data);
}

static void widen_node(const rmw_dds_common_msg_dds__NodeEntitiesInfo_ *from, humble_node *gids,
                       rmw_dds_common_msg_dds__HumbleNodeEntitiesInfo_ *to)
{
    memcpy(to->node_namespace, from->node_namespace, sizeof to->node_namespace);
    memcpy(to->node_name, from->node_name, sizeof to->node_name);
    to->reader_gid_seq._buffer = gids->readers;
    to->reader_gid_seq._length = from->reader_gid_seq._length;
    to->writer_gid_seq._buffer = gids->writers;
    to->writer_gid_seq._length = from->writer_gid_seq._length;
    widen_gids(gids->readers, from->reader_gid_seq._buffer, from->reader_gid_seq._length);
    widen_gids(gids->writers, from->writer_gid_seq._buffer, from->writer_gid_seq._length);
}

static dds_return_t write_humble(dds_entity_t writer,
                                 const rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ *message)
{
    const uint32_t count = message->node_entities_info_seq._length;
    rmw_dds_common_msg_dds__HumbleNodeEntitiesInfo_ *info = calloc(count, sizeof *info);
    humble_node *gids = calloc(count, sizeof *gids);
    rmw_dds_common_msg_dds__HumbleParticipantEntitiesInfo_ humble = {
        .node_entities_info_seq = {count, count, info, false}};
    dds_return_t code = info && gids ? DDS_RETCODE_OK : DDS_RETCODE_OUT_OF_RESOURCES;
    memcpy(humble.gid.data, message->gid.data, sizeof message->gid.data);
    for (uint32_t i = 0; code == DDS_RETCODE_OK && i < count; i++)
        widen_node(&message->node_entities_info_seq._buffer[i], &gids[i], &info[i]);
    if (code == DDS_RETCODE_OK)
        code = dds_write(writer, &humble);
    free(gids);
    free(info);
    return code;
}

int ros2_publish_graph(const tfa_ros2 *gateway)
{
    const uint32_t count = gateway->robot_count;
    rmw_dds_common_msg_dds__NodeEntitiesInfo_ *info = calloc(count, sizeof *info);
    node *gids = calloc(count, sizeof *gids);
    rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ message = {
        .node_entities_info_seq = {count, count, info, false}};
    dds_guid_t guid;
    int status = info && gids ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t i = 0; status == TFA_OK && i < count; i++)
        if (!describe_node(gateway, &gateway->robots[i], &gids[i], &info[i]))
            status = TFA_E_SYSTEM;
    if (status == TFA_OK && dds_get_guid(gateway->member.participant, &guid) != DDS_RETCODE_OK)
        status = TFA_E_SYSTEM;
    if (status == TFA_OK) {
        memcpy(message.gid.data, guid.v, sizeof guid.v);
        const dds_return_t code = gateway->humble ? write_humble(gateway->graph_writer, &message)
                                                  : dds_write(gateway->graph_writer, &message);
        status = code == DDS_RETCODE_OK ? TFA_OK : TFA_E_SYSTEM;
    }
    free(gids);
    free(info);
    return status;
}
