/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the parts of the benchmark suite share: libraries, robots, tasks, contestants. Grouped by the
 * file that defines it.
 */
#ifndef TFA_BENCH_SUITE_H
#define TFA_BENCH_SUITE_H

#include "peer.h"

#include <totalforce/totalforce.h>

/* ---- library.c: a build of libtotalforce, opened beside others ---- */

/* What is called of it; tfa_request and what else goes over may have grown at their ends. */
#define SUITE_CALLS(X)                                                                             \
    X(tfa_urdf_load)                                                                               \
    X(tfa_description_free)                                                                        \
    X(tfa_model_create)                                                                            \
    X(tfa_model_free)                                                                              \
    X(tfa_model_q_count)                                                                           \
    X(tfa_model_v_count)                                                                           \
    X(tfa_model_frame_count)                                                                       \
    X(tfa_workspace_create)                                                                        \
    X(tfa_workspace_free)                                                                          \
    X(tfa_pool_create)                                                                             \
    X(tfa_pool_free)                                                                               \
    X(tfa_compute)                                                                                 \
    X(tfa_pool_compute)                                                                            \
    X(tfa_isa_name)                                                                                \
    X(tfa_method_name)                                                                             \
    X(tfa_report_free)

struct library {
    const char *name; /* "now", "former" */
    void *handle;
    const tfa_specialised *specialised; /* the robot's own kernel for its workspaces; NULL: none */
#define SUITE_MEMBER(call) __typeof__(&call) call;
    SUITE_CALLS(SUITE_MEMBER)
#undef SUITE_MEMBER
};

/* @return 0, or -1 after a message */
int library_open(struct library *l, const char *name, const char *path);

/* ---- robots.c: what is solved ---- */

struct robot {
    char name[48], path[4096];
    tfa_base base;
    double snap; /* as in tfa_model_options */
    uint32_t joints;
    int chain;   /* every joint hangs from the one before */
    int written; /* the file is to be removed */
    tfa_description *description;
    uint32_t tips[TFA_MAX_TIPS]; /* ends of branches, spread evenly; so many asked for */
};

/* X(name, bodies): written for the occasion; `bodies` of a chain, or those of a tree with hands. */
#define SUITE_MADE(X)                                                                              \
    X("humanoid30", 30)                                                                            \
    X("humanoid58", 58)                                                                            \
    X("chain64", 64) X("chain256", 256) X("chain1000", 1000) X("chain4096", 4096)

/* The robot of a file, or a made one of that name. @return 0, or -1 after a message */
int robot_open(struct robot *r, const struct library *l, const char *name, tfa_base base);
void robot_close(struct robot *r, const struct library *l);
/* Its tips for a request of so many. */
void robot_tips(struct robot *r, uint32_t count);
/* The link behind the most joints, the last of several */
uint32_t robot_deepest(const struct robot *r);

/* ---- tasks.c: what is asked ---- */

/* How calls follow each other */
enum how {
    HOW_WARM,    /* over and over, each with another state */
    HOW_CHAINED, /* each state from the answer before it */
    HOW_COLD,    /* after all caches were used for something else */
};

struct task {
    const char *name;
    tfa_op op;
    tfa_method method;
    tfa_estimate estimate;
    uint32_t refine, tips, states, threads;
    tfa_precision precision;
    enum how how;
    uint32_t fewest; /* of chains with so many joints only; 0: of all robots */
    uint32_t most;   /* joints; 0: any */
};

extern const struct task suite_tasks[]; /* ends with a name that is NULL */

/* ---- cpus.c: where threads run ---- */

/* Pins this thread to the last processor that it may use. */
void cpus_pin(void);
/* So many processors for a pool, the caller's first; NULL: there are not so many */
const int *cpus_for(uint32_t threads);

/* ---- contest.c: who answers, and what ---- */

enum { SUITE_STATES = 16, SUITE_WHO = 8 };

/* One who answers a task for a robot: a library, or a peer */
struct contestant {
    const char *name;
    const struct library *library; /* NULL: a peer */
    const struct peer *peer;
    void *peers_robot;
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_pool *pool;
};

/* A task for a robot: its inputs, and all that answer */
struct contest {
    const struct task *task;
    struct robot *robot;
    struct contestant who[SUITE_WHO];
    uint32_t count, next; /* contestants; the state that is asked next */
    uint32_t nq, nv;
    tfa_request request;
    tfa_reply reply;
    double *block, *q, *v, *tau, *pose, *twist, *out;
    size_t answers; /* numbers in `out` */
};

/* Contestants that cannot answer are not among `who`. @return 0, or -1: nothing is left to close */
int contest_open(struct contest *c, const struct task *task, struct robot *robot,
                 const struct library *libraries, uint32_t count);
void contest_close(struct contest *c);
/* One call of one contestant. @return 1: it was answered */
int contest_ask(struct contest *c, uint32_t who);
/* The method that answered, of a library; NULL of a peer */
const char *contest_method(struct contest *c, uint32_t who);
/* |answer - answer of the first| / |answer of the first| for one call */
double contest_difference(struct contest *c, uint32_t who);

/* ---- flush.c: cold calls ---- */

/* Afterwards no cache holds data or code of this process, but what this takes to return. */
void flush_all(void);

/* ---- turns.c: time ---- */

struct figures {
    double median, least; /* ns for one state */
    double times;         /* median of this one's time over the first one's, turn by turn */
};

/* All contestants in turns. @return turns that were taken, 0: none */
uint32_t contest_measure(struct contest *c, double turn_us, uint32_t rounds,
                         struct figures figures[SUITE_WHO]);

#endif
