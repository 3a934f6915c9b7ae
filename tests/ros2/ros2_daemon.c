/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See ros2_daemon.h.
 */
#include "ros2_daemon.h"

#include "models.h"

harness running;
arm_node node;
tfa_model *model;
tfa_workspace *workspace;

void load_robot(const char *urdf, const tfa_model_options *options)
{
    model = bundled_model(urdf, options);
    workspace = workspace_for(model, NULL);
}

dds_entity_t open_writer(const dds_topic_descriptor_t *type, ros2_peer_qos qos, const char *format,
                         ...)
{
    char topic[128];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(topic, sizeof topic, format, arguments);
    va_end(arguments);
    const dds_entity_t writer = ros2_peer_writer(node.participant, type, topic, qos);
    ros2_peer_await_reader(writer);
    return writer;
}

dds_entity_t open_reader(const dds_topic_descriptor_t *type, const char *format, ...)
{
    char topic[128];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(topic, sizeof topic, format, arguments);
    va_end(arguments);
    const dds_entity_t reader = ros2_peer_reader(node.participant, type, topic, PEER_DEFAULT);
    ros2_peer_await_writer(reader);
    return reader;
}

int stop(void **state)
{
    (void)state;
    arm_node_close(&node);
    harness_remove(&running);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}
