/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A consumer in C++: the headers compile as C++, and a unique_ptr releases what C made.
 */
#include <iostream>
#include <memory>
#include <totalforce/totalforce.h>
#include <vector>

int main(int argc, char **argv)
{
    tfa_report report{};
    tfa_model *loaded = nullptr;
    int status = argc == 2 ? tfa_model_load(argv[1], nullptr, &report, &loaded) : TFA_E_ARGUMENT;
    tfa_report_free(&report);
    if (status != TFA_OK) {
        std::cerr << tfa_status_text(status) << '\n';
        return 1;
    }
    std::unique_ptr<tfa_model, decltype(&tfa_model_free)> model(loaded, tfa_model_free);
    tfa_workspace *made = nullptr;
    if (tfa_workspace_create(model.get(), nullptr, &made) != TFA_OK)
        return 1;
    std::unique_ptr<tfa_workspace, decltype(&tfa_workspace_free)> workspace(made,
                                                                            tfa_workspace_free);
    std::vector<double> q(tfa_model_q_count(loaded)), qdd(tfa_model_v_count(loaded));
    tfa_request request{};
    tfa_reply reply{};
    request.op = TFA_OP_FORWARD_DYNAMICS;
    request.refine = TFA_REFINE_DEFAULT;
    request.count = 1;
    request.q = q.data();
    reply.qdd = qdd.data();
    if (tfa_compute(workspace.get(), &request, &reply) != TFA_OK)
        return 1;
    for (double a : qdd)
        std::cout << a << '\n';
    return 0;
}
