/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * CRC-32 of IEEE 802.3, reflected, eight bytes at a time (Kounavis and Berry, "A Systematic
 * Approach to Building High Performance Software-Based CRC Generators", 2005).
 */
#include "recording.h"

#include <string.h>

#define POLYNOMIAL 0xedb88320u

static uint32_t tables[8][256];

static void make_tables(void)
{
    for (uint32_t i = 0; i < 256; i++) {
        uint32_t crc = i;
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? POLYNOMIAL : 0);
        tables[0][i] = crc;
    }
    for (int k = 1; k < 8; k++)
        for (uint32_t i = 0; i < 256; i++)
            tables[k][i] = tables[k - 1][i] >> 8 ^ tables[0][tables[k - 1][i] & 255];
}

uint32_t recording_crc32(uint32_t crc, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    if (!tables[0][1])
        make_tables();
    crc = ~crc;
    for (; size >= 8; size -= 8, at += 8) {
        uint32_t word[2];
        memcpy(word, at, sizeof word);
        word[0] ^= crc;
        crc = tables[7][word[0] & 255] ^ tables[6][word[0] >> 8 & 255] ^
              tables[5][word[0] >> 16 & 255] ^ tables[4][word[0] >> 24] ^ tables[3][word[1] & 255] ^
              tables[2][word[1] >> 8 & 255] ^ tables[1][word[1] >> 16 & 255] ^
              tables[0][word[1] >> 24];
    }
    for (; size; size--)
        crc = crc >> 8 ^ tables[0][(crc ^ *at++) & 255];
    return ~crc;
}
