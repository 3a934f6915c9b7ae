/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the parts of the benchmark suite share: libraries, robots, tasks, contestants. Grouped by
 * the file that defines it.
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
    X(tfa_batch_pool_create)                                                                       \
    X(tfa_batch_pool_free)                                                                         \
    X(tfa_compute)                                                                                 \
    X(tfa_batch_pool_compute)                                                                      \
    X(tfa_isa_name)                                                                                \
    X(tfa_method_name)                                                                             \
    X(tfa_report_free)

/* What a former build may lack: NULL then. */
#define SUITE_LATER_CALLS(X)                                                                       \
    X(tfa_model_find_frame)                                                                        \
    X(tfa_model_name)                                                                              \
    X(tfa_model_size)                                                                              \
    X(tfa_workspace_size)                                                                          \
    X(tfa_status_text)                                                                             \
    X(tfa_specialised_name)                                                                        \
    X(tfa_specialised_build)                                                                       \
    X(tfa_specialised_load)                                                                        \
    X(tfa_specialised_describe)                                                                    \
    X(tfa_specialised_free)

struct library {
    const char *name; /* "now", "own" (with the robot's specialised kernel), "former" */
    void *handle;
    /* the robot's specialised kernel for its workspaces; NULL: none */
    const tfa_specialised *specialised;
#define SUITE_MEMBER(call) __typeof__(&call) call;
    SUITE_CALLS(SUITE_MEMBER)
    SUITE_LATER_CALLS(SUITE_MEMBER)
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
    int hands;   /* it is the bundled humanoid, for which there are scenes */
    tfa_description *description;
    uint32_t tips[TFA_MAX_TIPS]; /* ends of branches, spread evenly; so many asked for */
};

/* The robot of a file, or one that is written for the occasion: humanoid30, humanoid58 (with
 * hands), chainN of N random rods. @return 0, or -1 after a message */
int robot_open(struct robot *r, const struct library *l, const char *name, tfa_base base);
void robot_close(struct robot *r, const struct library *l);
/* Its tips for a request of so many: ends of branches. */
void robot_tips(struct robot *r, uint32_t count);
/* The link behind the most joints, the last of several */
uint32_t robot_deepest(const struct robot *r);

/* ---- tasks.c: what is asked ---- */

/* How calls follow each other */
enum how {
    HOW_WARM,    /* over and over, each with another state */
    HOW_CHAINED, /* each state from the answer before it */
    HOW_COLD,    /* after all caches were used for something else */
    HOW_SAME_Q,  /* warm, and the same q in every call */
    /* no request: */
    HOW_PARSE,     /* URDF text to a description */
    HOW_COMPILE,   /* a description to a model */
    HOW_WORKSPACE, /* a model to a workspace */
    HOW_BYTES      /* no time: sizes */
};

/* With a payload, a gravity, or a wrench, of the request */
enum given { NOTHING, A_PAYLOAD, A_GRAVITY, A_WRENCH };

/* The bundled humanoid: its hands locked; one arm as tip, its hand locked. The tip is its left
 * palm. */
enum scene { ANY_ROBOT, SCENE_WHOLE, SCENE_HANDS, SCENE_ARM };
#define SUITE_PALM "left_palm"

struct task {
    const char *name, *text;
    tfa_op op;
    tfa_method method;
    tfa_estimate estimate;
    uint32_t refine, tips, flags, states, threads;
    tfa_precision precision;
    tfa_residual residual;
    enum how how;
    enum given given;
    enum scene scene;
    int one_by_one;  /* a batch without lanes */
    int deepest_tip; /* the tip is the link behind the most joints */
    size_t (*bytes)(const struct library *l, const tfa_description *d, const tfa_model_options *o,
                    const tfa_model *m);
    uint32_t fewest; /* of chains with so many joints only; 0: of all robots */
    uint32_t most;   /* joints; 0: any */
};

extern const struct task suite_tasks[]; /* ends with a name that is NULL */
const tfa_scene *suite_scene(enum scene scene);
int suite_is_for(const struct task *t, const struct robot *r);

/* ---- cpus.c: where threads run ---- */

/* Pins this thread to the last processor that it may use. */
void cpus_pin(void);
/* So many processors for a pool, the caller's first; NULL: there are not so many */
const int *cpus_for(uint32_t threads);

/* ---- contest.c: who answers, and what ---- */

enum { SUITE_STATES = 16, SUITE_CONTESTANTS = 8 };

/* One who answers a task for a robot: a library, or a peer */
struct contestant {
    const char *name;
    const struct library *library; /* NULL: a peer */
    const struct peer *peer;
    const struct peer_lambda *peers_lambda; /* of a task with a tip */
    void *peers_robot;
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_batch_pool *pool;
};

/* A task for a robot: its inputs, and all that answer */
struct contest {
    const struct task *task;
    struct robot *robot;
    struct contestant contestant[SUITE_CONTESTANTS];
    uint32_t count, next; /* contestants; the state that is asked next */
    uint32_t nq, nv;
    tfa_request request;
    tfa_reply reply;
    double *block, *q, *v, *tau, *pose, *twist, *wrench, *out;
    size_t answers; /* numbers in `out` */
};

/* Contestants that cannot answer are not among `who`. @return 0, or -1: nothing is left to close */
int contest_open(struct contest *c, const struct task *task, struct robot *robot,
                 const struct library *libraries, uint32_t count);
void contest_close(struct contest *c);
/* One call of one contestant. @return 1: it was answered */
int contest_call(struct contest *c, uint32_t contestant);
/* The method that answered, of a library; NULL of a peer */
const char *contest_method(struct contest *c, uint32_t contestant);
/* |answer - answer of the first| / |answer of the first| for one call */
double contest_difference(struct contest *c, uint32_t contestant);
/* The same against quadruple precision by the plainest method, the largest of all states; NAN of
 * batches */
double contest_error(struct contest *c, uint32_t contestant);
/* Of a task that measures sizes */
size_t contest_bytes(struct contest *c, uint32_t contestant);

/* ---- kernel.c: a robot's specialised kernel ---- */

struct kernel {
    char path[4096], compiler[256];
    tfa_specialised *loaded;
    double compile_s, compilers_s; /* 0: it was there; wall clock, processors' time */
    double load_ms, error;         /* median of loads, with its tests; they found */
    size_t text;                   /* bytes that are executed */
};

/* Builds it in that folder where it is not yet, and loads it. @return 0, or -1 after a message */
int kernel_open(struct kernel *k, const struct library *l, const struct robot *r,
                const char *folder, const char *compiler);
void kernel_close(struct kernel *k, const struct library *l);

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
                         struct figures figures[SUITE_CONTESTANTS]);

#endif
