/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The settings of a robot that shape its answers, as JSON: enough to compile its model of its URDF
 * and to make its workspace elsewhere. Numbers keep their bits.
 */
#include <math.h>
#include <totalforce/version.h>

#include "robot.h"

/* ---- JSON ---- */

static void write_text(FILE *out, const char *text)
{
    if (!text) {
        fputs("null", out);
        return;
    }
    fputc('"', out);
    for (const unsigned char *at = (const unsigned char *)text; *at; at++)
        if (*at == '"' || *at == '\\')
            fprintf(out, "\\%c", *at);
        else if (*at < 0x20)
            fprintf(out, "\\u%04x", *at);
        else
            fputc(*at, out);
    fputc('"', out);
}

/* 17 digits give the same double again. */
static void write_numbers(FILE *out, const double *numbers, size_t count)
{
    fputc('[', out);
    for (size_t i = 0; i < count; i++)
        fprintf(out, "%s%.17g", i ? ", " : "", numbers[i]);
    fputc(']', out);
}

static const char *comma(size_t i)
{
    return i ? ", " : "";
}

/* ---- the model ---- */

static void write_lock(FILE *out, const config_lock *lock)
{
    double q[7] = {lock->q};
    for (size_t i = 0; i < lock->pose_count && i < 7; i++)
        q[i] = lock->pose[i];
    fputs("{\"joint\": ", out);
    write_text(out, lock->joint);
    fputs(", \"q\": ", out);
    write_numbers(out, q, lock->pose_count ? lock->pose_count : 1);
    fputc('}', out);
}

static void write_payload(FILE *out, const config_payload *payload)
{
    static const double zeros[6];
    fputs("{\"link\": ", out);
    write_text(out, payload->link);
    fprintf(out, ", \"mass\": %.17g, \"com\": ", payload->mass);
    write_numbers(out, payload->com_count ? payload->com : zeros, 3);
    fputs(", \"inertia\": ", out);
    write_numbers(out, payload->inertia_count ? payload->inertia : zeros, 6);
    fputc('}', out);
}

static void write_key(FILE *out, const char *key, const double *numbers, size_t count)
{
    fprintf(out, "\"%s\": ", key);
    write_numbers(out, numbers, count);
    fputs(", ", out);
}

static void write_mode(FILE *out, const tfa_link_modes *link, size_t k)
{
    const size_t n = link->mode_count;
    fputc('{', out);
    write_key(out, "momentum", link->momentum + 6 * k, 6);
    write_key(out, "mass", link->mass + n * k, n);
    write_key(out, "stiffness", link->stiffness + n * k, n);
    write_key(out, "damping", link->damping + n * k, n);
    if (isfinite(link->limit[k]))
        fprintf(out, "\"limit\": %.17g, ", link->limit[k]);
    fputs("\"shape\": {", out);
    for (size_t j = 0; j < link->shape_count; j++) {
        fputs(comma(j), out);
        write_text(out, link->shapes[j].joint);
        fputs(": ", out);
        write_numbers(out, link->shapes[j].shape + 6 * k, 6);
    }
    fputs("}}", out);
}

/* As in a side file: totalforce/modes.h */
static void write_modes(FILE *out, const tfa_modes *modes)
{
    fputs("{\"links\": {", out);
    for (size_t i = 0; i < modes->count; i++) {
        const tfa_link_modes *link = &modes->links[i];
        fputs(comma(i), out);
        write_text(out, link->link);
        fputs(": {\"modes\": [", out);
        for (size_t k = 0; k < link->mode_count; k++) {
            fputs(comma(k), out);
            write_mode(out, link, k);
        }
        fputs("]}", out);
    }
    fputs("}}", out);
}

static void write_words(FILE *out, const char *key, const char *const *words, size_t count)
{
    fprintf(out, "\"%s\": [", key);
    for (size_t i = 0; i < count; i++) {
        fputs(comma(i), out);
        write_text(out, words[i]);
    }
    fputs("], ", out);
}

static void write_frame(FILE *out, const char *key, const config_frame *frame)
{
    static const double zeros[3];
    fprintf(out, "\"%s\": {", key);
    write_key(out, "xyz", frame->xyz_count ? frame->xyz : zeros, 3);
    write_key(out, "rpy", frame->rpy_count ? frame->rpy : zeros, 3);
    fputs("\"link\": ", out);
    write_text(out, frame->link ? frame->link : "world");
    fputs("}, ", out);
}

/* As in a side file: totalforce/constraints.h */
static void write_constraints(FILE *out, const config_scene *scene)
{
#define WORD(rows, word) word,
    static const char *const words[] = {TFA_CONSTRAINT_WORDS(WORD)};
#undef WORD
    fputc('{', out);
    write_words(out, "actuated", scene->actuated, scene->actuated_count);
    fputs("\"constraints\": [", out);
    for (size_t i = 0; i < scene->constraints_count; i++) {
        const config_constraint *c = &scene->constraints[i];
        const char *hold[6];
        for (size_t k = 0; k < c->hold_count; k++)
            hold[k] = words[c->hold[k]];
        fprintf(out, "%s{\"name\": ", comma(i));
        write_text(out, c->name);
        fputs(", ", out);
        write_frame(out, "first", &c->first);
        write_frame(out, "second", &c->second);
        write_words(out, "hold", hold, c->hold_count);
        fprintf(out, "\"unilateral\": %s}", c->unilateral ? "true" : "false");
    }
    fputs("]}", out);
}

static void write_scene(FILE *out, const config_scene *scene, const tfa_modes *modes)
{
    fputs("{\"root\": ", out);
    write_text(out, scene->root);
    fputs(", \"tips\": [", out);
    for (size_t i = 0; i < scene->tips_count; i++) {
        fputs(comma(i), out);
        write_text(out, scene->tips[i]);
    }
    fputs("], \"locks\": [", out);
    for (size_t i = 0; i < scene->locked_count; i++) {
        fputs(comma(i), out);
        write_lock(out, &scene->locked[i]);
    }
    fputs("], \"payloads\": [", out);
    for (size_t i = 0; i < scene->payload_count; i++) {
        fputs(comma(i), out);
        write_payload(out, &scene->payload[i]);
    }
    fputs("], \"modes\": ", out);
    write_modes(out, modes);
    fputs(", \"constraints\": ", out);
    write_constraints(out, scene);
    fputc('}', out);
}

static void write_inertias(FILE *out, const char *key, const config_armature *list, size_t count)
{
    fprintf(out, ", \"%s\": [", key);
    for (size_t i = 0; i < count; i++) {
        fprintf(out, "%s{\"joint\": ", comma(i));
        write_text(out, list[i].joint);
        fprintf(out, ", \"value\": %.17g}", list[i].value);
    }
    fputs("]", out);
}

static void write_options(FILE *out, const tfa_robot *robot)
{
    const config_robot *c = robot->config;
    const tfa_model_summary summary = tfa_model_summarise(robot->model);
    fprintf(out,
            "  \"options\": {\"base\": %d, \"rotor_inertia\": %d, \"damping\": %d, "
            "\"friction\": %d, \"friction_velocity\": %.17g, "
            "\"lock_massless_leaves\": %d, \"inertia\": %u, \"mimic\": %u, \"snap\": %.17g,\n"
            "    \"gravity\": ",
            (int)summary.base, c->rotor_inertia, c->damping, c->friction, c->friction_velocity,
            c->lock_massless_leaves, c->inertia, c->mimic, c->snap);
    write_numbers(out, summary.gravity, 3);
    write_inertias(out, "armature", c->armature, c->armature_count);
    write_inertias(out, "rotors", c->rotors, c->rotors_count);
    fputs(",\n    \"scene\": ", out);
    if (robot->scene)
        write_scene(out, robot->scene, &robot->shared->modes);
    else
        fputs("null", out);
    fputs("},\n", out);
}

/* ---- the workspace ---- */

static void write_kernel(FILE *out, const tfa_robot *robot)
{
    fprintf(out, "  \"isa\": \"%s\",\n  \"specialised\": ", tfa_isa_name());
    if (!robot->specialised) {
        fputs("null,\n", out);
        return;
    }
    const tfa_specialised_info info = tfa_specialised_describe(robot->specialised);
    fputs("{\"file\": ", out);
    write_text(out, info.path);
    fputs(", \"digest\": \"", out);
    for (int i = 0; i < 32; i++)
        fprintf(out, "%02x", info.digest[i]);
    fputs("\"},\n", out);
}

static void write_workspace(FILE *out, const tfa_robot *robot)
{
    static const char *const estimates[] = {[CONFIG_ESTIMATE_DEFAULT] = "default",
                                            [CONFIG_ESTIMATE_NEVER] = "never",
                                            [CONFIG_ESTIMATE_ALWAYS] = "always",
                                            [CONFIG_ESTIMATE_SAMPLED] = "sampled"};
    const config_robot *c = robot->config;
    const tfa_wire_shape *s = &robot->shape;
    fprintf(out,
            "  \"precision\": %d, \"residual\": %u, \"all_methods\": %s, \"estimate\": \"%s\",\n",
            c->precision == CONFIG_PRECISION_F32 ? TFA_F32 : TFA_F64, c->residual,
            c->methods == CONFIG_METHODS_ALL ? "true" : "false", estimates[c->estimate]);
    fprintf(out,
            "  \"shape\": {\"q_count\": %u, \"v_count\": %u, \"base_freedoms\": %u, "
            "\"frames\": %u, \"modes\": %u, \"max_batch\": %u, \"max_tips\": %u}\n",
            s->q_count, s->v_count, s->base_freedoms, s->frames, s->modes, s->max_batch,
            s->max_tips);
}

void tfa_robot_describe(const tfa_robot *robot, const char *urdf_name, FILE *out)
{
    fputs("{\n  \"robot\": ", out);
    write_text(out, robot->name);
    fputs(", \"version\": \"" TFA_VERSION "\",\n  \"urdf\": ", out);
    write_text(out, urdf_name);
    fprintf(out, ",\n  \"model\": \"%s\",\n", tfa_model_hash_text(robot->model));
    write_options(out, robot);
    write_kernel(out, robot);
    write_workspace(out, robot);
    fputs("}\n", out);
}
