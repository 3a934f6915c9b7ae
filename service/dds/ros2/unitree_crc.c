/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See unitree_crc.h.
 */
#include "dds/ros2/unitree_crc.h"

#include <string.h>

typedef unitree_go_msg_dds__LowState_ go_state;
typedef unitree_go_msg_dds__IMUState_ go_imu;
typedef unitree_go_msg_dds__MotorState_ go_motor;
typedef unitree_hg_msg_dds__LowState_ hg_state;
typedef unitree_hg_msg_dds__IMUState_ hg_imu;
typedef unitree_hg_msg_dds__MotorState_ hg_motor;

/* Sizes of the robots' own structs */
_Static_assert(sizeof(go_state) == 1180 && sizeof(hg_state) == 2092, "");
_Static_assert(sizeof(go_motor) == 48 && sizeof(hg_motor) == 56, "");

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define END(type, member) (offsetof(type, member) + sizeof(((type *)NULL)->member))

/* Padding of a struct: bytes from .. to - 1, `count` times, `stride` bytes apart. */
typedef struct padding {
    size_t from, to, count, stride;
} padding;

static const padding go_padding[] = {
    {END(go_state, bandwidth), offsetof(go_state, imu_state), 1, 0},
    {offsetof(go_state, imu_state) + END(go_imu, temperature), END(go_state, imu_state), 1, 0},
    {offsetof(go_state, motor_state) + END(go_motor, mode),
     offsetof(go_state, motor_state) + offsetof(go_motor, q), 20, sizeof(go_motor)},
    {offsetof(go_state, motor_state) + END(go_motor, temperature),
     offsetof(go_state, motor_state) + offsetof(go_motor, lost), 20, sizeof(go_motor)},
    {END(go_state, bit_flag), offsetof(go_state, adc_reel), 1, 0},
    {END(go_state, temperature_ntc2), offsetof(go_state, power_v), 1, 0},
};

static const padding hg_padding[] = {
    {END(hg_state, mode_machine), offsetof(hg_state, tick), 1, 0},
    {offsetof(hg_state, imu_state) + END(hg_imu, temperature), END(hg_state, imu_state), 1, 0},
    {offsetof(hg_state, motor_state) + END(hg_motor, mode),
     offsetof(hg_state, motor_state) + offsetof(hg_motor, q), 35, sizeof(hg_motor)},
};

/* Remainders of the 16 values of four bits, shifted left by 32. */
static const uint32_t remainder_of[16] = {
    0x00000000, 0x04c11db7, 0x09823b6e, 0x0d4326d9, 0x130476dc, 0x17c56b6b, 0x1a864db2, 0x1e475005,
    0x2608edb8, 0x22c9f00f, 0x2f8ad6d6, 0x2b4bcb61, 0x350c9b64, 0x31cd86d3, 0x3c8ea00a, 0x384fbdbd,
};

uint32_t tfa_unitree_crc32(const uint32_t *word, size_t count)
{
    uint32_t crc = 0xffffffff;

    for (size_t i = 0; i < count; i++) {
        crc ^= word[i];
        for (int k = 0; k < 8; k++)
            crc = crc << 4 ^ remainder_of[crc >> 28];
    }
    return crc;
}

static void clear(void *state, const padding *p, size_t count)
{
    for (const padding *end = p + count; p < end; p++)
        for (size_t k = 0; k < p->count; k++)
            memset((char *)state + p->from + k * p->stride, 0, p->to - p->from);
}

uint32_t tfa_unitree_go_crc(const unitree_go_msg_dds__LowState_ *state)
{
    uint32_t word[sizeof *state / 4];

    memcpy(word, state, sizeof word);
    clear(word, go_padding, COUNT(go_padding));
    return tfa_unitree_crc32(word, COUNT(word) - 1);
}

uint32_t tfa_unitree_hg_crc(const unitree_hg_msg_dds__LowState_ *state)
{
    uint32_t word[sizeof *state / 4];

    memcpy(word, state, sizeof word);
    clear(word, hg_padding, COUNT(hg_padding));
    return tfa_unitree_crc32(word, COUNT(word) - 1);
}
