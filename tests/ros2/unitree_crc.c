/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Unitree's CRC against long division and against values of others; padding does not count.
 */
#include "dds/ros2/unitree_crc.h"

#include "fuzz/random.h"
#include "messages.h"
#include "test.h"

/* What the CRC unit of STM32 processors, the same CRC, is documented to answer. */
TEST(words_have_the_crc_of_an_stm32)
{
    static const struct {
        uint32_t word[2];
        size_t count;
        uint32_t crc;
    } rows[] = {
        {{0}, 0, 0xffffffff},
        {{0}, 1, 0xc704dd7b},
        {{0xffffffff}, 1, 0},
        {{0x12345678}, 1, 0xdf8a8a2b},
        {{0x12345678, 0x9abcdef0}, 2, 0x7d24a31b},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_int_equal(tfa_unitree_crc32(rows[i].word, rows[i].count), rows[i].crc);
}

/* Remainder of a division by the polynomial, bit by bit. */
static uint32_t long_division(const uint8_t *image, size_t size)
{
    uint32_t remainder = 0xffffffff;
    for (size_t i = 0; i + 4 <= size; i += 4)
        for (int byte = 3; byte >= 0; byte--)
            for (int bit = 7; bit >= 0; bit--) {
                const uint32_t in = (uint32_t)image[i + (size_t)byte] >> bit & 1;
                const uint32_t out = remainder >> 31;
                remainder <<= 1;
                if (in != out)
                    remainder ^= 0x04c11db7;
            }
    return remainder;
}

/* Copies the members of a message, and nothing between them. */
static void copy_members(const msg *m, const uint8_t *sample, uint8_t *image)
{
    for (const msg_field *f = m->field; f < m->field + m->fields; f++) {
        const size_t size = msg_element_size(f);
        for (size_t k = f->offset; k < f->offset + f->size; k += size)
            if (f->type == MSG_NESTED)
                copy_members(f->nested(), sample + k, image + k);
            else
                memcpy(image + k, sample + k, size);
    }
}

TEST(states_have_the_crc_of_their_members)
{
    const msg *const go = msg_of_topic(&unitree_go_msg_dds__LowState__desc);
    const msg *const hg = msg_of_topic(&unitree_hg_msg_dds__LowState__desc);
    struct random_source seed = {1};
    for (int padding = 0; padding < 256; padding += 51)
        for (int i = 0; i < 10; i++) {
            union {
                uint8_t byte[4096];
                unitree_go_msg_dds__LowState_ go;
                unitree_hg_msg_dds__LowState_ hg;
            } low;
            uint8_t image[4096] = {0};
            memset(&low, padding, sizeof low);
            msg_fill(go, &low.go, &seed);
            copy_members(go, low.byte, image);
            assert_int_equal(tfa_unitree_go_crc(&low.go), long_division(image, go->size - 4));
            memset(image, 0, sizeof image);
            memset(&low, padding, sizeof low);
            msg_fill(hg, &low.hg, &seed);
            copy_members(hg, low.byte, image);
            assert_int_equal(tfa_unitree_hg_crc(&low.hg), long_division(image, hg->size - 4));
        }
}

/* Structs of zeros, and structs whose byte k is 7 k + 3, padding included. Expected: computed from
 * the formats in unitree_sdk2_python/unitree_sdk2py/utils/crc.py of Unitree, whose padding is 0. */
TEST(states_have_the_crc_of_unitree)
{
    union {
        uint8_t byte[4096];
        unitree_go_msg_dds__LowState_ go;
        unitree_hg_msg_dds__LowState_ hg;
    } low = {{0}};
    assert_int_equal(tfa_unitree_go_crc(&low.go), 0x85f11ea6);
    assert_int_equal(tfa_unitree_hg_crc(&low.hg), 0xd64bb04a);
    for (size_t i = 0; i < sizeof low.byte; i++)
        low.byte[i] = (uint8_t)(7 * i + 3);
    assert_int_equal(tfa_unitree_go_crc(&low.go), 0xa82df4c2);
    assert_int_equal(tfa_unitree_hg_crc(&low.hg), 0x62ceccc5);
}
