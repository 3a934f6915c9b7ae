/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan by a tree: up with combined elements, down with what is beyond each of them.
 */
#include "scan_tree.h"

#include <vector>

#include "dynamics/scan/scan.h"

namespace
{
/* Force that a part passes on, by the acceleration of its end: f_out = J a_out + g */
struct beyond {
    num J[MAT6_PADDED];
    svec g;
};

/* A part of the chain at rest and how it yields: scan_combine.h. Its end knows of the inertia
 * `known` beyond it, so that f_out means what is left of that force. */
struct element {
    scan_element at;
    svec v, g;
    num seed[MAT6_PADDED];
};

beyond left_of(const element &x, beyond b)
{
    for (int k = 0; k < 36; k++)
        b.J[k] -= x.seed[k];
    return b;
}

svec times(const num *M, svec x)
{
    num in[6], out[6];
    sv_store(in, x);
    m6_apply(out, M, in);
    return sv_from(out);
}

svec times_t(const num *M, svec x)
{
    num T[36];
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            T[6 * i + j] = M[6 * j + i];
    return times(T, x);
}

svec solved(const mat6_rows_lu &E, svec x)
{
    num in[6];
    sv_store(in, x);
    mat6_rows_lu_solve_vec(&E, in);
    return sv_from(in);
}

/* a_out - E^-1 A a_in of x with that beyond its end */
svec drift(const element &x, const mat6_rows_lu &E, const beyond &b)
{
    return solved(E, sv_sub(x.v, times(x.at.C, b.g)));
}

/* A^T (g + J w): how what is beyond is felt before x */
svec felt(const element &x, const beyond &b, svec w)
{
    return sv_add(x.g, times_t(x.at.A, sv_add(b.g, times(b.J, w))));
}

beyond as_beyond(const element &x)
{
    beyond b;
    for (int k = 0; k < 36; k++)
        b.J[k] = x.at.J[k];
    b.g = x.g;
    return b;
}

/* x and what is beyond its end, seen from before it */
beyond closed(const element &x, const beyond &all)
{
    const beyond b = left_of(x, all);
    mat6_rows_lu E;
    (void)scan_factor_interface(&E, x.at.C, b.J);
    beyond sum;
    num EA[MAT6_PADDED];
    sum.g = felt(x, b, drift(x, E, b));
    scan_attach(&x.at, &E, b.J, EA, sum.J);
    return sum;
}

svec end_acceleration(const element &x, svec a_in, const beyond &all)
{
    const beyond b = left_of(x, all);
    mat6_rows_lu E;
    (void)scan_factor_interface(&E, x.at.C, b.J);
    return sv_add(drift(x, E, b), solved(E, times(x.at.A, a_in)));
}

/* One element of two neighbours (scan_combine.h) */
element joined(const element &in, const element &out)
{
    const beyond b = left_of(in, as_beyond(out));
    mat6_rows_lu E;
    row6 rows[6], other[6];
    num At[MAT6_PADDED], EA[MAT6_PADDED];
    (void)scan_factor_interface(&E, in.at.C, b.J);
    const svec w = drift(in, E, b);
    element sum = in;
    sum.g = felt(in, b, w);
    sum.v = sv_add(out.v, times(out.at.A, w));
    scan_attach(&in.at, &E, b.J, EA, sum.at.J);
    mat6_rows_load(rows, in.at.C);
    mat6_rows_lu_solve(&E, rows);
    mat6_rows_store(sum.at.C, rows);
    m6_symmetrise(sum.at.C);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            At[6 * i + j] = out.at.A[6 * j + i];
    mat6_rows_load(rows, At);
    mat6_rows_mul(other, sum.at.C, rows);
    mat6_rows_mul(rows, out.at.A, other);
    mat6_rows_store(sum.at.C, rows);
    for (int k = 0; k < 36; k++)
        sum.at.C[k] += out.at.C[k];
    mat6_rows_load(rows, EA);
    mat6_rows_mul(other, out.at.A, rows);
    mat6_rows_store(sum.at.A, other);
    for (int k = 0; k < 36; k++)
        sum.seed[k] = out.seed[k];
    return sum;
}

class tree
{
  public:
    explicit tree(scan *scan) : scan_(scan), nodes_(4 * (size_t)scan->segments) {}
    void up()
    {
        up(1, 0, scan_->segments);
    }
    void down(svec a_in)
    {
        beyond nothing;
        for (int k = 0; k < 36; k++)
            nothing.J[k] = 0;
        nothing.g = sv_zero();
        down(1, 0, scan_->segments, a_in, nothing);
    }

  private:
    void up(size_t node, uint32_t first, uint32_t end)
    {
        if (end - first == 1) {
            const scan_segment &segment = scan_->segment[first];
            element &leaf = nodes_[node];
            leaf.at = segment.at;
            leaf.v = segment.v;
            leaf.g = segment.g;
            for (int k = 0; k < 36; k++) /* beyond the last one is nothing */
                leaf.seed[k] = end < scan_->segments ? segment.seed[k] : num(0);
            return;
        }
        const uint32_t middle = first + (end - first) / 2;
        up(2 * node, first, middle);
        up(2 * node + 1, middle, end);
        nodes_[node] = joined(nodes_[2 * node], nodes_[2 * node + 1]);
    }
    void down(size_t node, uint32_t first, uint32_t end, svec a_in, const beyond &b)
    {
        if (end - first == 1) {
            scan_segment &segment = scan_->segment[first];
            const svec a_out = end_acceleration(nodes_[node], a_in, b);
            segment.a_in = a_in;
            segment.f_out = sv_add(b.g, times(left_of(nodes_[node], b).J, a_out));
            return;
        }
        const uint32_t middle = first + (end - first) / 2;
        const beyond inner = closed(nodes_[2 * node + 1], b);
        down(2 * node, first, middle, a_in, inner);
        down(2 * node + 1, middle, end, end_acceleration(nodes_[2 * node], a_in, inner), b);
    }
    scan *scan_;
    std::vector<element> nodes_;
};

} // namespace

void scan_tree(state *s, const tfa_chain *chain, void *rows, const num *tau, num *qdd)
{
    scan *scan = TFA_V(scan_layout)(rows, chain->length);
    (void)TFA_V(chain_reduce_branches)(s, chain, 0);
    TFA_V(scan_cut)(s, chain, scan);
    for (uint32_t k = 0; k < chain->length; k++) {
        scan->body[k].I = s->IA[chain->body[k]];
        s->pA[chain->body[k]] = s->moving ? s->p[chain->body[k]] : sv_zero();
    }
    for (uint32_t k = scan->segments; k-- > 0;)
        TFA_V(scan_segment_factor)(s, chain, scan, &scan->segment[k], nullptr);
    for (uint32_t k = scan->segments; k-- > 0;)
        TFA_V(scan_segment_inward)(s, chain, scan, &scan->segment[k], tau, 1);
    tree t(scan);
    t.up();
    t.down(chain_ground(s, 1));
    for (uint32_t k = 0; k < scan->segments; k++)
        TFA_V(scan_segment_outward)(s, chain, scan, &scan->segment[k], qdd, 1);
}
