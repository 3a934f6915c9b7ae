/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The descriptions in messages.h have the fields of Debian's .msg files, in their order. These
 * are files of ROS 1; ROS 2 made of them what `as_in_ros_2` and `dropped_in_ros_2` say, and nothing
 * else in these messages.
 *
 * Not in Debian: builtin_interfaces (in ROS 1 the primitive types time and duration),
 * rmw_dds_common, and the messages of Unitree.
 */
#include "messages.h"
#include "test.h"

static const struct {
    const char *name;
    msg_type type;
} primitives[] = {
    {"int8", MSG_INT8},     {"uint8", MSG_UINT8},    {"int16", MSG_INT16},   {"uint16", MSG_UINT16},
    {"int32", MSG_INT32},   {"uint32", MSG_UINT32},  {"int64", MSG_INT64},   {"uint64", MSG_UINT64},
    {"float32", MSG_FLOAT}, {"float64", MSG_DOUBLE}, {"string", MSG_STRING}, {"byte", MSG_BYTE},
};

/* Types that ROS 1 names without a package. The seconds of its time were unsigned. */
static const char *const as_in_ros_2[][2] = {
    {"time", "builtin_interfaces/msg/Time"},
    {"duration", "builtin_interfaces/msg/Duration"},
    {"Header", "std_msgs/msg/Header"},
};

/* Message, type and name of its fields that ROS 2 no longer has. */
static const char *const dropped_in_ros_2[][3] = {
    {"std_msgs/msg/Header", "uint32", "seq"},
};

static const char *const not_in_debian[] = {
    "builtin_interfaces/",
    "rmw_dds_common/",
    "unitree_go/",
    "unitree_hg/",
};

static bool starts_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

static bool in_debian(const msg *m)
{
    for (size_t i = 0; i < sizeof not_in_debian / sizeof *not_in_debian; i++)
        if (starts_with(m->name, not_in_debian[i]))
            return false;
    return true;
}

static bool is_dropped(const msg *m, const char *type, const char *name)
{
    for (size_t i = 0; i < sizeof dropped_in_ros_2 / sizeof *dropped_in_ros_2; i++)
        if (strcmp(m->name, dropped_in_ros_2[i][0]) == 0 &&
            strcmp(type, dropped_in_ros_2[i][1]) == 0 && strcmp(name, dropped_in_ros_2[i][2]) == 0)
            return true;
    return false;
}

/* Name in ROS 2 of a message type within m's file: of the same package unless it names one. */
static void full_name(const msg *m, const char *type, char *out, size_t size)
{
    const char *slash = strchr(type, '/');
    for (size_t i = 0; i < sizeof as_in_ros_2 / sizeof *as_in_ros_2; i++)
        if (strcmp(type, as_in_ros_2[i][0]) == 0) {
            snprintf(out, size, "%s", as_in_ros_2[i][1]);
            return;
        }
    if (slash == NULL)
        snprintf(out, size, "%.*s/msg/%s", (int)strcspn(m->name, "/"), m->name, type);
    else
        snprintf(out, size, "%.*s/msg/%s", (int)(slash - type), type, slash + 1);
}

static void check_type(const msg *m, const msg_field *f, const char *type)
{
    char expected[128];
    for (size_t i = 0; i < sizeof primitives / sizeof *primitives; i++)
        if (strcmp(primitives[i].name, type) == 0) {
            assert_int_equal(f->type, primitives[i].type);
            return;
        }
    assert_int_equal(f->type, MSG_NESTED);
    full_name(m, type, expected, sizeof expected);
    assert_string_equal(f->nested()->name, expected);
}

/* Compares a field with its line, split into type and name. Cuts the brackets from `type`. */
static void check_field(const msg *m, const msg_field *f, char *type, const char *name)
{
    char *const bracket = strchr(type, '[');
    msg_shape shape = MSG_ONE;
    size_t capacity = 0;
    if (bracket != NULL) {
        capacity = strtoul(bracket + 1, NULL, 10);
        shape = capacity > 0 ? MSG_ARRAY : MSG_SEQUENCE;
        *bracket = '\0';
    }
    assert_string_equal(f->name, name);
    assert_int_equal(f->shape, shape);
    assert_int_equal(f->capacity, capacity);
    assert_int_equal(f->bound, 0);
    check_type(m, f, type);
}

/* Splits a line of a .msg file. Returns false if it declares no field: empty, comment, constant. */
static bool split(char *line, char **type, char **name)
{
    char *rest;
    line[strcspn(line, "#\r\n")] = '\0';
    if (strchr(line, '=') != NULL)
        return false;
    *type = strtok_r(line, " \t", &rest);
    if (*type == NULL)
        return false;
    *name = strtok_r(NULL, " \t", &rest);
    assert_non_null(*name);
    assert_null(strtok_r(NULL, " \t", &rest));
    return true;
}

static void check_message(const msg *m)
{
    char path[256], line[512], *type, *name;
    size_t fields = 0;
    snprintf(path, sizeof path, "%s/%s.msg", TFA_ROS_MESSAGES, m->name);
    FILE *const file = fopen(path, "r");
    if (file == NULL)
        fail_msg("%s: no such file", path);
    while (fgets(line, sizeof line, file) != NULL) {
        if (!split(line, &type, &name) || is_dropped(m, type, name))
            continue;
        if (fields == m->fields)
            fail_msg("%s: the description lacks %s", m->name, name);
        check_field(m, &m->field[fields++], type, name);
    }
    assert_int_equal(fields, m->fields);
    assert_int_equal(fclose(file), 0);
}

TEST(descriptions_have_the_fields_of_the_msg_files)
{
    size_t compared = 0;
    for (const msg *const *m = messages(); *m != NULL; m++)
        if (in_debian(*m)) {
            check_message(*m);
            compared++;
        }
    assert_true(compared > 0);
}
