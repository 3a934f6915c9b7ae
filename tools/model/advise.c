/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the states of a robot and asks the library which joints a scene may lock in them.
 */
#include "advise.h"

#include "common/commands.h"
#include "jsonl/jsonl_serve.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/advise.h>
#include <unistd.h>

/* ---- states ---- */

enum { Q, V, TAU, POSE, TWIST, WRENCH, ARRAYS }; /* of a request */

typedef struct states {
    tfa_names names;
    size_t width[ARRAYS];
    double *array[ARRAYS];
    uint32_t count;
    int other; /* a line is more than a state */
} states;

static int prepare(void *self, const tfa_names **names, jsonl_error *error)
{
    (void)error;
    *names = &((states *)self)->names;
    return TFA_OK;
}

/* Keeps the state of a line. Absent arrays are 0. */
static int store_state(void *self, const tfa_request *r, tfa_reply *reply)
{
    states *s = self;
    const double *from[ARRAYS] = {r->q, r->v, r->tau, r->base_pose, r->base_twist, r->base_wrench};
    s->other |= r->op != TFA_OP_FORWARD_DYNAMICS || r->gravity || r->tip_count || r->wrench_count ||
                r->payload_count || r->locked_count;
    for (int k = 0; k < ARRAYS; k++) {
        const size_t at = s->count * s->width[k], bytes = s->width[k] * sizeof(double);
        double *grown = realloc(s->array[k], at * sizeof(double) + bytes + 1);
        if (!grown)
            return reply->status = TFA_E_MEMORY;
        s->array[k] = grown;
        memset(grown + at, 0, bytes);
        if (from[k])
            memcpy(grown + at, from[k], bytes);
    }
    s->count++;
    return reply->status = TFA_OK;
}

/* The replies that are errors, on standard error */
static void print_refusals(char *replies)
{
    for (char *end, *line = replies; (end = strchr(line, '\n')); line = end + 1) {
        *end = '\0';
        if (strstr(line, "\"status\":\"error\""))
            fprintf(stderr, "totalforce model: --advise: %s\n", line);
    }
}

/* @return 0 after an error message */
static int read_states(states *s, const char *path)
{
    const jsonl_defaults defaults = JSONL_DEFAULTS;
    const jsonl_backend peer = {.self = s, .prepare = prepare, .answer = store_state};
    const int input = strcmp(path, "-") == 0 ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    char *replies = NULL;
    size_t size = 0;
    jsonl_tally tally = {0};
    FILE *out = input < 0 ? NULL : open_memstream(&replies, &size);
    int status = out ? jsonl_serve(input, out, &peer, &defaults, &tally) : TFA_E_SYSTEM;
    if (status != TFA_OK)
        fprintf(stderr, "totalforce model: --advise %s: %s\n", path,
                status == TFA_E_SYSTEM ? strerror(errno) : tfa_status_text(status));
    if (out)
        fclose(out);
    if (replies)
        print_refusals(replies);
    free(replies);
    if (input > STDIN_FILENO)
        close(input);
    if (s->other)
        fprintf(stderr,
                "totalforce model: --advise %s: a state is forward_dynamics with q, v, "
                "tau, base_pose, base_twist and base_wrench; inputs that all states share are an "
                "option: --gravity, --payload, --lock\n",
                path);
    else if (status == TFA_OK && tally.lines == 0)
        fprintf(stderr, "totalforce model: --advise %s: no state in it; give one line or more\n",
                path);
    return status == TFA_OK && s->count > 0 && tally.errors == 0 && !s->other;
}

/* ---- advice ---- */

/* Adds the advised locks to those of the command line. @return TFA_OK, TFA_E_MEMORY */
static int add_advised_locks(scene_options *o, const tfa_model *model, const tfa_advice *advice)
{
    for (uint32_t k = 0; k < advice->count; k++) {
        const tfa_joint_info joint = tfa_model_joint(model, advice->joints[k]);
        scene_lock lock = {.lock.joint = joint.name, .numbers = joint.q_count};
        memcpy(lock.lock.q, advice->q + joint.q_index, joint.q_count * sizeof *lock.lock.q);
        if (scene_options_lock(o, &lock) != TFA_OK)
            return TFA_E_MEMORY;
    }
    scene_options_finish(o);
    return TFA_OK;
}

static int print_advice(const tfa_model *model, const char *urdf, scene_options *o,
                        const tfa_advice *advice, uint32_t count, double tolerance)
{
    tfa_report report = {0};
    tfa_model *scene = NULL;
    int printed = 0;
    if (add_advised_locks(o, model, advice) != TFA_OK)
        fprintf(stderr, "totalforce model: %s\n", tfa_status_text(TFA_E_MEMORY));
    else
        scene = load_scene(urdf, o, TFA_ERROR, &report);
    if (scene) {
        advise_print(model, scene, advice, count, tolerance);
        printed = advise_print_robot(model, urdf, o, advice);
    }
    if (scene && !printed)
        perror("totalforce model: standard output");
    else if (scene && advice->count == 0)
        fprintf(stderr, "totalforce model: --tolerance %g: no joint may be locked\n", tolerance);
    tfa_report_free(&report);
    tfa_model_free(scene);
    return !printed ? EXIT_FAILED : advice->count ? EXIT_GOOD : EXIT_UNMET;
}

/* Of the state that was refused, by itself */
static void explain(const states *s, tfa_request r, tfa_reply reply, char *text, size_t size)
{
    const double **const arrays[ARRAYS] = {&r.q,         &r.v,          &r.tau,
                                           &r.base_pose, &r.base_twist, &r.base_wrench};
    for (int k = 0; k < ARRAYS; k++)
        *arrays[k] += *arrays[k] ? s->width[k] * reply.state : 0;
    r.count = 1;
    reply.state = 0;
    (void)tfa_explain(&s->names, &r, &reply, TFA_SYNTAX_JSON, text, size);
}

static int advise(const states *s, const tfa_model *model, const char *urdf, scene_options *o,
                  double tolerance)
{
    const int base = s->names.base_freedoms != 0;
    const tfa_request r = {.count = s->count,
                           .q = s->array[Q],
                           .v = s->array[V],
                           .tau = s->array[TAU],
                           .base_pose = base ? s->array[POSE] : NULL,
                           .base_twist = base ? s->array[TWIST] : NULL,
                           .base_wrench = base ? s->array[WRENCH] : NULL};
    tfa_advice advice = {0};
    tfa_reply reply;
    char text[1024];
    const int status = tfa_advise(model, &r, tolerance, &advice, &reply);
    if (status != TFA_OK) {
        explain(s, r, reply, text, sizeof text);
        fprintf(stderr, "totalforce model: --advise: state %u: %s\n", reply.state + 1, text);
        return EXIT_FAILED;
    }
    const int result = print_advice(model, urdf, o, &advice, s->count, tolerance);
    tfa_advice_free(&advice);
    return result;
}

int advise_locks(const tfa_model *model, const char *urdf, scene_options *options, const char *path,
                 double tolerance)
{
    states s = {0};
    int result = EXIT_FAILED;
    if (tfa_model_mode_count(model)) {
        fprintf(stderr, "totalforce model: --advise: not for flexible links; leave out --modes\n");
        return EXIT_FAILED;
    }
    if (options->constraints_count) {
        fprintf(stderr, "totalforce model: --advise: leave out --constraints, and add them to the "
                        "advised scene\n");
        return EXIT_FAILED;
    }
    if (tfa_names_of_model(&s.names, model) != TFA_OK) {
        fprintf(stderr, "totalforce model: %s\n", tfa_status_text(TFA_E_MEMORY));
        return EXIT_FAILED;
    }
    const size_t base = s.names.base_freedoms ? 1 : 0;
    const size_t width[ARRAYS] = {s.names.q_count, s.names.v_count, s.names.v_count,
                                  7 * base,        6 * base,        6 * base};
    memcpy(s.width, width, sizeof width);
    if (read_states(&s, path))
        result = advise(&s, model, urdf, options, tolerance);
    for (int k = 0; k < ARRAYS; k++)
        free(s.array[k]);
    tfa_names_free(&s.names);
    return result;
}
