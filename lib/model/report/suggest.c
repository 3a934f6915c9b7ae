/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Suggestions for mistyped names, by edit distance.
 */
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/text.h>

#define SUGGESTIONS 3
#define NAME_LENGTH_MAX 96 /* compared bytes of a name */
#define WORDS_LISTED_MAX 6 /* of longer lists the nearest words are named, too */

static uint32_t smallest(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t least = a < b ? a : b;
    return least < c ? least : c;
}

/* Restricted Damerau-Levenshtein distance, with three rows of the table. */
static uint32_t distance(const char *a, const char *b)
{
    const size_t rows = strnlen(a, NAME_LENGTH_MAX), columns = strnlen(b, NAME_LENGTH_MAX);
    uint32_t table[3][NAME_LENGTH_MAX + 1];
    for (size_t k = 0; k <= columns; k++)
        table[0][k] = (uint32_t)k;
    for (size_t i = 1; i <= rows; i++) {
        uint32_t *row = table[i % 3], *above = table[(i + 2) % 3], *before = table[(i + 1) % 3];
        row[0] = (uint32_t)i;
        for (size_t k = 1; k <= columns; k++) {
            row[k] = smallest(above[k] + 1, row[k - 1] + 1, above[k - 1] + (a[i - 1] != b[k - 1]));
            if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1])
                row[k] = smallest(row[k], row[k], before[k - 2] + 1);
        }
    }
    return table[rows % 3][columns];
}

/* Names of ours, and the words of ROS, Pinocchio, MuJoCo and Featherstone's book for each */
static const struct {
    const char *name, *words; /* with a blank before and behind every word */
} meanings[] = {
    {"q", " position positions qpos "},
    {"v", " qd dq qdot qvel velocity velocities "},
    {"twist", " velocity "},
    {"tau", " effort efforts torque torques ctrl qfrc_applied "},
    {"qdd", " a acc ddq qddot qacc "},
    {"acceleration", " a acc "},
    {"base_pose", " base_position base_orientation "},
    {"base_twist", " base_velocity "},
    {"wrench", " f_ext fext xfrc_applied "},
    {"tips", " frames links "},
    {"forward_dynamics", " fd aba "},
    {"inverse_dynamics", " id rnea "},
    {"mass_matrix", " crba "},
    {"kinematics", " fk "},
    {"bias", " nle "},
};

/* ASCII letters, in every locale */
static void to_lower_case(const char *from, char to[NAME_LENGTH_MAX + 1])
{
    size_t k = 0;
    for (; k < NAME_LENGTH_MAX && from[k]; k++)
        to[k] = (char)(from[k] >= 'A' && from[k] <= 'Z' ? from[k] - 'A' + 'a' : from[k]);
    to[k] = '\0';
}

const char *tfa_misspelled(const char *wrong, const void *list, size_t count, tfa_list_name name)
{
    const char *best = NULL;
    uint32_t least = UINT32_MAX;
    char a[NAME_LENGTH_MAX + 1], b[NAME_LENGTH_MAX + 1];
    to_lower_case(wrong, a);
    for (size_t i = 0; i < count; i++) {
        const char *candidate = name(list, i);
        const size_t length = strlen(candidate);
        to_lower_case(candidate, b);
        const uint32_t d = distance(a, b);
        if (d >= least || d > (length < 6 ? 1 : 2))
            continue;
        least = d;
        best = candidate;
    }
    return best;
}

static size_t add_name(char *text, size_t size, size_t used, const char *name)
{
    if (used < size)
        used += (size_t)snprintf(text + used, size - used, "%s'%s'", used ? ", " : "", name);
    return used;
}

/* Names of the list that a word of others means. Returns whether there are any. */
static int suggest_meanings(const char *wrong, const void *list, size_t count, tfa_list_name name,
                            char *text, size_t size)
{
    char lower[NAME_LENGTH_MAX + 1], word[NAME_LENGTH_MAX + 3];
    size_t used = 0;
    to_lower_case(wrong, lower);
    snprintf(word, sizeof word, " %s ", lower);
    for (size_t k = 0; k < sizeof meanings / sizeof *meanings; k++)
        for (size_t i = 0; strstr(meanings[k].words, word) && i < count; i++)
            if (strcmp(name(list, i), meanings[k].name) == 0)
                used = add_name(text, size, used, meanings[k].name);
    return used > 0;
}

void tfa_suggest(const char *wrong, const void *list, size_t count, tfa_list_name name, char *text,
                 size_t size)
{
    const char *best[SUGGESTIONS] = {NULL};
    uint32_t distances[SUGGESTIONS] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    if (suggest_meanings(wrong, list, count, name, text, size))
        return;
    for (size_t i = 0; i < count; i++) {
        const char *candidate = name(list, i);
        const uint32_t d = distance(wrong, candidate);
        if (d >= distances[SUGGESTIONS - 1])
            continue;
        int k = SUGGESTIONS - 1;
        for (; k > 0 && d < distances[k - 1]; k--) {
            distances[k] = distances[k - 1];
            best[k] = best[k - 1];
        }
        distances[k] = d;
        best[k] = candidate;
    }
    snprintf(text, size, "none");
    size_t used = 0;
    for (int k = 0; k < SUGGESTIONS && best[k]; k++)
        used = add_name(text, size, used, best[k]);
}

static const char *word_at(const void *words, size_t index)
{
    return ((const char *const *)words)[index];
}

void tfa_suggest_words(const char *wrong, const char *const *words, size_t count, char *text,
                       size_t size)
{
    char nearest[160];
    size_t used = 0;
    tfa_suggest(wrong, words, count, word_at, nearest, sizeof nearest);
    if (count > WORDS_LISTED_MAX)
        used = (size_t)snprintf(text, size, "nearest: %s; ", nearest);
    for (size_t k = 0; k < count && used < size; k++)
        used +=
            (size_t)snprintf(text + used, size - used, "%s %s", k ? "," : "there are", words[k]);
}
