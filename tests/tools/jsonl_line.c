/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads lines for the tests and compares what becomes of them.
 */
#include "jsonl_line.h"

#include "test.h"

static const char *const arm_joints[] = {"pan", "lift", "slide"};
static const char *const arm_links[] = {"base", "upper", "lower", "tool"};
const tfa_client_info arm = {.q_count = 3,
                             .v_count = 3,
                             .joint_count = 3,
                             .frame_count = 4,
                             .joint_names = arm_joints,
                             .frame_names = arm_links};

static const uint32_t boom_modes[] = {1, 1, 2};
const tfa_client_info boom = {.q_count = 3,
                              .v_count = 3,
                              .joint_count = 3,
                              .frame_count = 4,
                              .joint_names = arm_joints,
                              .frame_names = arm_links,
                              .mode_count = 3,
                              .mode_frames = boom_modes};

static const char *const closed_constraints[] = {"loop", "foot"};
const tfa_client_info closed = {.q_count = 3,
                                .v_count = 3,
                                .joint_count = 3,
                                .frame_count = 4,
                                .joint_names = arm_joints,
                                .frame_names = arm_links,
                                .constraint_count = 2,
                                .constraint_names = closed_constraints};

static const char *const ship_joints[] = {"mast", "deck", "boat"};
static const uint32_t ship_types[] = {TFA_JOINT_REVOLUTE, TFA_JOINT_PLANAR, TFA_JOINT_FLOATING};
static const char *const ship_links[] = {"hull", "sail", "crate", "dinghy"};
const tfa_client_info ship = {.q_count = 11,
                              .v_count = 10,
                              .base_freedoms = 6,
                              .joint_count = 3,
                              .frame_count = 4,
                              .joint_names = ship_joints,
                              .joint_types = ship_types,
                              .frame_names = ship_links};

void read_line(reading *r, const tfa_client_info *info, const char *line, size_t length)
{
    const jsonl_defaults defaults = JSONL_DEFAULTS;
    memset(r, 0, sizeof *r);
    assert_int_equal(tfa_names_of_info(&r->names, "robot", info), TFA_OK);
    assert_int_equal(jsonl_buffers_init(&r->buffers, &r->names), TFA_OK);
    r->status = jsonl_load(line, length, 1, &r->object, &r->error);
    if (r->status == TFA_OK)
        r->status = jsonl_read(r->object, &r->names, &defaults, &r->buffers, &r->request, &r->reply,
                               &r->error);
}

void forget(reading *r)
{
    json_decref(r->object);
    jsonl_buffers_free(&r->buffers);
    tfa_names_free(&r->names);
}

void read_good(reading *r, const tfa_client_info *info, const char *line)
{
    read_line(r, info, line, strlen(line));
    assert_int_equal(r->status, TFA_OK);
}

void count_up(double *numbers, int count)
{
    for (int i = 0; i < count; i++)
        numbers[i] = i + 1;
}

char *print_line(reading *r)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    jsonl_print_reply(out, json_object_get(r->object, "id"), &r->names, &r->buffers, &r->request,
                      &r->reply);
    fclose(out);
    return text;
}

void prints(reading *r, const char *want)
{
    char *text = print_line(r);
    assert_string_equal(text, want);
    free(text);
    forget(r);
}

void refuse_all(const tfa_client_info *info, const refusal *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        refuse(info, rows[i].line, rows[i].status, rows[i].text);
}

void refuse(const tfa_client_info *info, const char *line, int status, const char *text)
{
    reading r;
    read_line(&r, info, line, strlen(line));
    if (r.status != status || strcmp(r.error.text, text) != 0)
        print_error("line  %s\nwant  %s: %s\nfound %s: %s\n", line, tfa_status_name(status), text,
                    tfa_status_name(r.status), r.error.text);
    assert_int_equal(r.status, status);
    assert_string_equal(r.error.text, text);
    forget(&r);
}

void explain(const tfa_client_info *info, const char *line, const tfa_reply *reply,
             const char *want)
{
    reading r;
    read_good(&r, info, line);
    assert_int_equal(jsonl_explain(&r.names, &r.request, reply, &r.error), reply->status);
    assert_string_equal(r.error.text, want);
    forget(&r);
}
