/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See names.h.
 */
#include "dds/ros2/ros2_names.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* @return the end of the token that starts here; NULL: none does */
static const char *skip_token(const char *text)
{
    if (!isalpha((unsigned char)*text) && *text != '_')
        return NULL;
    for (; isalnum((unsigned char)*text) || *text == '_'; text++)
        if (text[0] == '_' && text[1] == '_')
            return NULL;
    return text;
}

static bool is_full_name(const char *name)
{
    if (strlen(name) > TFA_ROS2_NAME_MAX)
        return false;
    do {
        name = *name == '/' ? skip_token(name + 1) : NULL;
    } while (name && *name);
    return name != NULL;
}

bool tfa_ros2_is_node_name(const char *name)
{
    const char *end = skip_token(name);
    return end && !*end;
}

bool tfa_ros2_is_namespace(const char *name)
{
    return strcmp(name, "/") == 0 || is_full_name(name);
}

bool tfa_ros2_full_name(const char *name_space, const char *node, const char *name,
                        char full[TFA_ROS2_NAME_MAX + 1])
{
    const char *root = strcmp(name_space, "/") == 0 ? "" : name_space;
    int length;
    if (name[0] == '/')
        length = snprintf(full, TFA_ROS2_NAME_MAX + 1, "%s", name);
    else if (name[0] == '~' && (name[1] == '/' || !name[1]))
        length = snprintf(full, TFA_ROS2_NAME_MAX + 1, "%s/%s%s", root, node, name + 1);
    else
        length = snprintf(full, TFA_ROS2_NAME_MAX + 1, "%s/%s", root, name);
    const bool good = length >= 0 && length <= TFA_ROS2_NAME_MAX && is_full_name(full);
    if (!good)
        full[0] = 0;
    return good;
}
