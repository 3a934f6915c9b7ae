/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Files that do not match their checksum: cut, changed, for another version or model, or no shared
 * object at all. Nothing of them is loaded.
 */
#include "bench.h"
#include "model/hash.h"
#include "specialised/specialised_internal.h"
#include "test.h"

struct kernel_file {
    bench b;
    char path[256];
    char *bytes;
    size_t size;
};

static int open_group(void **state)
{
    static struct kernel_file s;
    bench_open(&s.b);
    bench_build(&s.b, s.b.arm, "SOUND", bench_path(&s.b, "kernel.so", s.path));
    s.bytes = bench_read(s.path, &s.size);
    *state = &s;
    return 0;
}

static int close_group(void **state)
{
    struct kernel_file *s = *state;
    free(s->bytes);
    bench_close(&s->b);
    return 0;
}

static int try_bytes(struct kernel_file *s, const char *bytes, size_t size)
{
    bench_write(s->path, bytes, size);
    return bench_load(&s->b, s->path);
}

TEST(cut_files_are_refused)
{
    struct kernel_file *s = *state;
    const size_t trailer = sizeof(struct checksum_trailer);
    const size_t sizes[] = {
        1,           64,          trailer - 1, trailer,           trailer + 1,
        s->size / 2, s->size - 1, s->size - 8, s->size - trailer, s->size - trailer - 1};
    assert_int_equal(try_bytes(s, s->bytes, s->size), TFA_OK);
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        assert_int_equal(try_bytes(s, s->bytes, sizes[k]), TFA_E_PARSE);
        bench_assert_error_text(&s->b, "truncated or no kernel");
    }
    /* and one that has something behind it */
    char *longer = calloc(1, s->size + 1);
    memcpy(longer, s->bytes, s->size);
    assert_int_equal(try_bytes(s, longer, s->size + 1), TFA_E_PARSE);
    free(longer);
}

TEST(any_changed_byte_is_seen)
{
    struct kernel_file *s = *state;
    char *changed = malloc(s->size);
    const size_t step = s->size / 211;
    for (size_t at = 0; at < s->size; at += at + step < s->size - 100 ? step : 1) {
        memcpy(changed, s->bytes, s->size);
        changed[at] ^= 4;
        assert_int_equal(try_bytes(s, changed, s->size), TFA_E_PARSE);
    }
    free(changed);
}

/* With a new checksum, so that only what it says about itself is wrong */
TEST(other_versions_and_models_are_refused)
{
    struct kernel_file *s = *state;
    struct checksum_trailer *trailer = (struct checksum_trailer *)(void *)malloc(sizeof *trailer);
    char *changed = malloc(s->size);
    uint8_t other[32] = {1, 2, 3};
    memcpy(changed, s->bytes, s->size);
    checksum_trailer_make(changed, s->size - sizeof *trailer, other, trailer);
    memcpy(changed + s->size - sizeof *trailer, trailer, sizeof *trailer);
    assert_int_equal(try_bytes(s, changed, s->size), TFA_E_UNSUPPORTED);
    bench_assert_error_text(&s->b, "for another model, 01020300");
    free(changed);
    free(trailer);
}

/* A checksum is no proof that it is a shared object. */
TEST(garbage_with_a_checksum_is_refused)
{
    struct kernel_file *s = *state;
    struct checksum_trailer trailer;
    char rubbish[256 + sizeof trailer];
    uint8_t hash[32];
    memset(rubbish, 'x', 256);
    tfa_hash_without_gravity(s->b.arm, hash);
    checksum_trailer_make(rubbish, 256, hash, &trailer);
    memcpy(rubbish + 256, &trailer, sizeof trailer);
    assert_int_equal(try_bytes(s, rubbish, sizeof rubbish), TFA_E_FILE);
    bench_assert_error_text(&s->b, "cannot be loaded");
}

int main(void)
{
    return test_run(open_group, close_group);
}
