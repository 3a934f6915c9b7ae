/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Text of every interface: numbers, which are accepted as a whole or refused; words of enums; names
 * of joints and links, and the nearest ones to a mistyped name; a refused request as a sentence.
 * No function keeps state: any thread. Only tfa_names_of_ functions allocate.
 */
#ifndef TOTALFORCE_TEXT_H
#define TOTALFORCE_TEXT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/client.h>
#include <totalforce/model.h>
#include <totalforce/request.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Result of reading a number. */
typedef enum tfa_number_fault {
    TFA_NUMBER_OK,
    TFA_NUMBER_MALFORMED, /**< not a decimal number, or longer than 399 characters */
    TFA_NUMBER_UNDERFLOW, /**< not 0, but rounded to 0 in double precision */
    TFA_NUMBER_OVERFLOW,  /**< larger than any double, or than 2^64 - 1 */
} tfa_number_fault;

/**
 * Reads a decimal number: sign, digits with an optional point, optional exponent. No blanks, no
 * hexadecimal, no "nan" or "inf". The same in every locale, correctly rounded.
 *
 * @param text    `length` bytes; needs no terminator
 * @param length  of text, bytes
 * @param number  written with TFA_NUMBER_OK only
 */
TFA_API tfa_number_fault tfa_number_read(const char *text, size_t length, double *number);

/**
 * Reads a whole number: decimal digits without sign and leading zero.
 *
 * @param text    `length` bytes; needs no terminator
 * @param length  of text, bytes
 * @param number  written with TFA_NUMBER_OK only
 */
TFA_API tfa_number_fault tfa_whole_number_read(const char *text, size_t length, uint64_t *number);

/** Returns name number `index` of a list. */
typedef const char *(*tfa_list_name)(const void *list, size_t index);

/**
 * Writes the names of a list that are most similar to `wrong`, at most three, the nearest first:
 * "'a', 'b', 'c'", or "none" for an empty list; of a word that other libraries or ROS have for
 * names of the list (qd, effort, ddq) those names alone. Distance: insertions, deletions,
 * replacements and exchanges of neighbours (Damerau, Comm. ACM 7(3), 1964; restricted form), on the
 * first 96 bytes. Cost: O(count).
 *
 * @param wrong  the name that was not found
 * @param list   handed to name
 * @param count  names in the list
 * @param name   reads a name of `list`
 * @param text   gets as much as fits of it, terminated; size > 0
 * @param size   of text, bytes
 */
TFA_API void tfa_suggest(const char *wrong, const void *list, size_t count, tfa_list_name name,
                         char *text, size_t size);

/**
 * Writes which words there are: "there are a, b, c"; of more than six also the
 * nearest as tfa_suggest: "nearest: 'b', 'a', 'c'; there are a, b, c, ...". Cost: O(count).
 */
TFA_API void tfa_suggest_words(const char *wrong, const char *const *words, size_t count,
                               char *text, size_t size);

/**
 * Returns the name of a list that `wrong` misspells: the nearest within distance 1, or 2 for names
 * of six letters or more, without regard to case (ASCII); NULL if there is none. Distance and cost
 * as tfa_suggest.
 */
TFA_API const char *tfa_misspelled(const char *wrong, const void *list, size_t count,
                                   tfa_list_name name);

/** Enums with words. */
typedef enum tfa_words {
    TFA_WORDS_SEVERITY,   /**< tfa_severity, TFA_SEVERITY_WORDS */
    TFA_WORDS_JOINT_TYPE, /**< tfa_joint_type, TFA_JOINT_TYPE_WORDS */
    TFA_WORDS_BASE,       /**< tfa_base, TFA_BASE_WORDS */
    TFA_WORDS_INERTIA,    /**< tfa_inertia_policy, TFA_INERTIA_WORDS */
    TFA_WORDS_MIMIC,      /**< tfa_mimic_policy, TFA_MIMIC_WORDS */
    TFA_WORDS_FATE,       /**< tfa_fate, TFA_FATE_WORDS */
    TFA_WORDS_OP,         /**< tfa_op, TFA_OP_WORDS */
    TFA_WORDS_ESTIMATE,   /**< tfa_estimate, TFA_ESTIMATE_WORDS */
    TFA_WORDS_FRAME,      /**< tfa_reference_frame, TFA_FRAME_WORDS */
    TFA_WORDS_ROWS,       /**< tfa_rows, TFA_ROWS_WORDS */
    TFA_WORDS_RANK_LOSS,  /**< tfa_rank_loss, TFA_RANK_LOSS_WORDS */
    TFA_WORDS_PRECISION,  /**< tfa_precision, TFA_PRECISION_WORDS */
    TFA_WORDS_RESIDUAL,   /**< tfa_residual, TFA_RESIDUAL_WORDS */
    TFA_WORDS_WAIT,       /**< tfa_wait, TFA_WAIT_WORDS */
    TFA_WORDS_ALGORITHM,  /**< tfa_specialise_algorithm, TFA_ALGORITHM_WORDS */
} tfa_words;

/** Word of a value, "project" of TFA_MIMIC_PROJECT; "unknown" of any other number. Static. */
TFA_API const char *tfa_word(tfa_words of, uint32_t value);
/** Value of a word; -1 if the enum has no such word. */
TFA_API int32_t tfa_word_find(tfa_words of, const char *word);
/** Words by value, `count` of them; NULL for a value that the enum does not have. Static. */
TFA_API const char *const *tfa_word_list(tfa_words of, uint32_t *count);

/** A moving joint and its places in q and in v, tau, qdd. */
typedef struct tfa_joint_span {
    const char *name;   /**< as long as the model or the connection */
    int32_t quaternion; /**< coordinate of the joint that is the first of x y z w; -1: none */
    uint32_t q_index;   /**< first of its coordinates in q */
    uint32_t q_count;   /**< number of them */
    uint32_t v_index;   /**< first of its freedoms in v, tau and qdd */
    uint32_t v_count;   /**< number of them */
} tfa_joint_span;

/** Names and sizes of one robot, from its model or from a daemon's description. */
typedef struct tfa_names {
    const char *robot;      /**< name of the robot */
    uint32_t q_count;       /**< as tfa_model_q_count */
    uint32_t v_count;       /**< as tfa_model_v_count */
    uint32_t base_freedoms; /**< as tfa_model_base_freedoms */
    uint32_t joint_count;   /**< length of joints */
    uint32_t frame_count;   /**< length of frames */
    uint32_t mode_count;    /**< length of mode_frames */
    uint32_t constraint_count; /**< length of constraints */
    tfa_joint_span *joints; /**< in declared order */
    const char **frames;    /**< link names; the index is the frame index */
    uint32_t *by_name;      /**< joints, then frames, each in the order of their names */
    uint32_t *mode_frames;  /**< of each modal coordinate, the frame index of its link */
    const char **constraints; /**< names; the index is the bit in tfa_request.constraints */
} tfa_names;

/** Names of a model, which must outlive them. @return TFA_OK, TFA_E_MEMORY (empty). */
TFA_API TFA_CHECKED int tfa_names_of_model(tfa_names *names, const tfa_model *model);
/** Names of the robot of a connection, which must outlive them. @return TFA_OK, TFA_E_MEMORY,
 *  TFA_E_PROTOCOL (the joints do not add up to q_count and v_count, or there are more than
 *  TFA_MAX_CONSTRAINTS constraints); empty on an error. */
TFA_API TFA_CHECKED int tfa_names_of_info(tfa_names *names, const char *robot,
                                          const tfa_client_info *info);
/** Releases the memory and leaves the names empty. */
TFA_API void tfa_names_free(tfa_names *names);

/** Index of a joint, or -1. Cost: O(log joint_count). */
TFA_API int32_t tfa_names_joint(const tfa_names *names, const char *name);
/** Index of the frame of a link, or -1. Cost: O(log frame_count). */
TFA_API int32_t tfa_names_link(const tfa_names *names, const char *name);
/** Index of a constraint, or -1. Cost: O(constraint_count). */
TFA_API int32_t tfa_names_constraint(const tfa_names *names, const char *name);
/** Writes "no moving joint 'WRONG'; nearest: 'a', 'b', 'c'; the robot has 7 joints (a, b, ...)". */
TFA_API void tfa_names_unknown_joint(const tfa_names *names, const char *wrong, char *text,
                                     size_t size);
/** Writes "no link 'WRONG' in the robot; nearest: 'a', 'b', 'c'". */
TFA_API void tfa_names_unknown_link(const tfa_names *names, const char *wrong, char *text,
                                    size_t size);
/** Writes "no constraint 'WRONG'; nearest: 'a', 'b', 'c'; the robot has 2 constraints (a, b)". */
TFA_API void tfa_names_unknown_constraint(const tfa_names *names, const char *wrong, char *text,
                                          size_t size);
/** Writes which constraints there are: "2 constraints (a, b)", "no constraints; `constraints` of
 *  its scene give it some". As snprintf. */
TFA_API size_t tfa_names_describe_constraints(const tfa_names *names, char *text, size_t size);
/** Constraint that place k, counted from 0, among the bits of `constraints` stands for:
 *  the block of six numbers k of an array by constraint; "?" if there is none. */
TFA_API const char *tfa_names_active(const tfa_names *names, uint32_t constraints, uint32_t k);
/** Name of the link of a frame; "?" if there is none. */
TFA_API const char *tfa_names_frame(const tfa_names *names, uint32_t frame);
/** The joint that owns number `index` of q (of_q) or of v, tau, qdd; NULL if there is none. */
TFA_API const tfa_joint_span *tfa_names_owner(const tfa_names *names, int of_q, uint32_t index);
/** Writes what q (of_q) or v, tau and qdd hold: "7 joints (a, b, ...)", "9 coordinates in 3 joints
 *  (a, b, c)". As snprintf. */
TFA_API size_t tfa_names_describe(const tfa_names *names, int of_q, char *text, size_t size);

/** Where a refused request is wrong. */
typedef struct tfa_place {
    const char *field;    /**< key in JSON and Python; "": none */
    const char *joint;    /**< that owns the entry; NULL: none */
    const char *link;     /**< that the entry names; NULL: none */
    const char *constraint; /**< that owns the entry; NULL: none */
    const double *number; /**< the entry, in the request; NULL: it is no number of an array */
} tfa_place;

/** Place of a refusal; the reply has its index and state. */
TFA_API tfa_place tfa_refused_place(const tfa_names *names, const tfa_request *request,
                                    const tfa_reply *reply);

/**
 * Writes why a request was refused: the entry, its joint or link, its value, the reason and the
 * remedy, options spelt as in `syntax`, fields as in JSON. As snprintf.
 *
 * @param names    of the robot
 * @param request  that was refused; its arrays are read for the value
 * @param reply    with the status, field, index and state of the refusal
 * @param syntax   of the interface in use
 * @param text     gets as much as fits of it, terminated if size > 0
 * @param size     of text, bytes
 */
TFA_API size_t tfa_explain(const tfa_names *names, const tfa_request *request,
                           const tfa_reply *reply, tfa_option_syntax syntax, char *text,
                           size_t size);

#ifdef __cplusplus
}
#endif

#endif
