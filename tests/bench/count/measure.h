/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations and dependency chains of the methods on a chain of revolute joints.
 */
#ifndef TFA_COUNT_MEASURE_H
#define TFA_COUNT_MEASURE_H

#include <cstdint>
#include <memory>
#include <totalforce/totalforce.h>
#include <vector>

/* A tfa_method, or the segment scan with joins by a tree (scan_tree.h): dynamics and all only */
using count_method = uint32_t;
constexpr count_method COUNT_SCAN_TREE = 100;

const char *count_method_name(count_method method);

/* What one stretch of a computation took; sines are not counted. */
struct count_part {
    uint64_t multiplications = 0, additions = 0, divisions = 0, comparisons = 0;
    uint64_t idle = 0;  /* of these, x * 0, x * +-1 and x + 0 */
    uint32_t depth = 0; /* length of the longest dependency chain */
    /* operations that can be done at time 1, 2, ..., depth; [0] is 0 */
    std::vector<uint64_t> level;
};

struct count_parts {
    count_part pose;     /* X_i = Z(q_i) T_i */
    count_part velocity; /* v_i, c_i, p_i; nothing at rest */
    count_part factor;   /* depends on q only */
    count_part solve;    /* qdd from tau with kept factors, bias included */
    count_part refine;   /* one step: residual, solve again, correct, and its estimate */
    count_part dynamics; /* factor and solve, pose and velocity given */
    count_part all;      /* pose, velocity, factor and solve */
};

/* A fixed base and `joints` revolute joints; every number of every link and joint is random, so
 * that what is zero is zero by structure. No two axes are nearly parallel, so that every frame is
 * one of Denavit and Hartenberg, as in the literature's counts. */
class count_robot
{
  public:
    count_robot(unsigned joints, bool moving, unsigned modes = 0); /* of each link */
    ~count_robot();

    /* Status of the method: parts are good with TFA_OK only. */
    int measure(count_method method, count_parts &parts);
    /* Accelerations without refinement: by the numbers that count, and by the library's double
     * (for COUNT_SCAN_TREE those of the library's scan). */
    int counted(count_method method, double *qdd);
    int plain(count_method method, double *qdd);

  private:
    struct body;
    std::unique_ptr<body> m_;
};

/* Time on so many processors when all of a level is done before the next begins: no schedule takes
 * less than count_bound(), and this one takes less than work / processors + depth. */
uint64_t count_schedule(const count_part &part, uint64_t processors);
uint64_t count_bound(const count_part &part, uint64_t processors);
uint64_t count_work(const count_part &part);

#endif
