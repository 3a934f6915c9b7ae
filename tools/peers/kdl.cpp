// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The totalforce authors
//
// Orocos KDL as a peer: its recursive Newton-Euler forward dynamics of a chain.
#include <cstdio>
#include <kdl/chain.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>

#include "peer.h"

namespace
{

struct Robot {
    KDL::Chain chain;
    KDL::ChainFdSolver_RNE *solver = nullptr;
    KDL::JntArray q, v, tau, qdd;
    KDL::Wrenches wrenches;
    ~Robot()
    {
        delete solver;
    }
};

KDL::Frame frame(const double xyz[3], const double quat[4])
{
    return KDL::Frame(KDL::Rotation::Quaternion(quat[0], quat[1], quat[2], quat[3]),
                      KDL::Vector(xyz[0], xyz[1], xyz[2]));
}

KDL::RigidBodyInertia inertia(const tfa_link &l)
{
    const double *s = l.inertia;
    KDL::Frame f = frame(l.com, l.quat);
    KDL::RigidBodyInertia about_com(l.mass, KDL::Vector::Zero(),
                                    KDL::RotationalInertia(s[0], s[3], s[5], s[1], s[2], s[4]));
    return f * about_com;
}

// Chains only: each joint hangs from the child of the one before.
void *make(const char *, const tfa_description *d, char *why, size_t size)
{
    Robot *r = new Robot;
    size_t moving = 0;
    for (size_t j = 0; j < d->joint_count; j++) {
        const tfa_joint &joint = d->joints[j];
        bool chain = j == 0 || joint.parent == d->joints[j - 1].child;
        bool simple = joint.type == TFA_JOINT_REVOLUTE || joint.type == TFA_JOINT_CONTINUOUS ||
                      joint.type == TFA_JOINT_FIXED;
        if (!chain || !simple) {
            std::snprintf(why, size, "%s: %s", joint.name,
                          chain ? "neither revolute nor fixed" : "not a chain");
            delete r;
            return nullptr;
        }
        KDL::Frame origin = frame(joint.xyz, joint.quat);
        KDL::Vector axis(joint.axis[0], joint.axis[1], joint.axis[2]);
        KDL::Joint::JointType none = KDL::Joint::Fixed;
        KDL::Joint kj =
            joint.type == TFA_JOINT_FIXED
                ? KDL::Joint(joint.name, none)
                : KDL::Joint(joint.name, origin.p, origin.M * axis, KDL::Joint::RotAxis);
        r->chain.addSegment(
            KDL::Segment(d->links[joint.child].name, kj, origin, inertia(d->links[joint.child])));
        moving += joint.type != TFA_JOINT_FIXED;
    }
    r->solver = new KDL::ChainFdSolver_RNE(r->chain, KDL::Vector(0, 0, -9.80665));
    unsigned n = static_cast<unsigned>(moving);
    r->q.resize(n);
    r->v.resize(n);
    r->tau.resize(n);
    r->qdd.resize(n);
    r->wrenches.assign(r->chain.getNrOfSegments(), KDL::Wrench::Zero());
    return r;
}

void forward(void *robot, const double *q, const double *v, const double *tau, double *qdd)
{
    Robot *r = static_cast<Robot *>(robot);
    const unsigned n = r->q.rows();
    for (unsigned k = 0; k < n; k++) {
        r->q(k) = q[k];
        r->v(k) = v[k];
        r->tau(k) = tau[k];
    }
    r->solver->CartToJnt(r->q, r->v, r->tau, r->wrenches, r->qdd);
    for (unsigned k = 0; k < n; k++)
        qdd[k] = r->qdd(k);
}

void release(void *robot)
{
    delete static_cast<Robot *>(robot);
}

} // namespace

extern "C" const struct peer peer_kdl = {"kdl", make, forward, release};
