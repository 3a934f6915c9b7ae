/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random samples of the messages, and their encoding without Cyclone; see messages.h.
 */
#include "fuzz/random.h"
#include "messages.h"

#include "test.h"

static const size_t width_of[] = {
    [MSG_INT8] = 1,  [MSG_UINT8] = 1,  [MSG_INT16] = 2, [MSG_UINT16] = 2,
    [MSG_INT32] = 4, [MSG_UINT32] = 4, [MSG_INT64] = 8, [MSG_UINT64] = 8,
    [MSG_FLOAT] = 4, [MSG_DOUBLE] = 8, [MSG_BYTE] = 1,  [MSG_BOOLEAN] = 1,
};

size_t msg_element_size(const msg_field *field)
{
    switch (field->type) {
    case MSG_NESTED:
        return field->nested()->size;
    case MSG_STRING:
        return sizeof(char *);
    case MSG_BOUNDED_STRING:
        return field->bound + 1;
    default:
        return width_of[field->type];
    }
}

/* Elements of a field: how many, and the first. */
static size_t elements(const msg_field *field, const void *sample, const uint8_t **first)
{
    *first = (const uint8_t *)sample + field->offset;
    if (field->shape == MSG_ONE)
        return 1;
    if (field->shape == MSG_ARRAY)
        return field->capacity;
    const dds_sequence_t *sequence = (const void *)*first;
    *first = sequence->_buffer;
    return sequence->_length;
}

static void *lasting(size_t size)
{
    static max_align_t store[1 << 18];
    static size_t used;
    void *const start = &store[used];
    used += (size + sizeof *store - 1) / sizeof *store;
    assert_true(used <= sizeof store / sizeof *store);
    return start;
}

static void fill_string(char *text, size_t length, struct random_source *seed)
{
    for (size_t i = 0; i < length; i++)
        text[i] = (char)(1 + random_below(seed, 255));
    text[length] = '\0';
}

static void fill_element(const msg_field *field, uint8_t *element, struct random_source *seed)
{
    if (field->type == MSG_NESTED) {
        msg_fill(field->nested(), element, seed);
    } else if (field->type == MSG_BOUNDED_STRING) {
        /* the longest is one of four */
        const size_t length = random_below(seed, 4) ? random_below(seed, 9) : field->bound;
        fill_string((char *)element, length, seed);
    } else if (field->type == MSG_STRING) {
        const size_t length = random_below(seed, 9);
        char *const text = lasting(length + 1);
        fill_string(text, length, seed);
        memcpy(element, &text, sizeof text);
    } else if (field->type == MSG_BOOLEAN) {
        *element = (uint8_t)random_below(seed, 2);
    } else {
        for (size_t i = 0; i < width_of[field->type]; i++)
            element[i] = (uint8_t)random_below(seed, 256);
    }
}

void msg_fill(const msg *m, void *sample, struct random_source *seed)
{
    for (const msg_field *f = m->field; f < m->field + m->fields; f++) {
        const uint8_t *first;
        if (f->shape == MSG_SEQUENCE) {
            const uint32_t count = (uint32_t)random_below(seed, 4);
            const dds_sequence_t sequence = {
                count, count, count ? lasting(count * msg_element_size(f)) : NULL, false};
            memcpy((uint8_t *)sample + f->offset, &sequence, sizeof sequence);
        }
        const size_t count = elements(f, sample, &first);
        for (size_t i = 0; i < count; i++)
            fill_element(f, (uint8_t *)(uintptr_t)first + i * msg_element_size(f), seed);
    }
}

#define HEADER 4 /* bytes */

static void align(msg_bytes *out, size_t width)
{
    while ((out->size - HEADER) % width != 0)
        out->byte[out->size++] = 0;
}

static void put(msg_bytes *out, const void *data, size_t size)
{
    assert_true(out->size + size + 8 <= MSG_BYTES_MAX);
    if (size > 0)
        memcpy(out->byte + out->size, data, size);
    out->size += size;
}

static void put_uint32(msg_bytes *out, size_t value)
{
    const uint8_t byte[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16),
                             (uint8_t)(value >> 24)};
    align(out, 4);
    put(out, byte, 4);
}

static void put_string(msg_bytes *out, const char *text)
{
    put_uint32(out, strlen(text) + 1);
    put(out, text, strlen(text) + 1);
}

static void put_message(msg_bytes *out, const msg *m, const void *sample)
{
    for (const msg_field *f = m->field; f < m->field + m->fields; f++) {
        const uint8_t *element;
        const size_t count = elements(f, sample, &element);
        if (f->shape == MSG_SEQUENCE)
            put_uint32(out, count);
        for (size_t i = 0; i < count; i++, element += msg_element_size(f)) {
            if (f->type == MSG_NESTED) {
                put_message(out, f->nested(), element);
            } else if (f->type == MSG_BOUNDED_STRING) {
                put_string(out, (const char *)element);
            } else if (f->type == MSG_STRING) {
                put_string(out, *(const char *const *)(const void *)element);
            } else {
                align(out, width_of[f->type]);
                put(out, element, width_of[f->type]);
            }
        }
    }
}

void msg_encode(const msg *m, const void *sample, msg_bytes *out)
{
    const uint8_t start[HEADER] = {0, 1, 0, 0};
    out->size = 0;
    put(out, start, HEADER);
    put_message(out, m, sample);
    const size_t size = out->size;
    align(out, 4);
    out->padding = out->size - size;
    out->byte[3] = (uint8_t)out->padding;
}
