/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Descriptions of the messages agree with our IDL and with the hashes that ROS 2 publishes.
 */
#include "dds/ros2/type_hash.h"

#include "messages.h"
#include "test.h"

#include <sha256.h>

/* A field as rosidl_generator_type_description writes it, without its default value. */
static void print_fields(FILE *out, const msg *m)
{
    fprintf(out, "{\"type_name\": \"%s\", \"fields\": [", m->name);
    for (size_t i = 0; i < m->fields; i++) {
        const msg_field *f = &m->field[i];
        fprintf(out,
                "%s{\"name\": \"%s\", \"type\": {\"type_id\": %d, \"capacity\": %zu, "
                "\"string_capacity\": %zu, \"nested_type_name\": \"%s\"}}",
                i > 0 ? ", " : "", f->name, (int)f->type + (int)f->shape, f->capacity, f->bound,
                f->nested != NULL ? f->nested()->name : "");
    }
    fprintf(out, "]}");
}

/* Adds the messages within m, each once. */
static size_t collect(const msg *m, const msg **found, size_t count)
{
    for (size_t i = 0; i < m->fields; i++) {
        if (m->field[i].nested == NULL)
            continue;
        const msg *nested = m->field[i].nested();
        size_t k = 0;
        while (k < count && found[k] != nested)
            k++;
        if (k < count)
            continue;
        found[count] = nested;
        count = collect(nested, found, count + 1);
    }
    return count;
}

static int by_name(const void *a, const void *b)
{
    return strcmp((*(const msg *const *)a)->name, (*(const msg *const *)b)->name);
}

/* Hash of a message, RIHS01: SHA-256 of its description as JSON, referenced types sorted. */
static const char *hash_of(const msg *m)
{
    static char hex[SHA256_DIGEST_STRING_LENGTH];
    const msg *found[MESSAGES_MAX];
    const size_t count = collect(m, found, 0);
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    qsort(found, count, sizeof *found, by_name);
    fprintf(out, "{\"type_description\": ");
    print_fields(out, m);
    fprintf(out, ", \"referenced_type_descriptions\": [");
    for (size_t i = 0; i < count; i++) {
        fprintf(out, i > 0 ? ", " : "");
        print_fields(out, found[i]);
    }
    fprintf(out, "]}");
    assert_int_equal(fclose(out), 0);
    SHA256Data((const uint8_t *)text, size, hex);
    free(text);
    return hex;
}

static const msg *find(const char *name)
{
    for (const msg *const *m = messages(); *m != NULL; m++)
        if (strcmp((*m)->name, name) == 0)
            return *m;
    fail_msg("no message %s", name);
    return NULL;
}

TEST(hashes_are_those_that_ros_2_publishes)
{
    static const char *const published[][2] = {
        {"std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
        {"std_msgs/msg/Float64MultiArray",
         "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"},
        {"sensor_msgs/msg/JointState",
         "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"},
        {"sensor_msgs/msg/MultiDOFJointState",
         "4d4ded702cfba7ff3ec783835c1a1425f75e53939a430ff355d1fee4b3bbc40b"},
        {"geometry_msgs/msg/WrenchStamped",
         "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"},
        {"diagnostic_msgs/msg/DiagnosticArray",
         "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
        {"rmw_dds_common/msg/ParticipantEntitiesInfo",
         "91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"},
    };
    for (size_t i = 0; i < sizeof published / sizeof *published; i++)
        assert_string_equal(hash_of(find(published[i][0])), published[i][1]);
}

TEST(every_topic_announces_the_hash_of_its_description)
{
    for (const msg *const *m = messages(); *m != NULL; m++) {
        char expected[128];
        if ((*m)->topic == NULL)
            continue;
        snprintf(expected, sizeof expected, "typehash=RIHS01_%s;", hash_of(*m));
        const char *announced = tfa_ros2_user_data((*m)->topic->m_typename);
        assert_non_null(announced);
        assert_string_equal(announced, expected);
    }
    assert_null(tfa_ros2_user_data("sensor_msgs::msg::dds_::JointState"));
    assert_null(tfa_ros2_user_data(""));
}

/* Those of the service in totalforce_msgs, as rosidl describes it: without the id of the call,
 * which rmw_cyclonedds puts before the fields. */
TEST(services_announce_the_hashes_of_their_messages)
{
    for (const msg *const *m = services(); *m != NULL; m++) {
        char expected[128];
        if (strncmp((*m)->name, "totalforce_msgs/", 16) != 0)
            continue;
        msg described = **m;
        described.field += 2;
        described.fields -= 2;
        snprintf(expected, sizeof expected, "typehash=RIHS01_%s;", hash_of(&described));
        const char *announced = tfa_ros2_user_data((*m)->topic->m_typename);
        assert_non_null(announced);
        assert_string_equal(announced, expected);
    }
}

/* package/msg/Name is package::msg::dds_::Name_ */
TEST(types_have_the_names_of_rmw)
{
    for (const msg *const *m = messages(); *m != NULL; m++) {
        char expected[128];
        if ((*m)->topic == NULL)
            continue;
        const char *package_end = strchr((*m)->name, '/');
        snprintf(expected, sizeof expected, "%.*s::msg::dds_::%s_", (int)(package_end - (*m)->name),
                 (*m)->name, strrchr((*m)->name, '/') + 1);
        assert_string_equal((*m)->topic->m_typename, expected);
        assert_int_equal((*m)->topic->m_nkeys, 0);
    }
}

/* XTypes information would make Cyclone compare member by member with what the other side says. */
TEST(types_carry_no_type_information)
{
    for (const msg *const *m = messages(); *m != NULL; m++)
        if ((*m)->topic != NULL) {
            assert_int_equal((*m)->topic->m_flagset & DDS_TOPIC_XTYPES_METADATA, 0);
            assert_int_equal((*m)->topic->type_information.sz, 0);
        }
}

TEST(members_stand_in_the_order_and_size_of_the_description)
{
    for (const msg *const *m = messages(); *m != NULL; m++) {
        size_t end = 0;
        for (const msg_field *f = (*m)->field; f < (*m)->field + (*m)->fields; f++) {
            const size_t count = f->shape == MSG_ARRAY ? f->capacity : 1;
            assert_true(f->offset >= end && f->offset < end + sizeof(double));
            assert_int_equal(f->size, f->shape == MSG_SEQUENCE ? sizeof(dds_sequence_t)
                                                               : count * msg_element_size(f));
            end = f->offset + f->size;
        }
        assert_true((*m)->size >= end && (*m)->size < end + sizeof(double));
    }
}
