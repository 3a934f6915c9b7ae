/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The last rows of the partitions, one of each: block cyclic reduction, several rows of a level
 * side by side. Level h = 1, 2, 4 .. < partitions eliminates the rows at odd multiples of h between
 * rows k - h and k + h, after which row 0 stands alone.
 */
#include "dynamics/simd/block_row.h"

/* Which rows a step eliminates, lane by lane, and their neighbours; the column behind the
 * partitions where there is none */
struct step {
    uint32_t row[NUM_LANES], left[NUM_LANES], right[NUM_LANES];
};

static struct step step_of(const struct partition *p, uint32_t first, uint32_t h)
{
    struct step s;
    for (uint32_t l = 0; l < NUM_LANES; l++) {
        const uint32_t k = first + 2 * h * l, none = p->partitions;
        s.row[l] = k < none ? k : none;
        s.left[l] = k < none ? k - h : none;
        s.right[l] = k + h < none ? k + h : none;
    }
    return s;
}

static inline void gather(const struct partition *p, int e, const uint32_t *row, num *x, int count)
{
    for (int k = 0; k < count; k++)
        x[k] = num_gather(p->interface + (size_t)(e + k) * p->width, 1, row);
}

static inline void scatter(const struct partition *p, int e, const uint32_t *row, const num *x,
                           int count)
{
    for (int k = 0; k < count; k++)
        for (uint32_t l = 0; l < NUM_LANES; l++)
            p->interface[(size_t)(e + k) * p->width + row[l]] = num_lane(x[k], l);
}

/* x += the row of the interface arrays, `from` columns on, for all partitions */
static void add_interface(const struct partition *p, int to, int row, int count, uint32_t h,
                          uint32_t on)
{
    for (int k = 0; k < count; k++) {
        double *x = p->interface + (size_t)(to + k) * p->width;
        const double *y = p->interface + (size_t)(row + k) * p->width;
        for (uint32_t l = 0; l + on < p->partitions; l += h)
            x[l] += y[l + on];
    }
}

/* The column of no partition: a row of the identity that nothing couples to */
static void clear_column(const struct partition *p)
{
    for (int e = INTERFACE_D; e < INTERFACE_RATE; e++)
        p->interface[(size_t)e * p->width + p->partitions] = 0;
    for (int k = 0; k < 5; k++)
        p->interface[(size_t)(INTERFACE_D + SYM5(k, k)) * p->width + p->partitions] = 1;
}

static void eliminate_step(const struct partition *p, const struct step *s, struct block_factors *f)
{
    static const struct block_equation none;
    struct block_equation row = none, right = none;
    struct block_update left;
    mat5 U = f->ZU;
    update_clear(&left);
    gather(p, INTERFACE_B, s->row, row.b.x, 5);
    gather(p, INTERFACE_B, s->right, right.b.x, 5);
    if (p->flags & PARTITION_FACTOR) {
        mat5 next;
        gather(p, INTERFACE_D, s->row, row.D.x, 15);
        gather(p, INTERFACE_L, s->row, &row.L.x[0][0], 25);
        gather(p, INTERFACE_L, s->right, &next.x[0][0], 25);
        gather(p, INTERFACE_D, s->right, right.D.x, 15);
        U = m5_t(&next);
    }
    row_factor(&row, &U, f, p->flags);
    row_update(f, &left, &right, p->flags);
    if (p->flags & PARTITION_FACTOR) {
        scatter(p, INTERFACE_D, s->right, right.D.x, 15);
        scatter(p, INTERFACE_L, s->right, &right.L.x[0][0], 25);
        scatter(p, INTERFACE_LEFT_D, s->row, left.D.x, 15);
    }
    scatter(p, INTERFACE_B, s->right, right.b.x, 5);
    scatter(p, INTERFACE_LEFT_B, s->row, left.b.x, 5);
}

static void back_step(const struct partition *p, const struct step *s,
                      const struct block_factors *f)
{
    vec5 left, right;
    gather(p, INTERFACE_B, s->left, left.x, 5);
    gather(p, INTERFACE_B, s->right, right.x, 5);
    const vec5 x = row_back(f, &left, &right);
    scatter(p, INTERFACE_B, s->row, x.x, 5);
}

/* Row 0 when it stands alone */
static void solve_single(const struct partition *p, sym5 *M)
{
    const uint32_t row[NUM_LANES] = {0};
    vec5 x;
    gather(p, INTERFACE_B, row, x.x, 5);
    if (p->flags & PARTITION_FACTOR) {
        gather(p, INTERFACE_D, row, M->x, 15);
        s5_factor(M);
    }
    s5_lower(M, &x);
    s5_scale(M, &x);
    s5_upper(M, &x);
    scatter(p, INTERFACE_B, row, x.x, 5);
}

/* Update of the row on the left of the rows `h` on that were just eliminated */
static void apply_updates(const struct partition *p, uint32_t stride, uint32_t h)
{
    if (p->flags & PARTITION_FACTOR)
        add_interface(p, INTERFACE_D, INTERFACE_LEFT_D, 15, stride, h);
    add_interface(p, INTERFACE_B, INTERFACE_LEFT_B, 5, stride, h);
}

void TFA_V(partition_interface_solve)(struct partition *p)
{
    struct block_factors *f = p->interface_factors;
    uint32_t h;
    clear_column(p);
    apply_updates(p, 1, 1);
    for (h = 1; h < p->partitions; h *= 2) {
        for (uint32_t k = h; k < p->partitions; k += 2 * h * NUM_LANES) {
            const struct step s = step_of(p, k, h);
            eliminate_step(p, &s, f++);
        }
        apply_updates(p, 2 * h, h);
    }
    solve_single(p, &f->M);
    for (h /= 2; h > 0; h /= 2) {
        const uint32_t stride = 2 * h * NUM_LANES,
                       steps = (p->partitions - h + stride - 1) / stride;
        f -= steps;
        for (uint32_t k = 0; k < steps; k++) {
            const struct step s = step_of(p, h + k * stride, h);
            back_step(p, &s, f + k);
        }
    }
}
