/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The name by which a request reached the server.
 */
#include <arpa/inet.h>
#include <string.h>
#include <strings.h>

#include "http/http_internal.h"

typedef struct host_address {
    int family;
    unsigned char bytes[16];
    size_t size;
} host_address;

static bool read_address(const char *text, host_address *a)
{
    *a = (host_address){.family = AF_INET, .size = 4};
    if (inet_pton(AF_INET, text, a->bytes) == 1)
        return true;
    *a = (host_address){.family = AF_INET6, .size = 16};
    return inet_pton(AF_INET6, text, a->bytes) == 1;
}

static bool is_loopback(const host_address *a)
{
    static const unsigned char one[16] = {[15] = 1};
    return a->family == AF_INET ? a->bytes[0] == 127 : memcmp(a->bytes, one, 16) == 0;
}

static bool is_any(const host_address *a)
{
    static const unsigned char zeros[16];
    return memcmp(a->bytes, zeros, a->size) == 0;
}

static bool is_port(const char *text)
{
    return strlen(text) <= 5 && text[strspn(text, "0123456789")] == 0;
}

/* Name without brackets and port, in `name`. */
static bool split_host(const char *host, char *name, size_t size)
{
    const bool bracket = *host == '[';
    const char *begin = host + bracket;
    const char *end = bracket ? strchr(begin, ']') : begin + strcspn(begin, ":");
    if (!end || (size_t)(end - begin) >= size)
        return false;
    memcpy(name, begin, (size_t)(end - begin));
    name[end - begin] = 0;
    end += bracket;
    return *end == 0 || (*end == ':' && is_port(end + 1));
}

/* A name can be made to point here by anybody; a number cannot. */
bool request_host_is_ours(const char *host, const char *address)
{
    char name[64];
    host_address asked, ours;
    if (!host || !split_host(host, name, sizeof name))
        return false;
    if (strcasecmp(name, "localhost") == 0)
        return true;
    if (!read_address(name, &asked) || !read_address(address, &ours))
        return false;
    return is_loopback(&asked) || is_any(&ours) ||
           (asked.family == ours.family && memcmp(asked.bytes, ours.bytes, ours.size) == 0);
}
