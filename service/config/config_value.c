/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scalars of the configuration: each is read whole or refused.
 *
 * Whole numbers are decimal digits and nothing else: no sign, exponent, point, separator or unit.
 * Other numbers have a sign, a point and an exponent if they like. A leading zero is refused in
 * both, because YAML readers disagree whether 010 is eight or ten.
 */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

#include "config_read.h"

static const char *const true_words[] = {"true", "yes", "on", NULL};
static const char *const false_words[] = {"false", "no", "off", NULL};

/* First word that may be chosen */
static size_t first_word(const config_scalar *s)
{
    return s->is_entry ? 0 : (size_t)s->row->low;
}

static double lowest(const config_scalar *s)
{
    return s->is_entry ? 0 : s->row->low;
}

static double highest(const config_scalar *s)
{
    return s->is_entry ? UINT32_MAX : s->row->high;
}

/* Numbers in lists have no range of their own. */
static bool has_range(const config_scalar *s)
{
    return s->kind == CONFIG_COUNT || !s->is_entry;
}

static bool is_in_range(const config_scalar *s, double value)
{
    return !has_range(s) || (value >= lowest(s) && value <= highest(s));
}

/* ---- expected values, in words ---- */

static void join_words(const char *const *words, char *text, size_t size)
{
    size_t used = 0;
    for (size_t k = 0; words[k] && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", k ? ", " : "", words[k]);
}

static void describe(const config_scalar *s, char *text, size_t size)
{
    char words[80];
    switch (s->kind) {
    case CONFIG_COUNT:
    case CONFIG_NUMBER:
        if (has_range(s))
            snprintf(text, size, "a %s from %.10g to %.10g%s%s",
                     s->kind == CONFIG_COUNT ? "whole number" : "number", lowest(s), highest(s),
                     s->row->word ? ", or " : "", s->row->word ? s->row->word : "");
        else
            snprintf(text, size, "a finite number");
        break;
    case CONFIG_BOOL:
        snprintf(text, size, "one of true, false, yes, no, on, off");
        break;
    case CONFIG_WORD:
        join_words(s->row->words + first_word(s), words, sizeof words);
        snprintf(text, size, "one of %s", words);
        break;
    default:
        snprintf(text, size, "a text");
        break;
    }
}

/* ---- numbers ---- */

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Letters of a unit, those of the micro sign included */
static bool is_unit_letter(char c)
{
    return isalpha((unsigned char)c) || (unsigned char)c >= 0x80;
}

static const char *after_sign(const char *text)
{
    return text + (*text == '+' || *text == '-');
}

static bool read_number(const char *text, double *value)
{
    const char *digits = after_sign(text);
    if (digits[0] == '0' && is_digit(digits[1]))
        return false;
    return tfa_number_read(text, strlen(text), value) == TFA_NUMBER_OK;
}

/* Beyond 2^53 the value is rounded; every range ends far below. */
static bool read_count(const char *text, double *value)
{
    uint64_t whole = UINT64_MAX;
    if (tfa_whole_number_read(text, strlen(text), &whole) == TFA_NUMBER_MALFORMED)
        return false;
    *value = (double)whole;
    return true;
}

/* Without separators, leading zeros and unit, the comma as a point: the number most likely meant.
 * @return there is such a number */
static bool clean_number(const char *text, char *number, size_t size, double *value)
{
    const char *comma = strchr(text, ','), *rest;
    size_t n = 0;
    if (comma && (strchr(comma + 1, ',') || strchr(text, '.')))
        return false;
    text += strspn(text, " \t\n");
    if (*text == '-')
        number[n++] = '-';
    for (text = after_sign(text); text[0] == '0' && (is_digit(text[1]) || text[1] == '_');)
        text++;
    for (; *text && strchr("+-.,_0123456789eE", *text) && n + 1 < size; text++)
        if (*text != '_')
            number[n++] = *text == ',' ? '.' : *text;
    number[n] = 0;
    rest = text + strspn(text, " \t\n");
    if (*rest && !is_unit_letter(*rest) && *rest != '%')
        return false;
    return read_number(number, value);
}

static bool clean_hexadecimal(const char *text, char *number, size_t size, double *value)
{
    char *end;
    if (text[0] != '0' || (text[1] != 'x' && text[1] != 'X') || !isxdigit((unsigned char)text[2]))
        return false;
    *value = (double)strtoull(text + 2, &end, 16);
    snprintf(number, size, "%.0f", *value);
    return *end == 0;
}

/* Units that people write behind a number: what they measure, and how much of it */
static const struct {
    const char *name;
    char of;
    double size;
} units[] = {{"ns", 't', 1e-9},      {"us", 't', 1e-6},
             {"\u00b5s", 't', 1e-6}, {"\u03bcs", 't', 1e-6},
             {"ms", 't', 1e-3},      {"s", 't', 1},
             {"min", 't', 60},       {"KiB", 'b', 0x1p10},
             {"MiB", 'b', 0x1p20},   {"GiB", 'b', 0x1p30},
             {"g", 'm', 1e-3},       {"kg", 'm', 1},
             {"mm", 'l', 1e-3},      {"cm", 'l', 1e-2},
             {"m", 'l', 1},          {"deg", 'a', 0.017453292519943295},
             {"rad", 'a', 1}};
enum { UNITS = sizeof units / sizeof *units };

static size_t find_unit(const char *name)
{
    size_t k = 0;
    while (k < UNITS && strcmp(units[k].name, name) != 0)
        k++;
    return k;
}

/* From the unit that ends a text to that of the key; 1: there is none, or one of another kind */
static double unit_factor(const char *text, const char *unit_of_key)
{
    const char *unit = text + strlen(text);
    while (unit > text && is_unit_letter(unit[-1]))
        unit--;
    const size_t from = find_unit(unit), to = unit_of_key ? find_unit(unit_of_key) : (size_t)UNITS;
    return from < UNITS && to < UNITS && units[from].of == units[to].of
               ? units[from].size / units[to].size
               : 1;
}

static bool is_null_text(const char *text)
{
    return !*text || strcmp(text, "~") == 0 || strcmp(text, "null") == 0;
}

/* How to write it: the number that was meant, or the form. */
static void suggest_value(const config_scalar *s, const char *text, char *remedy, size_t size)
{
    char number[48];
    double value;
    const bool whole = s->kind == CONFIG_COUNT;
    const bool meant =
        clean_hexadecimal(text, number, sizeof number, &value) ||
        (!(whole && strchr(text, ',')) && clean_number(text, number, sizeof number, &value));
    const double factor = meant ? unit_factor(text, s->row->unit) : 1;
    const double nearest = meant ? rint(value * factor) : 0;
    if (factor != 1) { /* 3 us are 3000 ns, but 3 * (1e-6 / 1e-9) is not */
        value *= factor;
        value = fabs(value - nearest) < 1e-9 * fabs(nearest) ? nearest : value;
        snprintf(number, sizeof number, "%.10g", value);
    }
    if (meant && is_in_range(s, value) && !whole)
        snprintf(remedy, size, "; write %s", number);
    else if (meant && is_in_range(s, value) && value == (double)(uint64_t)value)
        snprintf(remedy, size, "; write %.0f", value);
    else if (is_null_text(text) && s->row->word)
        snprintf(remedy, size, "; leave the key out for the default, %s", s->row->word);
    else if (is_null_text(text) && !s->is_entry && !s->row->required &&
             s->row->default_value >= s->row->low)
        snprintf(remedy, size, "; leave the key out for the default, %u", s->row->default_value);
    else
        snprintf(remedy, size, "; write it %s", whole ? "in decimal digits" : "like 2.5 or -1e-3");
}

static bool read_numeric(config_reader *r, const config_scalar *s, const yaml_node_t *node,
                         const char *text, double *value)
{
    char wanted[96], remedy[96] = "";
    const bool good = s->kind == CONFIG_COUNT ? read_count(text, value) : read_number(text, value);
    if (good && is_in_range(s, *value))
        return true;
    describe(s, wanted, sizeof wanted);
    if (!good)
        suggest_value(s, text, remedy, sizeof remedy);
    config_error_at(r, node, s->path, "'%.80s' is not %s%s", text, wanted, remedy);
    return false;
}

/* ---- words and text ---- */

static bool find_word(const char *const *words, const char *text, uint32_t *index)
{
    for (uint32_t k = 0; words[k]; k++)
        if (strcmp(words[k], text) == 0) {
            *index = k;
            return true;
        }
    return false;
}

static bool read_word(config_reader *r, const config_scalar *s, const yaml_node_t *node,
                      const char *text, uint32_t *index)
{
    char wanted[96];
    if (s->kind == CONFIG_BOOL) {
        const bool truth = find_word(true_words, text, index);
        if (truth || find_word(false_words, text, index)) {
            *index = truth;
            return true;
        }
    } else if (find_word(s->row->words, text, index) && *index >= first_word(s)) {
        return true;
    }
    describe(s, wanted, sizeof wanted);
    config_error_at(r, node, s->path, "'%.80s' is not %s", text, wanted);
    return false;
}

/* A key whose value was forgotten (or null) is not a text of no characters. */
static bool is_missing_value(const yaml_node_t *node, const char *text)
{
    return !*text || (node->data.scalar.style == YAML_PLAIN_SCALAR_STYLE && is_null_text(text));
}

/* @return the characters, NULL after an error */
static const char *read_characters(config_reader *r, const config_scalar *s,
                                   const yaml_node_t *node)
{
    char wanted[96];
    describe(s, wanted, sizeof wanted);
    if (node->type != YAML_SCALAR_NODE) {
        config_error_at(r, node, s->path, "%s where %s is expected",
                        node->type == YAML_SEQUENCE_NODE ? "a list" : "keys", wanted);
        return NULL;
    }
    const char *text = (const char *)node->data.scalar.value;
    if (strlen(text) != node->data.scalar.length) {
        config_error_at(r, node, s->path,
                        "'%.80s' is followed by a NUL character; %s without it "
                        "is expected",
                        text, wanted);
        return NULL;
    }
    if (s->kind == CONFIG_TEXT && is_missing_value(node, text)) {
        config_error_at(r, node, s->path, "'%s' where %s is expected%s", text, wanted,
                        s->is_entry || s->row->required ? "" : "; or leave the key out");
        return NULL;
    }
    return text;
}

void config_set_default(const config_scalar *s, void *out)
{
    if (s->kind == CONFIG_COUNT || s->kind == CONFIG_WORD)
        *(uint32_t *)out = s->row->default_value;
    else if (s->kind == CONFIG_BOOL)
        *(bool *)out = s->row->default_value != 0;
    else if (s->kind == CONFIG_NUMBER)
        *(double *)out = 0;
    else
        *(const char **)out = NULL;
}

void config_read_scalar(config_reader *r, const config_scalar *s, const yaml_node_t *node,
                        void *out)
{
    const char *text = read_characters(r, s, node);
    double value;
    uint32_t index;
    config_set_default(s, out);
    if (!text || (s->row->word && strcmp(text, s->row->word) == 0)) /* the default is the word's */
        return;
    if (s->kind == CONFIG_TEXT)
        *(const char **)out = text;
    else if (s->kind == CONFIG_COUNT && read_numeric(r, s, node, text, &value))
        *(uint32_t *)out = (uint32_t)value;
    else if (s->kind == CONFIG_NUMBER && read_numeric(r, s, node, text, &value))
        *(double *)out = value;
    else if (s->kind == CONFIG_WORD && read_word(r, s, node, text, &index))
        *(uint32_t *)out = index;
    else if (s->kind == CONFIG_BOOL && read_word(r, s, node, text, &index))
        *(bool *)out = index != 0;
}
