/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See fastcdr_wire.h. The calls are those of rosidl_typesupport_fastrtps_cpp: numbers and strings
 * by operator <<, arrays by serializeArray, sequences of numbers and strings as vectors, sequences
 * of messages as a count and the messages.
 */
#include "fastcdr_wire.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

namespace
{
/* Walks a message; Stream is `writer` or `reader`. */
template <class Stream> void message(Stream &s, const msg &m, void *sample);
template <class T> T *at(void *element)
{
    return static_cast<T *>(element);
}

size_t inline_count(const msg_field &f)
{
    return f.shape == MSG_ARRAY ? f.capacity : 1;
}

class writer
{
  public:
    explicit writer(Cdr &stream) : cdr(stream) {}
    template <class T> void numbers(const msg_field &f, void *member)
    {
        if (f.shape == MSG_SEQUENCE)
            cdr << vector_of<T>(*at<dds_sequence_t>(member));
        else if (f.shape == MSG_ARRAY)
            cdr.serializeArray(at<T>(member), f.capacity);
        else
            cdr << *at<T>(member);
    }
    void strings(const msg_field &f, void *member)
    {
        if (f.shape == MSG_SEQUENCE) {
            const std::vector<char *> text = vector_of<char *>(*at<dds_sequence_t>(member));
            cdr << std::vector<std::string>(text.begin(), text.end());
        } else {
            cdr << std::string(*at<char *>(member));
        }
    }
    void bounded_string(const msg_field &, void *member)
    {
        cdr << std::string(at<char>(member));
    }
    void nested(const msg_field &f, void *member)
    {
        size_t count = inline_count(f);
        char *first = at<char>(member);
        if (f.shape == MSG_SEQUENCE) {
            const dds_sequence_t &sequence = *at<dds_sequence_t>(member);
            count = sequence._length;
            first = at<char>(sequence._buffer);
            cdr << sequence._length;
        }
        for (size_t i = 0; i < count; i++)
            message(*this, *f.nested(), first + i * f.nested()->size);
    }

  private:
    template <class T> static std::vector<T> vector_of(const dds_sequence_t &sequence)
    {
        const T *const first = at<T>(sequence._buffer);
        return std::vector<T>(first, first + sequence._length);
    }
    Cdr &cdr;
};

/* Allocates as Cyclone does: dds_sample_free frees what it made. */
class reader
{
  public:
    explicit reader(Cdr &stream) : cdr(stream) {}
    template <class T> void numbers(const msg_field &f, void *member)
    {
        if (f.shape == MSG_SEQUENCE) {
            std::vector<T> got;
            cdr >> got;
            std::copy(got.begin(), got.end(), allocate<T>(got.size(), sizeof(T), member));
        } else if (f.shape == MSG_ARRAY) {
            cdr.deserializeArray(at<T>(member), f.capacity);
        } else {
            cdr >> *at<T>(member);
        }
    }
    void strings(const msg_field &f, void *member)
    {
        if (f.shape == MSG_SEQUENCE) {
            std::vector<std::string> got;
            cdr >> got;
            char **const first = allocate<char *>(got.size(), sizeof(char *), member);
            for (size_t i = 0; i < got.size(); i++)
                first[i] = dds_string_dup(got[i].c_str());
        } else {
            std::string got;
            cdr >> got;
            *at<char *>(member) = dds_string_dup(got.c_str());
        }
    }
    void bounded_string(const msg_field &f, void *member)
    {
        std::string got;
        cdr >> got;
        at<char>(member)[got.copy(at<char>(member), f.bound)] = '\0';
    }
    void nested(const msg_field &f, void *member)
    {
        size_t count = inline_count(f);
        char *first = at<char>(member);
        if (f.shape == MSG_SEQUENCE) {
            uint32_t got;
            cdr >> got;
            count = got;
            first = allocate<char>(count, f.nested()->size, member);
        }
        for (size_t i = 0; i < count; i++)
            message(*this, *f.nested(), first + i * f.nested()->size);
    }

  private:
    /* Elements of a sequence, all zero. */
    template <class T> static T *allocate(size_t count, size_t size, void *member)
    {
        dds_sequence_t &sequence = *at<dds_sequence_t>(member);
        sequence._length = sequence._maximum = static_cast<uint32_t>(count);
        sequence._buffer = nullptr;
        if (count > 0) {
            sequence._buffer = at<uint8_t>(dds_alloc(count * size));
            std::memset(sequence._buffer, 0, count * size);
        }
        sequence._release = true;
        return at<T>(sequence._buffer);
    }
    Cdr &cdr;
};

template <class Stream> void field(Stream &s, const msg_field &f, void *member)
{
    switch (f.type) {
    case MSG_NESTED:
        return s.nested(f, member);
    case MSG_INT8:
        return s.template numbers<int8_t>(f, member);
    case MSG_UINT8:
    case MSG_BYTE:
    case MSG_BOOLEAN: /* one byte, 0 or 1 */
        return s.template numbers<uint8_t>(f, member);
    case MSG_INT16:
        return s.template numbers<int16_t>(f, member);
    case MSG_UINT16:
        return s.template numbers<uint16_t>(f, member);
    case MSG_INT32:
        return s.template numbers<int32_t>(f, member);
    case MSG_UINT32:
        return s.template numbers<uint32_t>(f, member);
    case MSG_INT64:
        return s.template numbers<int64_t>(f, member);
    case MSG_UINT64:
        return s.template numbers<uint64_t>(f, member);
    case MSG_FLOAT:
        return s.template numbers<float>(f, member);
    case MSG_DOUBLE:
        return s.template numbers<double>(f, member);
    case MSG_STRING:
        return s.strings(f, member);
    case MSG_BOUNDED_STRING:
        return s.bounded_string(f, member);
    }
}

template <class Stream> void message(Stream &s, const msg &m, void *sample)
{
    for (size_t i = 0; i < m.fields; i++)
        field(s, m.field[i], at<char>(sample) + m.field[i].offset);
}

} // namespace

void fastcdr_encode(const msg *m, const void *sample, uint8_t filling, msg_bytes *out)
{
    std::memset(out->byte, filling, sizeof out->byte);
    FastBuffer buffer(reinterpret_cast<char *>(out->byte), sizeof out->byte);
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    writer stream(cdr);
    cdr.serialize_encapsulation();
    message(stream, *m, const_cast<void *>(sample)); /* which a writer only reads */
    out->size = cdr.getSerializedDataLength();
    out->padding = (4 - out->size % 4) % 4;
}

bool fastcdr_decode(const msg *m, const msg_bytes *in, void *sample)
{
    /* FastBuffer takes no constant bytes; it is only read from */
    char *const bytes = reinterpret_cast<char *>(const_cast<uint8_t *>(in->byte));
    FastBuffer buffer(bytes, in->size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    reader stream(cdr);
    std::memset(sample, 0, m->size);
    try {
        cdr.read_encapsulation();
        message(stream, *m, sample);
    } catch (const eprosima::fastcdr::exception::Exception &) {
        return false;
    }
    return in->size - cdr.getSerializedDataLength() < 4;
}
