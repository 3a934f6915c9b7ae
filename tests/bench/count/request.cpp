/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "request.h"

#include <cstdlib>
#include <vector>

double count_request(const tfa_model *model, const tfa_request *request)
{
    const tfa_kernel &kernel = tfa_kernel_count_base;
    const size_t bytes = (kernel.size(model, TFA_METHODS_ALL) + 63) / 64 * 64;
    void *memory = std::aligned_alloc(64, bytes);
    if (!memory)
        return 0;
    std::vector<double> qdd(tfa_model_v_count(model) + 1), lambda(36 * TFA_MAX_TIPS * TFA_MAX_TIPS);
    tfa_reply reply = {};
    tfa_answer answer = {};
    reply.qdd = qdd.data();
    if (request->tip_count)
        reply.lambda_inv = lambda.data();
    state *s = kernel.init(model, TFA_METHODS_ALL, memory);
    num_forget();
    const int status = kernel.answer(s, request, 0, &reply, &answer);
    const num_tally t = num_counts;
    std::free(memory);
    return status == TFA_OK ? (double)(t.multiplications + t.additions + t.divisions) : 0;
}
