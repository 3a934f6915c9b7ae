/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of `totalforce atlas`: the maps, and one row for each cell, method and mode.
 */
#ifndef TOOLS_ATLAS_ATLAS_H
#define TOOLS_ATLAS_ATLAS_H

#include "chart/chart.h"

enum { ATLAS_METHODS = 32, ATLAS_SIZES = 16, ATLAS_POINTS = 25 };

/* X(NAME, word, mechanism, what varies: a member of mechanism_options, first and last value,
 *   axis, what it is). Values are evenly spaced in their logarithm; on an axis that begins at 0
 *   they
 *   are the squares of equal steps, close together where the chain is straight. */
#define ATLAS_MAP_LIST(X)                                                                          \
    X(RATIO, "ratio", ALTERNATING, ratio, 1, 1e12, "mass ratio of neighbours",                     \
      "every second body is heavier")                                                              \
    X(HEAVY_TIP, "heavy-tip", HEAVY_TIP, ratio, 1, 1e12, "mass of the tip / mass of a body",       \
      "the last body is heavier")                                                                  \
    X(LIGHT_HEAVY, "light-heavy", LIGHT_HEAVY, ratio, 1, 1e12, "mass ratio of the halves",         \
      "the outboard half is heavier")                                                              \
    X(THIN, "thin", THIN, radius, 1, 1e-6, "radius of the rods / length", "thin rods")             \
    X(TAPER, "taper", TAPER, taper, 1, 1e-12, "mass of the tip / mass of the root",                \
      "masses fall from root to tip")                                                              \
    X(CURL, "curl", HELIX, curl, 0, 1, "bend (1: 21° a joint)", "from straight to a helix")

typedef enum atlas_map {
#define ATLAS_MAP_ENUM(name, word, kind, member, first, last, axis, what) ATLAS_##name,
    ATLAS_MAP_LIST(ATLAS_MAP_ENUM)
#undef ATLAS_MAP_ENUM
        ATLAS_MAP_COUNT
} atlas_map;

/* X(NAME, word, what) */
#define ATLAS_MODE_LIST(X)                                                                         \
    X(PLAIN, "plain", "the method alone: no refinement, no estimate, no fallback")                 \
    X(REFINED, "refined", "after one refinement step, whatever becomes of it")                     \
    X(SERVICE, "service", "the answer to a request with default refinement and estimate")          \
    X(ESTIMATED, "estimated", "the same with estimate always")

typedef enum atlas_mode {
#define ATLAS_MODE_ENUM(name, word, what) ATLAS_##name,
    ATLAS_MODE_LIST(ATLAS_MODE_ENUM)
#undef ATLAS_MODE_ENUM
        ATLAS_MODE_COUNT
} atlas_mode;

extern const char *const atlas_map_words[ATLAS_MAP_COUNT];
extern const char *const atlas_mode_words[ATLAS_MODE_COUNT];

typedef struct atlas_options {
    uint32_t maps;   /**< bit set of atlas_map */
    uint32_t points; /**< along the axis of a map */
    uint32_t sizes[ATLAS_SIZES], size_count;
    uint32_t methods[ATLAS_METHODS], method_count;
    chart_rhs rhs;
    uint32_t states; /**< of each cell and seed */
    uint32_t seeds;  /**< of each cell: seed, seed + 1, ... */
    uint64_t seed;
    int json;
    const char *folder;  /**< for rows and pictures; NULL: rows on standard output only */
    const char *html;    /**< file of the page; NULL: none */
    const char *scripts; /**< folder of the gnuplot scripts; NULL: beside the program */
    char *command;       /**< the command line, for the head */
} atlas_options;

/** Fills in the options; a usage error ends the program. @return 0 or an errno */
int atlas_parse(int argc, char **argv, atlas_options *options);

/** Value number `point` of `points` along the axis of a map. */
double atlas_value(atlas_map map, uint32_t point, uint32_t points);
/** The mechanism of a cell. */
mechanism_options atlas_mechanism(atlas_map map, double value, uint32_t bodies, uint64_t seed);
const char *atlas_axis(atlas_map map);
const char *atlas_map_text(atlas_map map);

/** One method in one cell and mode, over all states. */
typedef struct atlas_row {
    atlas_map map;
    uint32_t point, bodies;
    double value;
    uint32_t method;
    atlas_mode mode;
    uint32_t by_method, fallback, refused; /**< states that were answered so */
    int status;                            /**< of the first state that was not answered */
    char field[64];                        /**< its subject */
    uint32_t answered_by;                  /**< tfa_method: after a fallback another one */
    uint32_t reason;                       /**< TFA_ANSWER_ flags of the first fallback */
    double error; /**< relative 2-norm, median over the states, infinite where there is none */
    double error_low, error_high; /**< least and largest of the seeds' errors */
    double worst;                 /**< largest over the states that were answered */
    double estimate;              /**< as replied, median; NaN: not estimated */
    double over;         /**< largest error / estimate among errors above ATLAS_ROUNDING; 0: none */
    uint32_t worst_by;   /**< tfa_method that answered the worst of them */
    uint32_t estimated;  /**< states with an estimate */
    uint32_t unreported; /**< states wrong by more than ATLAS_FAILED, without an estimate */
    uint32_t silent;     /**< states whose error is above 1e-6 and estimated below 1e-7 */
    double floor;        /**< of the data */
    uint64_t bits;       /**< hash of all bits of all answers */
    /** tfa_method of an earlier row of the cell and mode that was answered by itself as this one
     * was, to the last bit; 0: none */
    uint32_t same_as;
} atlas_row;

/* Below it the estimate is rounding, too. */
#define ATLAS_ROUNDING 1e-13
/* The promise: an estimate is never less than a thirtieth of the error. */
#define ATLAS_UNDERESTIMATE_MAX 30.0
/* A larger error is a failure, unless the data themselves allow no better: the threshold of the
 * library's own fallback. */
#define ATLAS_FAILED 1e-4
#define ATLAS_FAR_FROM_FLOOR 100.0 /* times the floor */

/** Fills in a row whose map, value, method and mode are set. */
void atlas_measure(atlas_row *row, chart_case *c, const chart_data *d);

/** Puts the rows of several seeds, `stride` rows apart, together in the first: sums of states,
 * medians of errors, estimates and floors, and the worst of the worst. */
void atlas_combine_seeds(atlas_row *first, size_t stride, uint32_t seeds);

/** Sets same_as in the rows of one cell. */
void atlas_find_same(atlas_row *rows, size_t count);

/** Most states were not answered by the method asked for. */
int atlas_fell_back(const atlas_row *row);
int atlas_refused(const atlas_row *row);
/** Wrong by more than ATLAS_FAILED although the data allow better, or not finite. */
int atlas_failed(const atlas_row *row);

/** Summary of all rows */
typedef struct atlas_summary {
    uint64_t answers[ATLAS_MODE_COUNT][3]; /**< states: own, fallback, refused */
    uint64_t unreported;                   /**< states of the service */
    uint64_t silent;                       /**< states, any mode with an estimate */
    uint64_t estimates;                    /**< states with estimate always that had one */
    /** cells and methods with an estimate below error / ATLAS_UNDERESTIMATE_MAX */
    uint64_t broken;
    const atlas_row *over; /**< largest error / estimate; NULL: none to speak of */
    /** largest error_high / error_low of a method alone, failing somewhere */
    const atlas_row *spread;
    const atlas_row *worst; /**< largest error of an answer of the service */
    const atlas_row *far;   /**< the same over the floor of the data, above ATLAS_ROUNDING */
} atlas_summary;

atlas_summary atlas_summarise(const atlas_row *rows, size_t count);
/** Whether every promise was kept; the others are told on stderr. */
int atlas_promises_kept(const atlas_summary *summary, const atlas_row *rows, size_t count);
/** One sentence a line, each after `prefix`: failures of methods, answers of the service. */
void atlas_print_estimates(FILE *out, const char *prefix, const atlas_summary *summary);
void atlas_print_summary(FILE *out, const char *prefix, const atlas_row *rows, size_t count);

/** "1e6": two digits, and no more of an exponent than it needs. */
void atlas_short(char *text, size_t size, double value);
/** Rows of the map that `rows` begins with. */
size_t atlas_same_map(const atlas_row *rows, size_t count);

void atlas_print_head(FILE *out, const atlas_options *options, const atlas_row *rows, size_t count);
void atlas_print_row(FILE *out, const atlas_options *options, const atlas_row *row);
void atlas_print_row_json(FILE *out, const atlas_options *options, const atlas_row *row);

/** The method that answered: nothing for the method itself, a question mark if it is wrong and has
 * no estimate, the first letter of another one, a cross for none. Alone: an equals sign for the
 * same answers. */
const char *atlas_mark(const atlas_row *row, char letter[2]);

/** Writes the page and closes its file. @return an exit status; the reason stands on stderr */
int atlas_page(FILE *out, const atlas_options *options, const atlas_row *rows, size_t count);

/** Draws a page for each map into options->folder. @return an exit status; the reason stands on
 * stderr */
int atlas_draw(const atlas_options *options, const atlas_row *rows, size_t count);

#endif
