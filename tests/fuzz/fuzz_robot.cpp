/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target that knows what a robot is: real robots with changes and robots from scratch are
 * loaded, compiled with random options, and computed with. Nothing may crash, whatever comes out.
 *
 * An input is a URDF file. A comment of 16 hexadecimal digits in front of it decides the options
 * and requests; without one, the text itself does.
 */
#include "generate.hpp"
#include "invariants.h"
#include "use.h"

#include <cstring>
#include <string>

extern "C" {
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);
size_t LLVMFuzzerCustomCrossOver(const uint8_t *first, size_t first_size, const uint8_t *second,
                                 size_t second_size, uint8_t *out, size_t most, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);
}

namespace
{
constexpr size_t mark_size = 4 + 16 + 3; /* <!--0123456789abcdef--> */
bool has_mark(const std::string &text)
{
    return text.size() >= mark_size && text.compare(0, 4, "<!--") == 0 &&
           text.compare(20, 3, "-->") == 0 && strspn(text.c_str() + 4, "0123456789abcdef") == 16;
}

std::string make_mark(struct random_source &c)
{
    char mark[mark_size + 1];
    snprintf(mark, sizeof mark, "<!--%016llx-->", static_cast<unsigned long long>(random_next(&c)));
    return mark;
}

/* FNV-1a of the mark, or of everything. */
uint64_t seed_of(const std::string &text)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < (has_mark(text) ? mark_size : text.size()); i++)
        hash = (hash ^ static_cast<unsigned char>(text[i])) * 0x100000001b3u;
    return hash;
}

/* The new text behind a new mark or the old one; 0 if there is none or it is too long. */
size_t to_residual_kernel(const std::string &old, const std::string &text, uint8_t *out,
                          size_t most, struct random_source &c)
{
    bool keep = has_mark(old) && random_percent(&c, 50);
    std::string whole = (keep ? old.substr(0, mark_size) : make_mark(c)) + text;
    if (text.empty() || whole.size() > most)
        return 0;
    memcpy(out, whole.data(), whole.size());
    return whole.size();
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    std::string text(reinterpret_cast<const char *>(data), size);
    struct random_source c = {seed_of(text)};
    tfa_description *d = check_parse(text.data(), text.size());
    if (d)
        use_description(d, &c);
    tfa_description_free(d);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
    struct random_source c = {seed};
    std::string old(reinterpret_cast<const char *>(data), size);
    std::string unestimated = has_mark(old) ? old.substr(mark_size) : old;
    size_t what = random_below(&c, 20);
    size_t n = 0;
    if (what < 3)
        n = to_residual_kernel(old, generate_robot(c), data, most, c);
    else if (what < 6)
        n = to_residual_kernel("", unestimated, data, most, c);
    else if (what < 19)
        n = to_residual_kernel(old, change_robot(unestimated, c), data, most, c);
    return n > 0 ? n : LLVMFuzzerMutate(data, size, most);
}

size_t LLVMFuzzerCustomCrossOver(const uint8_t *first, size_t first_size, const uint8_t *second,
                                 size_t second_size, uint8_t *out, size_t most, unsigned seed)
{
    struct random_source c = {seed};
    std::string a(reinterpret_cast<const char *>(first), first_size);
    std::string b(reinterpret_cast<const char *>(second), second_size);
    return to_residual_kernel(a, cross_robots(a, b, c), out, most, c);
}
