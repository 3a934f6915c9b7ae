/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Gathers the numbers of the load report.
 */
#include "model_report.h"

#include <stdlib.h>
#include <string.h>

static int is_one_of(const char *code, const char *const *codes)
{
    for (; *codes; codes++)
        if (strcmp(*codes, code) == 0)
            return 1;
    return 0;
}

int model_code_is_ignored(const char *code)
{
    static const char *const codes[] = {
        "not-used",          "damping",     "friction", "rotor-inertia",
        "unknown-attribute", "mimic-fixed", NULL};
    return is_one_of(code, codes);
}

int model_code_is_repaired(const char *code)
{
    static const char *const codes[] = {"inertia-repaired", "inertia-rounded", NULL};
    return is_one_of(code, codes);
}

size_t model_constraint_words(uint32_t rows, const char **words)
{
#define WORD(rows, word) {rows, word},
    static const struct {
        uint32_t rows;
        const char *word;
    } sets[] = {TFA_CONSTRAINT_WORDS(WORD)};
#undef WORD
    size_t count = 0;
    for (size_t k = 0; k < sizeof sets / sizeof *sets; k++) {
        const bool whole = sets[k].rows == rows, is_row = !(sets[k].rows & (sets[k].rows - 1));
        if (whole || (is_row && rows & sets[k].rows))
            words[count++] = sets[k].word;
        if (whole)
            break;
    }
    return count;
}

const char *model_constraint_link(const tfa_model *model, const tfa_constraint_info *constraint,
                                  int side)
{
    const int32_t frame = constraint->frame[side];
    return frame < 0 ? NULL : tfa_model_frame(model, (uint32_t)frame).name;
}

bool model_names_actuated(const tfa_model *model)
{
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++)
        if (!tfa_model_joint(model, i).actuated)
            return true;
    return false;
}

void model_count_fates(const tfa_model_summary *s, uint32_t *counts)
{
    counts[TFA_FATE_FIXED] = s->fixed;
    counts[TFA_FATE_LOCKED] = s->locked;
    counts[TFA_FATE_FUSED] = s->fused;
    counts[TFA_FATE_FOLLOWS] = s->follows;
    counts[TFA_FATE_ABSENT] = s->absent;
    counts[TFA_FATE_MOVES] = s->joints - s->fixed - s->locked - s->fused - s->follows - s->absent;
}

/* A counting sort of the links by body, the world last. */
static int group_links(model_report *r)
{
    const uint32_t links = tfa_model_frame_count(r->model);
    r->first_link = calloc((size_t)r->bodies + 3, sizeof *r->first_link);
    r->link_names = calloc((size_t)links + 1, sizeof *r->link_names);
    if (!r->first_link || !r->link_names)
        return TFA_E_MEMORY;
    /* counted two places on, so that filling leaves the starts in place */
    for (uint32_t i = 0; i < links; i++) {
        int32_t body = tfa_model_frame(r->model, i).body;
        r->first_link[(body < 0 ? r->bodies : (uint32_t)body) + 2]++;
    }
    for (uint32_t b = 2; b < r->bodies + 3; b++)
        r->first_link[b] += r->first_link[b - 1];
    for (uint32_t i = 0; i < links; i++) {
        tfa_frame_info link = tfa_model_frame(r->model, i);
        uint32_t body = link.body < 0 ? r->bodies : (uint32_t)link.body;
        r->link_names[r->first_link[body + 1]++] = link.name;
    }
    return TFA_OK;
}

static code_count *find_code(const model_report *r, const tfa_message *message)
{
    for (size_t k = 0; k < r->code_count; k++)
        if (r->codes[k].severity == message->severity &&
            strcmp(r->codes[k].code, message->code) == 0)
            return &r->codes[k];
    return NULL;
}

/* There are some dozens of codes, however many messages. */
static int count_codes(model_report *r)
{
    for (size_t i = 0; i < r->messages->count; i++) {
        const tfa_message *message = &r->messages->messages[i];
        code_count *found = find_code(r, message);
        if (!found) {
            code_count *grown = reallocarray(r->codes, r->code_count + 1, sizeof *grown);
            if (!grown)
                return TFA_E_MEMORY;
            r->codes = grown;
            found = &grown[r->code_count++];
            *found = (code_count){.code = message->code, .severity = message->severity};
        }
        found->count += message->count;
    }
    return TFA_OK;
}

int model_report_init(model_report *report, const char *file, const scene_options *options,
                      const tfa_report *messages, const tfa_model *model)
{
    *report =
        (model_report){.file = file, .options = options, .messages = messages, .model = model};
    int status = count_codes(report);
    if (status == TFA_OK && model) {
        report->bodies = tfa_model_summarise(model).bodies;
        status = group_links(report);
        if (status == TFA_OK)
            status = model_loops_check(model, &report->loops);
    }
    return status;
}

void model_report_free(model_report *report)
{
    free(report->first_link);
    free(report->link_names);
    free(report->codes);
    *report = (model_report){0};
}
