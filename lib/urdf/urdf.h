/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Passes of the URDF front end, in their order:
 *
 *   check_xml  bytes -> tags: well-formed, bounded, nothing that TinyXML fails on
 *   lint       tags -> skeleton description (names, lines, tree, rotations) and canonical text;
 *              of MJCF by mjcf_reader
 *   graph      the skeleton is one tree, and its mimics end
 *   fill       canonical text -> urdfdom -> the other numbers of the description
 *   inertia    warnings about inertias that no real body has
 *   notes      notes about links that are only frames
 *
 * urdfdom reads the canonical text only: the elements that a description needs, each checked by
 * lint, with numbers spelled as in the file.
 */
#ifndef TFA_URDF_URDF_H
#define TFA_URDF_URDF_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/description.h>
#include <totalforce/report.h>
#include <totalforce/text.h>

#ifdef __cplusplus
extern "C" {
#define TFA_NOEXCEPT noexcept
#else
#define TFA_NOEXCEPT
#endif

enum {
    TFA_URDF_MAX_BYTES = 64 << 20,
    TFA_URDF_MAX_LINKS = 100000,
    TFA_URDF_MAX_NAME = 255,
    TFA_URDF_MAX_DEPTH = 200,     /* TinyXML recurses once for each level; real files have 8 */
    TFA_URDF_MAX_NODES = 5000000, /* elements and attributes: TinyXML takes 0.2 KiB for each */
    TFA_URDF_MAX_ATTRIBUTES = 64, /* of one element: TinyXML compares all of them */
    TFA_URDF_MAX_REPEATS = 100,   /* listed messages of one code */
    TFA_URDF_MAX_CODES = 64
};

/* Rows of a text that came from a file which it includes (include.cpp) */
typedef struct tfa_urdf_span {
    uint32_t row;  /* of the <include> */
    uint32_t rows; /* line ends of the included text */
    const char *file;
} tfa_urdf_span;

/* Sink of the passes' messages; bounds their number. */
typedef struct tfa_urdf_log {
    tfa_report *report;
    const tfa_urdf_span *spans; /* in document order; lines of messages are rows while there are
                                   any */
    size_t span_count;
    size_t errors; /* of this file: the report may hold older ones */
    size_t code_count;
    struct {
        const char *code;
        tfa_severity severity;
        size_t count;
    } codes[TFA_URDF_MAX_CODES];
} tfa_urdf_log;

/* As tfa_report_add; lists each code TFA_URDF_MAX_REPEATS times and counts the rest. */
void tfa_urdf_report(tfa_urdf_log *log, tfa_severity severity, uint32_t line, const char *code,
                     const char *format, ...) TFA_NOEXCEPT __attribute__((format(printf, 5, 6)));

/* Line in the main file of a row, and "FILE:LINE: " of an included file, or "". */
uint32_t tfa_urdf_place(const tfa_urdf_log *log, uint32_t row, char *prefix,
                        size_t size) TFA_NOEXCEPT;

/* Adds a message with the number of those not listed. */
void tfa_urdf_report_repeats(tfa_urdf_log *log);

/* Checks that `text` is well-formed XML within the limits, and copies its tags to `clean` (length +
 * 1 bytes). Everything else becomes blanks, except line ends, so that line numbers stay valid. */
int tfa_urdf_check_xml(const char *text, size_t length, char *clean, tfa_urdf_log *log);

/* A quaternion x y z w: quat + low */
typedef struct tfa_rotation {
    double quat[4];
    double low[4];
} tfa_rotation;

/* R = Rz(yaw) Ry(pitch) Rx(roll) of the three angles, rad */
void tfa_rotation_from_rpy(const double rpy[3], tfa_rotation *rotation);

/* Normalises a quaternion. Returns its norm; with 0, *rotation stays. */
double tfa_rotation_from_xyzw(const double xyzw[4], tfa_rotation *rotation);

/* R = A B; the inverse of R */
void tfa_rotation_product(const tfa_rotation *a, const tfa_rotation *b, tfa_rotation *product);
void tfa_rotation_inverse(const tfa_rotation *r, tfa_rotation *inverse);

/* A rotation that takes z to a unit axis */
void tfa_rotation_from_z(const double axis[3], tfa_rotation *rotation);

/* axis = R^T axis */
void tfa_rotate_back(const tfa_rotation *r, double axis[3]);

/* The text without white space around it, and its length. */
const char *tfa_urdf_strip(const char *text, size_t *length);

/* Makes axis + low a unit vector. Returns the previous length; a zero vector stays. */
double tfa_axis_normalise(double axis[3], double low[3]);

/* Reads a file; errno with TFA_E_FILE. */
int tfa_urdf_read_path(const char *path, char **text, size_t *length) TFA_NOEXCEPT;

/* Replaces the <include>s of MJCF by their files, so that the text stands alone: each becomes
 * <include file="NAME" lines="line ends">TEXT</include>. Other texts stay. */
int tfa_mjcf_include(const char *path, char **text, size_t *length,
                     tfa_report *report) TFA_NOEXCEPT;

/* Makes the skeleton (one malloc block) and the canonical text (malloc, terminated). */
int tfa_urdf_lint(const char *clean, tfa_urdf_log *log, tfa_description **skeleton,
                  char **canonical) TFA_NOEXCEPT;

int tfa_urdf_graph(const tfa_description *description, tfa_urdf_log *log);

int tfa_urdf_fill(const char *canonical, tfa_description *description,
                  tfa_urdf_log *log) TFA_NOEXCEPT;

void tfa_urdf_inertia(const tfa_description *description, tfa_urdf_log *log);

void tfa_urdf_notes(const tfa_description *description, tfa_urdf_log *log);

#ifdef __cplusplus
}
#endif
#endif
