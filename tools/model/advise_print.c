/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints an advice as a configuration of the daemon: the robot as the command line describes it,
 * with one scene. Strings are quoted as in JSON, which YAML reads.
 */
#include "advise.h"

#include "jsonl/jsonl.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>

static void print_list(const double *x, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++) {
        fputs(k ? ", " : "[", stdout);
        jsonl_print_number(stdout, x[k]);
    }
    fputc(']', stdout);
}

static void print_key(const char *before, const char *key, const char *text)
{
    printf("%s%s: ", before, key);
    jsonl_print_string(stdout, text);
    fputc('\n', stdout);
}

/* A robot is served by a name of letters, digits and -_. */
static void print_name(const char *name)
{
    fputs("  - name: \"", stdout);
    for (; *name; name++)
        fputc(isalnum((unsigned char)*name) || *name == '-' || *name == '_' ? *name : '_', stdout);
    fputs("\"\n", stdout);
}

static void print_number_key(const char *key, double number)
{
    printf("    %s: ", key);
    jsonl_print_number(stdout, number);
    fputc('\n', stdout);
}

static void print_inertias(const char *key, const tfa_rotor *list, uint32_t count)
{
    if (count)
        printf("    %s:\n", key);
    for (uint32_t k = 0; k < count; k++) {
        fputs("      - {joint: ", stdout);
        jsonl_print_string(stdout, list[k].joint);
        fputs(", value: ", stdout);
        jsonl_print_number(stdout, list[k].inertia);
        puts("}");
    }
}

static void print_robot(const tfa_model *model, const char *file, const scene_options *o)
{
    const tfa_model_options *m = &o->model;
    fputs("robots:\n", stdout);
    print_name(tfa_model_name(model));
    print_key("    ", "urdf", file);
    if (m->base == TFA_BASE_FLOATING)
        puts("    base: floating");
    if (m->gravity) {
        fputs("    gravity: ", stdout);
        print_list(m->gravity, 3);
        fputc('\n', stdout);
    }
    if (m->mimic)
        printf("    mimic: %s\n", tfa_word(TFA_WORDS_MIMIC, m->mimic));
    if (m->inertia)
        printf("    inertia: %s\n", tfa_word(TFA_WORDS_INERTIA, m->inertia));
    if (m->rotor_inertia)
        puts("    rotor_inertia: true");
    if (m->damping)
        puts("    damping: true");
    if (m->friction)
        puts("    friction: true");
    if (m->friction_velocity > 0)
        print_number_key("friction_velocity", m->friction_velocity);
    if (m->lock_massless_leaves)
        puts("    lock_massless_leaves: true");
    if (m->snap > 0)
        print_number_key("snap", m->snap);
    print_inertias("rotors", o->rotors, o->rotor_count);
    print_inertias("armature", o->armature, o->armature_count);
}

/* The last locks are those of the advice. */
static void print_locks(const scene_options *o, const tfa_advice *advice)
{
    const uint32_t given = o->lock_count - advice->count;
    fputs("        locked:\n", stdout);
    for (uint32_t k = 0; k < o->lock_count; k++) {
        const scene_lock *lock = &o->locks[k];
        fputs("          - {joint: ", stdout);
        jsonl_print_string(stdout, lock->lock.joint);
        fputs(lock->numbers == 1 ? ", q: " : ", pose: ", stdout);
        if (lock->numbers == 1)
            jsonl_print_number(stdout, *lock->lock.q);
        else
            print_list(lock->lock.q, lock->numbers);
        fputc('}', stdout);
        if (k >= given)
            printf(" # alone: error %.2g", advice->single_error[advice->joints[k - given]]);
        fputc('\n', stdout);
    }
}

static void print_payloads(const scene_options *o)
{
    fputs("        payload:\n", stdout);
    for (uint32_t k = 0; k < o->payload_count; k++) {
        fputs("          - {link: ", stdout);
        jsonl_print_string(stdout, o->payloads[k].link);
        fputs(", mass: ", stdout);
        jsonl_print_number(stdout, o->payloads[k].mass);
        fputs(", com: ", stdout);
        print_list(o->payloads[k].com, 3);
        fputs(", inertia: ", stdout);
        print_list(o->payloads[k].inertia, 6);
        fputs("}\n", stdout);
    }
}

static void print_names(const char *key, const char *const *names, uint32_t count, bool are_files)
{
    if (count)
        printf("        %s:\n", key);
    for (uint32_t k = 0; k < count; k++) {
        char *file = are_files ? realpath(names[k], NULL) : NULL;
        fputs("          - ", stdout);
        jsonl_print_string(stdout, file ? file : names[k]);
        fputc('\n', stdout);
        free(file);
    }
}

static void print_scene(const scene_options *o, const tfa_advice *advice)
{
    puts("    scenes:\n      - name: advised");
    if (o->scene.root)
        print_key("        ", "root", o->scene.root);
    print_names("tips", o->tips, o->tip_count, false);
    print_names("modes", o->modes_files, o->modes_count, true);
    if (o->payload_count)
        print_payloads(o);
    if (o->lock_count)
        print_locks(o, advice);
}

void advise_print(const tfa_model *model, const tfa_model *scene, const tfa_advice *advice,
                  uint32_t states, double tolerance)
{
    const tfa_model_summary old = tfa_model_summarise(model), new = tfa_model_summarise(scene);
    const uint32_t base = tfa_model_base_freedoms(model);
    printf("# %u of %u joints may be locked in %u state%s.\n", advice->count,
           tfa_model_joint_count(model), states, states == 1 ? "" : "s");
    printf(
        "# Error of the accelerations in the energy norm, |qdd_scene - qdd|_M / |qdd|_M: at most "
        "%.3g (state %u); tolerance %g.\n",
        advice->error, advice->state + 1, tolerance);
    printf("# Bodies: %u instead of %u; freedoms: %u instead of %u.\n", new.bodies, old.bodies,
           new.v_count + base, old.v_count + base);
}

int advise_print_robot(const tfa_model *model, const char *urdf, const scene_options *options,
                       const tfa_advice *advice)
{
    char *file = realpath(urdf, NULL);
    if (!file)
        return 0;
    print_robot(model, file, options);
    if (options->model.scene)
        print_scene(options, advice);
    free(file);
    return fflush(stdout) == 0 && !ferror(stdout);
}
