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

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

namespace
{

template <class T> const T *at(const void *element)
{
    return static_cast<const T *>(element);
}

/* Writes every value. */
class writer
{
  public:
    explicit writer(Cdr &stream) : cdr(stream) {}
    template <class T> void one(const T &value)
    {
        cdr << value;
    }
    template <class T> void array(const T *first, size_t count)
    {
        cdr.serializeArray(first, count);
    }

  private:
    Cdr &cdr;
};

/* Reads as many values, and compares them bit by bit: a NaN is equal to itself. */
class comparison
{
  public:
    explicit comparison(Cdr &stream) : cdr(stream) {}
    template <class T> void one(const T &value)
    {
        T got;
        cdr >> got;
        same = same && equal(got, value);
    }
    template <class T> void array(const T *first, size_t count)
    {
        std::vector<T> got(count);
        cdr.deserializeArray(got.data(), count);
        same = same && equal(got, std::vector<T>(first, first + count));
    }
    bool same = true;

  private:
    static bool equal(const std::string &a, const std::string &b)
    {
        return a == b;
    }
    template <class T> static bool equal(const T &a, const T &b)
    {
        return std::memcmp(&a, &b, sizeof a) == 0;
    }
    template <class T> static bool equal(const std::vector<T> &a, const std::vector<T> &b)
    {
        if (a.size() != b.size())
            return false;
        for (size_t i = 0; i < a.size(); i++)
            if (!equal(a[i], b[i]))
                return false;
        return true;
    }
    Cdr &cdr;
};

size_t count_of(const msg_field &f, const void *member)
{
    if (f.shape == MSG_SEQUENCE)
        return at<dds_sequence_t>(member)->_length;
    return f.shape == MSG_ARRAY ? f.capacity : 1;
}

const void *first_of(const msg_field &f, const void *member)
{
    return f.shape == MSG_SEQUENCE ? at<dds_sequence_t>(member)->_buffer : member;
}

template <class T, class Stream> void numbers(Stream &s, const msg_field &f, const void *member)
{
    const T *const first = at<T>(first_of(f, member));
    const size_t count = count_of(f, member);

    if (f.shape == MSG_SEQUENCE)
        s.one(std::vector<T>(first, first + count));
    else if (f.shape == MSG_ARRAY)
        s.array(first, count);
    else
        s.one(*first);
}

template <class Stream> void strings(Stream &s, const msg_field &f, const void *member)
{
    const char *const *const first = at<const char *>(first_of(f, member));

    if (f.shape == MSG_SEQUENCE)
        s.one(std::vector<std::string>(first, first + count_of(f, member)));
    else
        s.one(std::string(*first));
}

template <class Stream> void message(Stream &s, const msg &m, const void *sample);

template <class Stream> void messages_in(Stream &s, const msg_field &f, const void *member)
{
    const char *const first = at<char>(first_of(f, member));
    const size_t count = count_of(f, member);

    if (f.shape == MSG_SEQUENCE)
        s.one(static_cast<uint32_t>(count));
    for (size_t i = 0; i < count; i++)
        message(s, *f.nested, first + i * f.nested->size);
}

template <class Stream> void field(Stream &s, const msg_field &f, const void *member)
{
    switch (f.type) {
    case MSG_NESTED:
        return messages_in(s, f, member);
    case MSG_INT8:
        return numbers<int8_t>(s, f, member);
    case MSG_UINT8:
    case MSG_BYTE:
        return numbers<uint8_t>(s, f, member);
    case MSG_INT16:
        return numbers<int16_t>(s, f, member);
    case MSG_UINT16:
        return numbers<uint16_t>(s, f, member);
    case MSG_INT32:
        return numbers<int32_t>(s, f, member);
    case MSG_UINT32:
        return numbers<uint32_t>(s, f, member);
    case MSG_INT64:
        return numbers<int64_t>(s, f, member);
    case MSG_UINT64:
        return numbers<uint64_t>(s, f, member);
    case MSG_FLOAT:
        return numbers<float>(s, f, member);
    case MSG_DOUBLE:
        return numbers<double>(s, f, member);
    case MSG_STRING:
        return strings(s, f, member);
    case MSG_BOUNDED_STRING: /* in place */
        return s.one(std::string(at<char>(member)));
    }
}

template <class Stream> void message(Stream &s, const msg &m, const void *sample)
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
    message(stream, *m, sample);
    out->size = cdr.getSerializedDataLength();
    out->padding = (4 - out->size % 4) % 4;
}

bool fastcdr_reads(const msg *m, const msg_bytes *in, const void *sample)
{
    /* FastBuffer takes no constant bytes; it is only read from */
    char *const bytes = reinterpret_cast<char *>(const_cast<uint8_t *>(in->byte));
    FastBuffer buffer(bytes, in->size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    comparison stream(cdr);

    try {
        cdr.read_encapsulation();
        message(stream, *m, sample);
    } catch (const eprosima::fastcdr::exception::Exception &) {
        return false;
    }
    return stream.same && cdr.getSerializedDataLength() + in->padding == in->size;
}
