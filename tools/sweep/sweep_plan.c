/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Turns options into a plan: rank 0 reads the robot, all ranks build the same model of it.
 */
#include "common/commands.h"
#include "common/load_model.h"
#include "sweep.h"
#include <totalforce/text.h>

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <totalforce/limits.h>
#include <totalforce/version.h>
#include <unistd.h>

static int fail(const char *about, const char *why)
{
    fprintf(stderr, "totalforce sweep: %s: %s\n", about, why);
    return EXIT_FAILED;
}

/* The robot's file, from rank 0 */
typedef struct source {
    char *text;
    size_t length;
} source;

static int share_source(source *s, const char *path, sweep_ranks *ranks)
{
    if (ranks->rank == 0)
        s->text = read_robot(path, &s->length);
    if (!ranks->agree(ranks->rank != 0 || s->text))
        return EXIT_FAILED;
    ranks->broadcast(&s->length, sizeof s->length);
    if (ranks->rank != 0)
        s->text = malloc(s->length + 1);
    if (!ranks->agree(s->text != NULL))
        return fail(path, tfa_status_text(TFA_E_MEMORY));
    ranks->broadcast(s->text, s->length);
    return EXIT_GOOD;
}

/* What must be the same on every rank, or the answers had other bits */
typedef struct build {
    uint8_t model[32];
    char isa[32], version[32];
} build;

static int same_build(const sweep_plan *plan, sweep_ranks *ranks)
{
    build mine = {0}, first;
    memcpy(mine.model, tfa_model_hash(plan->model), sizeof mine.model);
    snprintf(mine.isa, sizeof mine.isa, "%s", tfa_isa_name());
    snprintf(mine.version, sizeof mine.version, "%s", TFA_VERSION);
    first = mine;
    ranks->broadcast(&first, sizeof first);
    const int same = memcmp(&mine, &first, sizeof first) == 0;
    if (strcmp(mine.version, first.version) != 0)
        fprintf(stderr, "totalforce sweep: rank %d is version %s, rank 0 %s: install one version\n",
                ranks->rank, mine.version, first.version);
    else if (strcmp(mine.isa, first.isa) != 0)
        fprintf(stderr,
                "totalforce sweep: rank %d has the kernels %s, rank 0 %s: set TFA_ISA to one that "
                "all machines have\n",
                ranks->rank, mine.isa, first.isa);
    else if (!same)
        fprintf(stderr, "totalforce sweep: rank %d has another model than rank 0 from one file\n",
                ranks->rank);
    return ranks->agree(same) ? EXIT_GOOD : EXIT_FAILED;
}

/* Messages about the file are those of rank 0. */
static int load(sweep_plan *plan, sweep_options *o, const source *s, sweep_ranks *ranks)
{
    tfa_report report = {0};
    const tfa_severity lowest = ranks->rank == 0 ? TFA_WARNING : TFA_ERROR;
    const char *name = strcmp(o->file, "-") == 0 ? "(standard input)" : o->file;
    plan->model = load_scene_text(name, s->text, s->length, &o->scene, lowest, &report);
    tfa_report_free(&report);
    return ranks->agree(plan->model != NULL) ? same_build(plan, ranks) : EXIT_FAILED;
}

static int add_tip(sweep_plan *plan, const tfa_names *names, const char *tip)
{
    char text[500];
    const int64_t frame = tfa_names_link(names, tip);
    if (frame < 0) {
        tfa_names_unknown_link(names, tip, text, sizeof text);
        fprintf(stderr, "totalforce sweep: --tips: %s\n", text);
        return EXIT_FAILED;
    }
    if (plan->request.tip_count == TFA_MAX_TIPS)
        return fail("--tips", "more than 32 links");
    plan->request.tips[plan->request.tip_count++] = (uint32_t)frame;
    return EXIT_GOOD;
}

static int set_tips(sweep_plan *plan, const char *list)
{
    tfa_names names = {0};
    char *copy = list ? strdup(list) : NULL, *rest = copy;
    int result = EXIT_GOOD;
    if (!list)
        return EXIT_GOOD;
    if (!copy || tfa_names_of_model(&names, plan->model) != TFA_OK)
        result = fail("--tips", tfa_status_text(TFA_E_MEMORY));
    for (char *tip; result == EXIT_GOOD && (tip = strsep(&rest, ","));)
        result = add_tip(plan, &names, tip);
    tfa_names_free(&names);
    free(copy);
    return result;
}

static void set_answer(sweep_plan *plan)
{
    const uint32_t base = tfa_model_base_freedoms(plan->model);
    const uint32_t freedoms = tfa_model_v_count(plan->model);
    const uint32_t rows = 6 * plan->request.tip_count, n = base + freedoms;
    switch (plan->request.op) {
    case TFA_OP_OPERATIONAL_INERTIA:
        plan->matrix = rows * rows;
        break;
    case TFA_OP_MASS_MATRIX:
        plan->matrix = n * n;
        break;
    default:
        plan->base = base;
        plan->joint = freedoms;
    }
    plan->answer = plan->base + plan->joint + plan->matrix;
}

static int set_record(sweep_plan *plan, const source *s)
{
    const uint32_t joints = tfa_model_joint_count(plan->model);
    const char **names = calloc(joints + 1, sizeof *names);
    tfa_joint_limits *limits = calloc(joints + 1, sizeof *limits);
    int status = names && limits ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t j = 0; status == TFA_OK && j < joints; j++)
        names[j] = tfa_model_joint(plan->model, j).name;
    if (status == TFA_OK)
        status = tfa_urdf_limits(s->text, s->length, names, joints, limits);
    if (status == TFA_OK)
        status = state_record_make(&plan->record, plan->model, plan->request.op, limits,
                                   &plan->options->ranges);
    free(names);
    free(limits);
    return status == TFA_OK ? EXIT_GOOD : fail(plan->options->file, tfa_status_text(status));
}

/* Whole records, and as many as are asked for */
static int check_states_file(sweep_plan *plan, uint64_t bytes)
{
    const sweep_options *o = plan->options;
    const uint64_t record = plan->record.width * sizeof(double), all = bytes / record;
    if (bytes % record) {
        fprintf(stderr,
                "totalforce sweep: %s: %" PRIu64 " bytes are no whole number of records of %u "
                "doubles, which %s of this robot reads\n",
                o->states, bytes, plan->record.width, tfa_word(TFA_WORDS_OP, o->op));
        return EXIT_FAILED;
    }
    if (o->offset >= all || o->count > all - o->offset) {
        fprintf(stderr,
                "totalforce sweep: %s: has %" PRIu64 " states; --offset %" PRIu64
                " --count %" PRIu64 " asks for more\n",
                o->states, all, o->offset, o->count);
        return EXIT_FAILED;
    }
    plan->count = o->count ? o->count : all - o->offset;
    return EXIT_GOOD;
}

static int open_states(sweep_plan *plan)
{
    struct stat facts;
    const char *path = plan->options->states;
    plan->count = plan->options->count;
    if (!path)
        return EXIT_GOOD;
    plan->states = open(path, O_RDONLY | O_CLOEXEC);
    if (plan->states < 0 || fstat(plan->states, &facts) != 0)
        return fail(path, strerror(errno));
    if (!S_ISREG(facts.st_mode))
        return fail(path, "no regular file: records are read at their offsets");
    return check_states_file(plan, (uint64_t)facts.st_size);
}

/* Of the ranges, which are not in the model's hash (FNV-1a of their bits) */
static uint64_t hash_ranges(const state_record *r)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    const double *const lists[2] = {r->low, r->span};
    for (int list = 0; list < 2; list++)
        for (size_t k = 0; k < r->width * sizeof(double); k++)
            hash = (hash ^ ((const unsigned char *)lists[list])[k]) * UINT64_C(0x100000001b3);
    return hash;
}

static int set_identity(sweep_plan *plan)
{
    const sweep_options *o = plan->options;
    char where[64], refine[16] = "default";
    if (o->refine != TFA_REFINE_DEFAULT)
        snprintf(refine, sizeof refine, "%" PRIu32, o->refine);
    snprintf(where, sizeof where, "seed=%" PRIu64 " ranges=%016" PRIx64, o->seed,
             hash_ranges(&plan->record));
    const int length =
        asprintf(&plan->identity,
                 "version=%s isa=%s model=%.16s op=%s method=%s precision=%s residual=%d "
                 "estimate=%d refine=%s tips=%s %s%s offset=%" PRIu64 " count=%" PRIu64
                 " block=%u reference=%" PRIu64 " out=%s out-states=%s",
                 TFA_VERSION, tfa_isa_name(), tfa_model_hash_text(plan->model),
                 tfa_word(TFA_WORDS_OP, o->op), tfa_method_name(o->method),
                 tfa_word(TFA_WORDS_PRECISION, o->workspace.precision), (int)o->workspace.residual,
                 (int)o->estimate, refine, o->tips ? o->tips : "", o->states ? "states=" : "",
                 o->states ? o->states : where, plan->first, plan->count, o->block, o->reference,
                 o->out ? o->out : "", o->out_states ? o->out_states : "");
    if (length >= 0)
        return EXIT_GOOD;
    plan->identity = NULL;
    return fail(o->file, tfa_status_text(TFA_E_MEMORY));
}

static int complete(sweep_plan *plan, const source *s)
{
    const sweep_options *o = plan->options;
    int result = set_tips(plan, o->tips);
    if (result != EXIT_GOOD)
        return result;
    set_answer(plan);
    result = set_record(plan, s);
    if (result == EXIT_GOOD)
        result = open_states(plan);
    plan->first = o->offset;
    plan->blocks = (plan->count + o->block - 1) / o->block;
    if (result == EXIT_GOOD && plan->blocks > SWEEP_BLOCKS_MAX)
        result = fail(o->states, "more than 2^30 blocks: take a larger --block");
    return result == EXIT_GOOD ? set_identity(plan) : result;
}

int sweep_plan_make(sweep_plan *plan, sweep_options *o, sweep_ranks *ranks)
{
    source s = {0};
    *plan = (sweep_plan){.options = o, .states = -1};
    plan->request = (tfa_request){
        .op = o->op, .method = o->method, .estimate = o->estimate, .refine = o->refine};
    int result = share_source(&s, o->file, ranks);
    if (result == EXIT_GOOD)
        result = load(plan, o, &s, ranks);
    if (result == EXIT_GOOD) {
        result = complete(plan, &s);
        result = ranks->agree(result == EXIT_GOOD) ? EXIT_GOOD : EXIT_FAILED;
    }
    free(s.text);
    return result;
}

void sweep_plan_free(sweep_plan *plan)
{
    if (plan->states >= 0)
        close(plan->states);
    state_record_free(&plan->record);
    free(plan->identity);
    tfa_model_free(plan->model);
}

uint64_t sweep_block_count(const sweep_plan *plan, uint64_t block)
{
    const uint64_t rest = plan->count - block * plan->options->block;
    return rest < plan->options->block ? rest : plan->options->block;
}
