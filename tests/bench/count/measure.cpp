/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Runs the kernels over the number that counts, step by step.
 */
#include "measure.h"

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "dynamics/chain/tfa.h"
#include "dynamics/core/recursions.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"
#include "scan_tree.h"

namespace
{
/* Links and joints with nothing zero: masses about 1 kg, lengths about 1 m */
class chain_maker
{
  public:
    chain_maker(unsigned joints, unsigned modes)
        : names_(joints + 1), links_(joints + 1), joints_(joints), modes_(modes ? joints - 1 : 0),
          shapes_(joints)
    {
        for (unsigned i = 0; i <= joints; i++)
            link(i);
        for (unsigned i = 0; i < joints; i++)
            joint(i);
        for (unsigned k = 0; k < 6 * modes; k++)
            momentum_.push_back(0.02 * uniform());
        for (unsigned k = 0; k < 6 * modes; k++)
            shape_.push_back(0.1 * uniform());
        for (unsigned k = 0; k < modes * modes; k++)
            mass_.push_back(k % (modes + 1) == 0 ? 0.1 : 0.001);
        for (unsigned i = 0; i < modes_.size(); i++) { /* all but the last, which carries nothing */
            shapes_[i] = {joints_[i + 1].name, shape_.data()};
            modes_[i] = {};
            modes_[i].link = links_[i + 1].name;
            modes_[i].mode_count = modes;
            modes_[i].momentum = momentum_.data();
            modes_[i].mass = modes_[i].stiffness = modes_[i].damping = mass_.data();
            modes_[i].shapes = &shapes_[i];
            modes_[i].shape_count = 1;
        }
    }
    tfa_model *compile()
    {
        tfa_description d = {};
        d.name = "chain";
        d.links = links_.data();
        d.link_count = links_.size();
        d.joints = joints_.data();
        d.joint_count = joints_.size();
        tfa_model *model = nullptr;
        tfa_scene scene = {};
        scene.modes = modes_.data();
        scene.modes_count = modes_.size();
        tfa_model_options options = {};
        options.scene = &scene;
        return tfa_model_create(&d, &options, nullptr, &model) == TFA_OK ? model : nullptr;
    }
    double uniform()
    {
        return std::uniform_real_distribution<double>(-1, 1)(engine_);
    }

  private:
    void unit(double *x, int n)
    {
        double sum = 0;
        for (int k = 0; k < n; k++) {
            x[k] = uniform();
            sum += x[k] * x[k];
        }
        for (int k = 0; k < n; k++)
            x[k] /= std::sqrt(sum);
    }
    void link(unsigned i)
    {
        tfa_link &l = links_[i] = {};
        names_[i] = "l" + std::to_string(i);
        l.name = names_[i].c_str();
        l.mass = 1 + 0.2 * uniform();
        l.com[0] = 0.5;
        l.com[1] = 0.05 * uniform();
        l.com[2] = 0.05 * uniform();
        unit(l.quat, 4);
        l.inertia[0] = 0.05 + 0.01 * uniform();
        l.inertia[3] = 0.06 + 0.01 * uniform();
        l.inertia[5] = 0.07 + 0.01 * uniform();
    }
    void joint(unsigned i)
    {
        tfa_joint &j = joints_[i] = {};
        j.name = names_[i + 1].c_str();
        j.type = TFA_JOINT_CONTINUOUS;
        j.parent = i;
        j.child = i + 1;
        const double alpha = M_PI * uniform(), theta = M_PI * uniform(), d = 0.1 * uniform();
        j.xyz[0] = 1;
        j.xyz[1] = -d * std::sin(alpha);
        j.xyz[2] = d * std::cos(alpha);
        j.quat[0] = std::sin(alpha / 2) * std::cos(theta / 2);
        j.quat[1] = -std::sin(alpha / 2) * std::sin(theta / 2);
        j.quat[2] = std::cos(alpha / 2) * std::sin(theta / 2);
        j.quat[3] = std::cos(alpha / 2) * std::cos(theta / 2);
        j.axis[2] = 1;
        j.mimic = -1;
    }
    std::mt19937 engine_{1};
    std::vector<std::string> names_;
    std::vector<tfa_link> links_;
    std::vector<tfa_joint> joints_;
    std::vector<tfa_link_modes> modes_;
    std::vector<tfa_mode_shape> shapes_;
    std::vector<double> momentum_, mass_, shape_;
};

count_part take()
{
    const num_tally &t = num_counts;
    count_part part;
    part.multiplications = t.multiplications;
    part.additions = t.additions;
    part.divisions = t.divisions;
    part.comparisons = t.comparisons;
    part.idle = t.idle;
    part.level = t.level;
    for (size_t k = 0; k < t.level.size(); k++)
        if (t.level[k])
            part.depth = (uint32_t)k;
    part.level.resize(part.depth + 1);
    return part;
}

template <typename F> count_part during(F run)
{
    num_forget();
    run();
    return take();
}

} // namespace

struct count_robot::body {
    tfa_model *model = nullptr;
    tfa_workspace *workspace = nullptr;
    void *memory = nullptr;
    state *s = nullptr;
    tfa_request request = {};
    std::vector<double> q, v, tau, eta, rates;

    /* As the library does it (answer_forward.c), one half at a time */
    int factor(count_method method)
    {
        return TFA_V(factor)(s, (tfa_method)method);
    }

    void solve(count_method method)
    {
        if (method == TFA_METHOD_ABA) {
            TFA_V(aba)(s, s->tau, s->qdd);
        } else if (method == TFA_METHOD_CRBA) {
            const uint32_t n = s->m->freedoms;
            for (uint32_t j = 0; j < n; j++)
                s->dx[j] = 0;
            TFA_V(rnea)(s, s->dx, s->res, 1);
            for (uint32_t j = 0; j < n; j++)
                s->qdd[j] = s->tau[j] - s->res[j];
            TFA_V(ltdl_solve)(s, s->qdd);
        } else {
            TFA_V(chain_solve)(s, TFA_V(method)((tfa_method)method)->chain, s->tau, s->qdd, 1);
        }
    }

    void halves(count_method method, count_parts &parts)
    {
        parts.factor = during([&] { (void)factor(method); });
        parts.solve = during([&] { solve(method); });
        parts.refine = during([&] { (void)TFA_V(refine)(s, (tfa_method)method, 1, 0, 0); });
    }

    /* ABA's two halves go through the bodies together. */
    void dynamics(count_method method)
    {
        s->have = HAVE_POSE;
        if (method == COUNT_SCAN_TREE) {
            scan_tree(s, &model->chain[0], s->rows, s->tau, s->qdd);
            return;
        }
        if (method != TFA_METHOD_ABA)
            (void)factor(method);
        solve(method);
    }
};

count_robot::count_robot(unsigned joints, bool moving, unsigned modes) : m_(new body)
{
    chain_maker maker(joints, modes);
    body &b = *m_;
    b.model = maker.compile();
    if (!b.model || tfa_workspace_create(b.model, nullptr, &b.workspace) != TFA_OK)
        std::abort();
    const size_t bytes = tfa_kernel_count_base.size(b.model, {TFA_METHODS_ALL, TFA_DEFAULT_TIPS});
    b.memory = std::aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!b.memory)
        std::abort();
    b.s = tfa_kernel_count_base.init(b.model, {TFA_METHODS_ALL, TFA_DEFAULT_TIPS}, b.memory);
    b.s->in_segments = 0; /* cyclic reduction over the rows of all bodies, as in the paper */
    for (unsigned k = 0; k < joints; k++) {
        b.q.push_back(maker.uniform());
        b.v.push_back(maker.uniform());
        b.tau.push_back(maker.uniform());
    }
    for (uint32_t k = 0; k < tfa_model_mode_count(b.model); k++) {
        b.eta.push_back(0.1 * maker.uniform());
        b.rates.push_back(maker.uniform());
    }
    b.request.modes = b.eta.data();
    b.request.mode_velocities = moving ? b.rates.data() : nullptr;
    b.request.op = TFA_OP_FORWARD_DYNAMICS;
    b.request.count = 1;
    b.request.estimate = TFA_ESTIMATE_NEVER;
    b.request.q = b.q.data();
    b.request.v = moving ? b.v.data() : nullptr;
    b.request.tau = b.tau.data();
}

count_robot::~count_robot()
{
    std::free(m_->memory);
    tfa_workspace_free(m_->workspace);
    tfa_model_free(m_->model);
}

int count_robot::measure(count_method method, count_parts &parts)
{
    body &b = *m_;
    state *s = b.s;
    TFA_V(load)(s, &b.request, 0, 1);
    s->have = HAVE_POSE;
    const bool whole = method == COUNT_SCAN_TREE;
    const int status = whole ? TFA_OK : b.factor(method);
    if (status != TFA_OK)
        return status;
    s->have = 0;
    parts.pose = during([&] { TFA_V(pose)(s); });
    parts.velocity = during([&] { TFA_V(velocity)(s); });
    if (!whole)
        b.halves(method, parts);
    parts.dynamics = during([&] { b.dynamics(method); });
    s->have = 0;
    parts.all = during([&] {
        TFA_V(pose)(s);
        TFA_V(velocity)(s);
        b.dynamics(method);
    });
    return TFA_OK;
}

int count_robot::counted(count_method method, double *qdd)
{
    body &b = *m_;
    tfa_reply reply = {};
    tfa_answer answer = {};
    reply.qdd = qdd;
    b.request.method = (tfa_method)method;
    if (method == COUNT_SCAN_TREE) {
        TFA_V(load)(b.s, &b.request, 0, 1);
        b.dynamics(method);
        return TFA_V(unload)(b.s, b.s->qdd, nullptr, qdd) ? TFA_OK : TFA_E_NOT_COMPUTED;
    }
    return tfa_kernel_count_base.answer(b.s, &b.request, {b.request.method, b.request.method}, 0, 1,
                                        &reply, &answer);
}

int count_robot::plain(count_method method, double *qdd)
{
    tfa_reply reply = {};
    reply.qdd = qdd;
    m_->request.method = method == COUNT_SCAN_TREE ? TFA_METHOD_SCAN : (tfa_method)method;
    return tfa_compute(m_->workspace, &m_->request, &reply);
}

const char *count_method_name(count_method method)
{
    return method == COUNT_SCAN_TREE ? "scan-tree" : tfa_method_name(method);
}

uint64_t count_work(const count_part &part)
{
    return part.multiplications + part.additions + part.divisions + part.comparisons;
}

uint64_t count_schedule(const count_part &part, uint64_t processors)
{
    uint64_t time = 0;
    for (uint64_t operations : part.level)
        time += (operations + processors - 1) / processors;
    return time;
}

uint64_t count_bound(const count_part &part, uint64_t processors)
{
    const uint64_t share = (count_work(part) + processors - 1) / processors;
    return share > part.depth ? share : part.depth;
}
