/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Time of one state of each kind of request beside the bound by which the daemon admits a kind that
 * it has not measured (service/worker/cost.h). Least of five calls, each at another q; generic
 * kernels.
 *
 *   bench_state_costs [--all|--loaded] URDF|chainN fixed|floating ...
 *
 * Prints for each op and method the least and the largest bound over time; --all: every kind, as
 * robot,op,method,tips,flags,estimate,refine,rows,ns,bound; --loaded: how many times longer a kind
 * takes with a load of 1e9 kg, which trips the sentinel, than with one of 1 kg, by default policies
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

#include "bench.h"
#include "ipc/wire.h"
#include "ipc/wire_reply.h"
#include "timing.h"
#include "worker/cost_bound.h"

#define CALLS 5
#define NUMBERS 65536 /* of an array of inputs */
#define METHODS 32
#define CHAIN "/tmp/tfa-state-costs.urdf"

static const char *const op_names[TFA_OP_LAST + 1] = {
#define OP_NAME(op, word) [op] = word,
    TFA_OP_WORDS(OP_NAME)
#undef OP_NAME
};

/* Each flag alone, none, and all that any op takes */
#define FLAGS 15
#define FLAG_SETS (FLAGS + 2)
_Static_assert(TFA_WANT_ALL == (1u << FLAGS) - 1, "one bit each");
static uint32_t flag_set(int f)
{
    return f < FLAGS    ? 1u << f
           : f == FLAGS ? 0
                        : TFA_WANT_ALL & ~(TFA_WANT_JOINT_FORCES | TFA_WANT_DELASSUS);
}

static const uint32_t tip_counts[] = {0, 1, 2, 4, 8, 32};

typedef struct subject {
    const char *name;
    tfa_model *model;
    tfa_workspace *workspace;
    tfa_wire_shape shape;
    tfa_cost_parts parts;
    void *memory; /* of replies */
} subject;

static struct {
    double least, largest;
    unsigned kinds;
} found[TFA_OP_LAST + 1][METHODS];

static double inputs[2][NUMBERS], pose[7] = {[6] = 1};
static bool all, loaded;
static struct {
    double times, ns;      /* the largest; of the kind */
    unsigned kinds, above; /* six times */
} doubted;

/* ns; -1: the request is refused */
static double measure(const subject *s, tfa_request *r)
{
    double least = -1;
    tfa_reply reply = {0};
    const tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&s->shape, r);
    if (tfa_wire_check_reply_shape(&s->shape, &shape, &reply.field) != TFA_OK)
        return -1;
    tfa_wire_reply_buffers(&s->shape, &shape, s->memory, &reply);
    for (int k = 0; k < CALLS; k++) {
        r->q = inputs[k % 2];
        const double start = cpu_ns();
        const int status = tfa_compute(s->workspace, r, &reply);
        const double ns = cpu_ns() - start;
        if (status != TFA_OK && status != TFA_E_NOT_COMPUTED)
            return -1;
        least = least < 0 || ns < least ? ns : least;
    }
    return least;
}

static double measure_loaded(const subject *s, tfa_request r, double kg)
{
    const double load[TFA_PAYLOAD_NUMBERS] = {kg, 0.1, 0,         0, 0.01 * kg,
                                              0,  0,   0.01 * kg, 0, 0.01 * kg};
    r.estimate = TFA_ESTIMATE_DEFAULT;
    r.payload_count = 1;
    r.payloads = load;
    r.payload_frames[0] = r.tip_count ? r.tips[0] : s->shape.frames - 1;
    return measure(s, &r);
}

static void compare_loads(const subject *s, const tfa_request *r)
{
    const double ns = measure_loaded(s, *r, 1), heavy = measure_loaded(s, *r, 1e9);
    if (ns < 0 || heavy < 0)
        return;
    doubted.kinds++;
    doubted.above += heavy > 6 * ns;
    if (heavy > doubted.times * ns) {
        doubted.times = heavy / ns;
        doubted.ns = ns;
    }
}

static void measure_kind(const subject *s, tfa_request *r)
{
    if (loaded) {
        compare_loads(s, r);
        return;
    }
    const uint32_t bound_ns = tfa_cost_bound(&s->parts, r);
    const double ns = bound_ns < UINT32_MAX ? measure(s, r) : -1;
    if (ns < 0)
        return;
    const double bound = bound_ns, ratio = bound / ns;
    if (all)
        printf("%s,%s,%s,%u,0x%x,%d,%d,%d,%.0f,%.0f\n", s->name, op_names[r->op],
               tfa_method_name(r->method), r->tip_count, r->flags, (int)r->estimate, (int)r->refine,
               (int)r->rows, ns, bound);
    const int op = (int)r->op, method = (int)r->method;
    if (found[op][method].kinds++ == 0)
        found[op][method].least = found[op][method].largest = ratio;
    found[op][method].least = ratio < found[op][method].least ? ratio : found[op][method].least;
    found[op][method].largest =
        ratio > found[op][method].largest ? ratio : found[op][method].largest;
}

static void measure_op(const subject *s, tfa_op op, int method)
{
    for (int f = 0; f < FLAG_SETS; f++)
        for (size_t t = 0; t < sizeof tip_counts / sizeof *tip_counts; t++)
            for (int more = 0; more < 4; more++) {
                tfa_request r = {.op = op,
                                 .method = (tfa_method)method,
                                 .count = 1,
                                 .refine = more & 1 ? 3 : TFA_REFINE_DEFAULT,
                                 .estimate = more & 2 ? TFA_ESTIMATE_ALWAYS : TFA_ESTIMATE_NEVER,
                                 .flags = flag_set(f),
                                 .tip_count = tip_counts[t],
                                 .v = inputs[0] + 1,
                                 .tau = inputs[0] + 2,
                                 .qdd = inputs[0] + 3,
                                 .task_acceleration = inputs[0] + 4};
                if (s->shape.base_freedoms) {
                    r.base_pose = pose;
                    r.base_twist = inputs[0];
                    r.base_wrench = inputs[0];
                    r.base_acceleration = inputs[0];
                }
                for (uint32_t k = 0; k < r.tip_count; k++) /* all over the robot */
                    r.tips[k] = s->shape.frames - 1 - k * s->shape.frames / r.tip_count;
                measure_kind(s, &r);
            }
}

/* A tfa_solver */
static int solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    (void)first;
    (void)count;
    return tfa_compute(self, request, reply);
}

static void open_subject(const char *file, const char *base, subject *s)
{
    const tfa_model_options options = {.base = strcmp(base, "floating") == 0 ? TFA_BASE_FLOATING
                                                                             : TFA_BASE_FIXED};
    const tfa_workspace_options workspace = {.methods = TFA_METHODS_ALL, .max_tips = TFA_MAX_TIPS};
    s->name = file;
    int links = 0, status;
    if (sscanf(file, "chain%d", &links) == 1 && chain_urdf(CHAIN, links, 1) != 0)
        exit(1);
    status = tfa_model_load(links ? CHAIN : file, &options, NULL, &s->model);
    (void)remove(CHAIN);
    if (status != TFA_OK || tfa_workspace_create(s->model, &workspace, &s->workspace) != TFA_OK) {
        fprintf(stderr, "%s: cannot be loaded\n", file);
        exit(1);
    }
    s->shape = (tfa_wire_shape){.q_count = tfa_model_q_count(s->model),
                                .v_count = tfa_model_v_count(s->model),
                                .base_freedoms = tfa_model_base_freedoms(s->model),
                                .frames = tfa_model_frame_count(s->model),
                                .modes = tfa_model_mode_count(s->model),
                                .max_batch = 1,
                                .max_tips = TFA_MAX_TIPS};
    s->memory = calloc(1, tfa_wire_reply_capacity(&s->shape));
    tfa_worker_robot robot = {.shape = s->shape, .solve = solve, .self = s->workspace};
    for (int most = 0; most < 2; most++) {
        const double start = cpu_ns();
        robot.shape.max_tips = most ? TFA_MAX_TIPS : TFA_DEFAULT_TIPS;
        if (!s->memory || tfa_cost_measure(s->model, &robot, &s->parts) != TFA_OK)
            exit(1);
        if (!all)
            printf("%s: measured in %.0f ms with %u tips\n", file, (cpu_ns() - start) / 1e6,
                   robot.shape.max_tips);
    }
}

int main(int argc, char **argv)
{
    for (int k = 0; k < NUMBERS; k++)
        for (int i = 0; i < 2; i++)
            inputs[i][k] = 2.0 * rand() / RAND_MAX - 1;
    all = argc > 1 && strcmp(argv[1], "--all") == 0;
    loaded = argc > 1 && strcmp(argv[1], "--loaded") == 0;
    for (int a = 1 + (all || loaded); a + 1 < argc; a += 2) {
        subject s;
        open_subject(argv[a], argv[a + 1], &s);
        for (int op = 1; op <= TFA_OP_LAST; op++)
            for (int method = 0; method < METHODS; method++)
                measure_op(&s, (tfa_op)op, method);
        tfa_workspace_free(s.workspace);
        tfa_model_free(s.model);
        free(s.memory);
    }
    if (loaded)
        printf("%u kinds: at most %.1f times longer (of %.0f ns), %u more than 6 times\n",
               doubted.kinds, doubted.times, doubted.ns, doubted.above);
    for (int op = 1; op <= TFA_OP_LAST && !all; op++)
        for (int method = 0; method < METHODS; method++)
            if (found[op][method].kinds)
                printf("%-28s %-14s %5u kinds, bound over time %.2f to %.2f\n", op_names[op],
                       tfa_method_name((uint32_t)method), found[op][method].kinds,
                       found[op][method].least, found[op][method].largest);
    return 0;
}
