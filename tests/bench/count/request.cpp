/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "request.h"

#include <cstdlib>
#include <vector>

#include "interface/kernel_table.h"
#include "spatial/num.h"

extern const struct tfa_kernel tfa_kernel_count_base;

/* As auto resolves a request of a short chain without mimics */
static tfa_resolved resolved(const tfa_request *r)
{
    const tfa_method by_op = r->op == TFA_OP_INVERSE_DYNAMICS      ? TFA_METHOD_RNEA
                             : r->op == TFA_OP_MASS_MATRIX         ? TFA_METHOD_CRBA
                             : r->op == TFA_OP_OPERATIONAL_INERTIA ? TFA_METHOD_PROPAGATION
                                                                   : TFA_METHOD_ABA;
    const tfa_method method = r->method == TFA_METHOD_AUTO ? by_op : r->method;
    return tfa_resolved{method, r->method == TFA_METHOD_AUTO ? TFA_METHOD_PROPAGATION : method};
}

double count_request(const tfa_model *model, const tfa_request *request)
{
    const tfa_kernel &kernel = tfa_kernel_count_base;
    const size_t bytes = (kernel.size(model, {TFA_METHODS_ALL, TFA_MAX_TIPS}) + 63) / 64 * 64;
    void *memory = std::aligned_alloc(64, bytes);
    if (!memory)
        return 0;
    std::vector<double> qdd(tfa_model_v_count(model) + 1), lambda(36 * TFA_MAX_TIPS * TFA_MAX_TIPS);
    tfa_reply reply = {};
    tfa_answer answer = {};
    reply.qdd = qdd.data();
    if (request->tip_count)
        reply.lambda_inv = lambda.data();
    state *s = kernel.init(model, {TFA_METHODS_ALL, TFA_MAX_TIPS}, memory);
    num_forget();
    const int status = kernel.answer(s, request, resolved(request), 0, 1, &reply, &answer);
    const num_tally t = num_counts;
    std::free(memory);
    return status == TFA_OK ? (double)(t.multiplications + t.additions + t.divisions) : 0;
}
