/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Writes docstrings: signature, equation, arguments and answers of an op.
 */
#include "docs.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** A text that grows; NULL: no memory */
typedef struct growing_text {
    char *text;
    size_t used;
} growing_text;

__attribute__((format(printf, 2, 3))) static void add(growing_text *out, const char *format, ...)
{
    va_list list, again;
    va_start(list, format);
    va_copy(again, list);
    const size_t length = (size_t)vsnprintf(NULL, 0, format, list);
    char *grown = out->text || !out->used ? realloc(out->text, out->used + length + 1) : NULL;
    if (grown)
        vsnprintf(grown + out->used, length + 1, format, again);
    else
        free(out->text);
    out->text = grown;
    out->used += length;
    va_end(again);
    va_end(list);
}

/* 1: `list`, "q, v=None, tau=None", has the name */
static int lists(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; (at = strstr(at, name)); at += length)
        if ((at == list || at[-1] == ' ') && strchr(",=", at[length]))
            return 1; /* the end of the list, too: strchr finds the terminator */
    return 0;
}

static int is_shown(const input_row *input, const op_row *op, int for_client)
{
    return (!input->only_client || for_client) &&
           (input->ops & TFA_OP_BIT(op->op) || input->flags & ~TFA_WANT_OF_SOLVE ||
            (input->flags && TFA_OP_BIT(op->op) & TFA_OPS_SOLVE));
}

/* An indented text whose lines continue at the same column */
static void write_indented(growing_text *out, const char *text)
{
    add(out, "        ");
    for (; *text; text++) {
        add(out, "%c", *text);
        if (*text == '\n')
            add(out, "        ");
    }
    add(out, "\n");
}

static void write_inputs(growing_text *out, const op_row *op, int for_client)
{
    add(out, "\nParameters\n----------\n");
    for (size_t k = 0; k < input_count; k++)
        if (is_shown(&inputs[k], op, for_client)) {
            add(out, "%s : %s\n", inputs[k].name, inputs[k].shape);
            write_indented(out, inputs[k].text);
        }
}

static void write_output(growing_text *out, int k)
{
    const tfa_output *output = &tfa_outputs[outputs[k].block];
    char rows[16], columns[16];
    const char *r = extent_name(output->rows, rows, sizeof rows);
    const char *c = extent_name(output->columns, columns, sizeof columns);
    if (outputs[k].layout == LAYOUT_FREEDOMS)
        add(out, "%s : (n_v,), and base_%s : (6,) of a floating base\n", outputs[k].name,
            outputs[k].name);
    else if (output_has_numbers(k))
        add(out, "%s : (%s%s%s%s)\n", outputs[k].name, r, *r ? ", " : "", c, *c && !*r ? "," : "");
    else
        add(out, "%s\n", outputs[k].name);
    write_indented(out, outputs[k].text);
}

static void write_outputs(growing_text *out, const op_row *op)
{
    add(out, "\nReturns\n-------\nReply with\n\n");
    for (int k = 0; k < OUTPUT_COUNT; k++)
        if (tfa_outputs[outputs[k].block].ops & TFA_OP_BIT(op->op))
            write_output(out, k);
    add(out, "method, error_estimate, ...\n");
    write_indented(out, "quality of the answer, see Reply; and the answers of `want`");
    add(out,
        "\nIn a batch every array has an axis of `count` states first. Arrays of one state are "
        "repeated\nfor all. Contiguous float64 arrays are used in place. SI units; six-vectors "
        "are linear\nfirst; quaternions x y z w.\n");
}

const char *docs_op(const op_row *op, int for_client)
{
    growing_text made = {0}, *out = &made;
    add(out, "%s($self, /, %s, *", op_name(op->op), op->positional);
    for (size_t k = 0; k < input_count; k++)
        if (is_shown(&inputs[k], op, for_client) && !lists(op->positional, inputs[k].name))
            add(out, ", %s=None", inputs[k].name);
    add(out, ")\n--\n\n%s\n", op->text);
    write_inputs(out, op, for_client);
    write_outputs(out, op);
    if (!made.text)
        PyErr_NoMemory();
    return made.text;
}

const char *docs_compute(int for_client)
{
    static const char text[] =
        "compute($self, op, /, *args, **fields)\n--\n\n"
        "Answers one request.\n\n"
        "compute('forward_dynamics', q, v, tau) is forward_dynamics(q, v, tau): every op is a\n"
        "method of its own, with the same arguments.\n";
    (void)for_client;
    return text;
}
