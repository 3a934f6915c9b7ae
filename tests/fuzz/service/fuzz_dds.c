/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * libFuzzer target: DDS requests with fields and lengths of sequences from any bytes. A request is
 * refused by field or computed, and its reply passes to a sample and back.
 */
#include <string.h>

#include "dds_gateway/dds_convert.h"
#include "fuzz_service.h"

#define BATCH 3
#define NUMBERS 512 /* of the longest sequence */
#define ROWS (6 * TFA_MAX_TIPS)

typedef struct bytes {
    const uint8_t *at;
    size_t left;
} bytes;

/* The next number of the input; zeros at its end. */
static uint32_t next(bytes *b, size_t size)
{
    uint32_t x = 0;
    const size_t n = b->left < size ? b->left : size;
    memcpy(&x, b->at, n);
    b->at += n;
    b->left -= n;
    return x;
}

/* A length that is often right and sometimes not. */
static dds_sequence_double make_doubles(bytes *b, double *numbers)
{
    const uint32_t length = next(b, 2) % NUMBERS;
    for (uint32_t i = 0; i < length; i++)
        numbers[i] = (double)(int8_t)next(b, 1) * 0.05;
    if (length && next(b, 1) == 0)
        numbers[0] = NAN;
    return (dds_sequence_double){length, length, numbers, false};
}

static dds_sequence_unsigned_long make_indices(bytes *b, uint32_t *indices)
{
    const uint32_t length = next(b, 1) % 16;
    for (uint32_t i = 0; i < length; i++)
        indices[i] = next(b, 1);
    return (dds_sequence_unsigned_long){length, length, indices, false};
}

static void make_request(bytes *b, totalforce_dds_Request *s)
{
    static double numbers[11][NUMBERS];
    static uint32_t indices[4][16];
    *s = (totalforce_dds_Request){.op = next(b, 1) % 6,
                                  .method = next(b, 1) % 20,
                                  .estimate = next(b, 1) % 5,
                                  .frame = next(b, 1) % 4,
                                  .refine = next(b, 1) % 4,
                                  .flags = next(b, 1) % 5,
                                  .count = next(b, 1) % (BATCH + 2)};
    s->tips = make_indices(b, indices[0]);
    s->wrench_frames = make_indices(b, indices[1]);
    s->payload_frames = make_indices(b, indices[2]);
    s->locked = make_indices(b, indices[3]);
    dds_sequence_double *const arrays[] = {&s->q,
                                           &s->v,
                                           &s->tau,
                                           &s->qdd,
                                           &s->base_pose,
                                           &s->gravity,
                                           &s->wrenches,
                                           &s->payloads,
                                           &s->base_twist,
                                           &s->base_wrench,
                                           &s->base_acceleration};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        *arrays[i] = make_doubles(b, numbers[i]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static tfa_workspace *workspace;
    static double out[9][BATCH * ROWS * ROWS], in[9][BATCH * ROWS * ROWS];
    static tfa_answer answers[BATCH], answers_in[BATCH];
    static tfa_spectrum spectra[BATCH], spectra_in[BATCH];
    const tfa_dds_shape shape = {7, 7, 0, BATCH};
    bytes b = {data, size};
    totalforce_dds_Request sample;
    totalforce_dds_Reply reply_sample = {0};
    tfa_request request;
    tfa_dds_field_error error;
    if (!workspace)
        require(tfa_workspace_create(fuzz_model(), NULL, &workspace) == TFA_OK);
    make_request(&b, &sample);
    if (tfa_dds_request_view(&sample, &shape, &request, &error) != TFA_OK) {
        require(is_known_status(error.status) && error.field != TFA_FIELD_NONE);
        return 0;
    }
    tfa_reply reply = {.qdd = out[0],
                       .tau = out[1],
                       .lambda_inv = out[2],
                       .mass_matrix = out[3],
                       .poses = out[4],
                       .answers = answers,
                       .spectrum = spectra};
    tfa_reply back = {.qdd = in[0],
                      .tau = in[1],
                      .lambda_inv = in[2],
                      .mass_matrix = in[3],
                      .poses = in[4],
                      .answers = answers_in,
                      .spectrum = spectra_in};
    const int status = tfa_compute(workspace, &request, &reply);
    require(is_known_status(status));
    const tfa_dds_reply_sizes sizes = tfa_dds_sizes_of_reply(&request, &shape);
    tfa_dds_reply_fill(&reply, &sizes, &reply_sample);
    require(tfa_dds_reply_read(&reply_sample, &sizes, &back) == TFA_OK);
    require(back.status == status);
    if (tfa_dds_status_has_answers(status))
        require(memcmp(in[0], out[0], sizes.qdd * sizeof(double)) == 0);
    return 0;
}
