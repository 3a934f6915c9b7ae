/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The peers of the chart: made from the same file as the model, asked for the same states.
 */
#include "chart.h"
#include "peer.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct chart_peer {
    const struct peer *choice; /* NULL behind the last */
    uint32_t method;
    void *robot;
    char why[64]; /* it is not there */
};

/* The file the peers read, and whether it is to be removed. */
typedef struct source {
    char path[4096];
    int written;
} source;

static int write_mechanism(source *s, const mechanism_options *mechanism)
{
    const char *folder = getenv("TMPDIR");
    snprintf(s->path, sizeof s->path, "%s/totalforce-XXXXXX.urdf", folder ? folder : "/tmp");
    const int file = mkstemps(s->path, (int)strlen(".urdf"));
    FILE *out = file >= 0 ? fdopen(file, "w") : NULL;
    if (!out) {
        fprintf(stderr, "totalforce chart: %s: %s\n", s->path, strerror(errno));
        return TFA_E_FILE;
    }
    s->written = 1;
    mechanism_write(mechanism, out);
    const int broken = ferror(out);
    return fclose(out) != 0 || broken ? TFA_E_FILE : TFA_OK;
}

/* A peer takes one number for each joint of the description, in that order: so must the model. */
static int same_joints(const tfa_model *model, const tfa_description *description)
{
    uint32_t k = 0;
    for (size_t j = 0; j < description->joint_count; j++) {
        if (description->joints[j].type == TFA_JOINT_FIXED)
            continue;
        if (k == tfa_model_joint_count(model))
            return 0;
        const tfa_joint_info ours = tfa_model_joint(model, k);
        if (ours.q_index != k || ours.q_count != 1 ||
            strcmp(ours.name, description->joints[j].name) != 0)
            return 0;
        k++;
    }
    return k == tfa_model_joint_count(model);
}

/* One word of CSV. */
static void clean_text(char *text)
{
    for (char *at = text; *at; at++)
        if (*at == ',' || *at == '"' || (unsigned char)*at < ' ')
            *at = ' ';
}

static void make(chart_peer *p, const chart_case *c, const char *path,
                 const tfa_description *description)
{
    char why[sizeof p->why] = "";
    if (c->threads > 1 || tfa_model_base_freedoms(c->model) > 0)
        snprintf(p->why, sizeof p->why, "%s", c->threads > 1 ? "one thread" : "fixed base");
    else if (c->bodies > PEER_BODIES_MAX)
        snprintf(p->why, sizeof p->why, "more than %d bodies", PEER_BODIES_MAX);
    else if (!same_joints(c->model, description))
        snprintf(p->why, sizeof p->why, "joints other than revolute and prismatic");
    else
        p->robot = p->choice->make(path, description, why, sizeof why);
    if (why[0])
        memcpy(p->why, why, sizeof why);
    clean_text(p->why);
}

static int make_all(chart_case *c, const char *path)
{
    tfa_report report = {0};
    tfa_description *description = NULL;
    const int status = tfa_urdf_load(path, &description, &report);
    for (chart_peer *p = c->peers; status == TFA_OK && p->choice; p++)
        make(p, c, path, description);
    tfa_description_free(description);
    tfa_report_free(&report);
    return status;
}

int chart_peers_open(chart_case *c, const chart_options *options, const char *file,
                     const mechanism_options *mechanism)
{
    source s = {0};
    uint32_t count = 0;
    c->peers = calloc(options->method_count + 1, sizeof *c->peers);
    if (!c->peers)
        return TFA_E_MEMORY;
    for (uint32_t m = 0; m < options->method_count; m++)
        if (options->methods[m] >= CHART_PEER)
            c->peers[count++] = (chart_peer){.choice = peer_table[options->methods[m] - CHART_PEER],
                                             .method = options->methods[m]};
    if (count == 0)
        return TFA_OK;
    int status = file ? TFA_OK : write_mechanism(&s, mechanism);
    if (status == TFA_OK)
        status = make_all(c, file ? file : s.path);
    if (s.written)
        unlink(s.path);
    return status;
}

void chart_peers_close(chart_peer *peers)
{
    for (chart_peer *p = peers; p && p->choice; p++)
        if (p->robot)
            p->choice->release(p->robot);
    free(peers);
}

static const chart_peer *find(const chart_case *c, uint32_t method)
{
    const chart_peer *p = c->peers;
    while (p->method != method)
        p++;
    return p;
}

const char *chart_peer_refusal(const chart_case *c, uint32_t method, char *about, size_t size)
{
    const chart_peer *p = find(c, method);
    snprintf(about, size, "%s", p->why);
    if (p->robot)
        return NULL;
    return c->bodies > PEER_BODIES_MAX ? "too_large" : "refused";
}

void chart_peer_answer(const chart_case *c, uint32_t method, const chart_data *d, uint32_t state)
{
    const chart_peer *p = find(c, method);
    const size_t at = (size_t)state * d->v;
    const struct peer_lambda *row = peer_lambda_table;
    while (row->peer && row->peer != p->choice)
        row++;
    if (d->op == CHART_LAMBDA && row->peer) {
        const char *link = tfa_model_frame(c->model, d->tip).name;
        if (row->lambda(p->robot, d->coordinates + at, link, d->found) != 0)
            d->found[0] = NAN; /* no such link: an error that is not finite */
        return;
    }
    p->choice->forward(p->robot, d->coordinates + at, d->velocity + at, d->tau + at, d->found);
}
