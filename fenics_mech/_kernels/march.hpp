// Steps of a cycle: block LU factors of eight steps side by side, and states that go through one step after the other.
//
// Block (i, j) of a step holds its S stages: M + h A C + h^2 A A K between unknown i and unknown j. Unknowns are
// eliminated in an order that is planned once for a pattern, and rows are exchanged inside diagonal blocks alone.
#pragma once
#include <cmath>
#include <cstring>
#include <vector>

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__)  // other C libraries choose no function at run time
#define FOR_EACH_PROCESSOR __attribute__((target_clones("arch=skylake-avx512", "arch=haswell", "default"), flatten))
#else
#define FOR_EACH_PROCESSOR
#endif

namespace march_of_steps {

// The order in which unknowns are eliminated: order (N) gives the unknown of each. Those that unknown k meets later are
// later[first[k]..first[k + 1]]; `to` numbers the blocks between each two of them. Blocks are N of the diagonal, then the
// upper ones (k, j) in that sequence, then the lower ones (j, k). block (entries) is that of every entry of the pattern.
struct Order {
    long N, entries;
    const int *order, *first, *later, *to, *block;
    long above() const { return first[N]; }
    long blocks() const { return N + 2 * above(); }
};

// Entries of the steps: row and column (entries), values (steps, S, entries); A and AA of the tableau; h (steps).
struct Steps {
    const int *row, *column;
    const double *h, *A, *AA, *c, *M, *C, *K;
};

// Invert an S x S matrix by Gauss's and Jordan's method with pivots in columns; false where it is singular.
template <int S>
bool invert(double (&a)[S][S]) {
    double b[S][S] = {};
    for (int i = 0; i < S; i++) b[i][i] = 1;
    for (int k = 0; k < S; k++) {
        int p = k;
        for (int i = k + 1; i < S; i++)
            if (std::fabs(a[i][k]) > std::fabs(a[p][k])) p = i;
        if (!(std::fabs(a[p][k]) > 0)) return false;
        for (int j = 0; j < S; j++) {
            const double x = a[p][j], y = b[p][j];
            a[p][j] = a[k][j], b[p][j] = b[k][j];
            a[k][j] = x, b[k][j] = y;
        }
        const double scale = 1 / a[k][k];
        for (int j = 0; j < S; j++) a[k][j] *= scale, b[k][j] *= scale;
        for (int i = 0; i < S; i++) {
            const double f = a[i][k];
            if (i == k || f == 0) continue;
            for (int j = 0; j < S; j++) a[i][j] -= f * a[k][j], b[i][j] -= f * b[k][j];
        }
    }
    std::memcpy(a, b, sizeof a);
    return true;
}

constexpr int LANES = 8;

template <int S>
using Lanes = double[S][S][LANES];

// Take a product of blocks from a third, or put it there.
template <int S>
void times(const Lanes<S> &a, const Lanes<S> &b, Lanes<S> &c, bool subtract) {
    for (int i = 0; i < S; i++)
        for (int j = 0; j < S; j++) {
            double sum[LANES] = {};
            for (int k = 0; k < S; k++)
                for (int l = 0; l < LANES; l++) sum[l] += a[i][k][l] * b[k][j][l];
            for (int l = 0; l < LANES; l++) c[i][j][l] = subtract ? c[i][j][l] - sum[l] : sum[l];
        }
}

// Factors of LANES steps, of which the last may be repeated. Gives false where a diagonal block is singular.
template <int S>
bool factor_lanes(const Order &p, const Steps &s, const long (&step)[LANES], Lanes<S> *x) {
    const long above = p.above();
    std::memset(x, 0, sizeof(Lanes<S>) * p.blocks());
    for (long e = 0; e < p.entries; e++) {
        Lanes<S> &to = x[p.block[e]];
        for (int i = 0; i < S; i++)
            for (int l = 0; l < LANES; l++) {
                const long at = (step[l] * S + i) * p.entries + e;
                const double h = s.h[step[l]], C = h * s.C[at], K = h * h * s.K[at];
                for (int j = 0; j < S; j++) to[i][j][l] += C * s.A[i * S + j] + K * s.AA[i * S + j];
                to[i][i][l] += s.M[at];
            }
    }
    const int *to = p.to;
    for (long k = 0; k < p.N; k++) {
        for (int l = 0; l < LANES; l++) {
            double one[S][S];
            for (int i = 0; i < S; i++)
                for (int j = 0; j < S; j++) one[i][j] = x[k][i][j][l];
            if (!invert<S>(one)) return false;
            for (int i = 0; i < S; i++)
                for (int j = 0; j < S; j++) x[k][i][j][l] = one[i][j];
        }
        for (long i = p.first[k]; i < p.first[k + 1]; i++) {
            Lanes<S> &lower = x[p.N + above + i], left;
            times<S>(lower, x[k], left, false);
            std::memcpy(lower, left, sizeof left);
            for (long j = p.first[k]; j < p.first[k + 1]; j++) times<S>(left, x[p.N + j], x[*to++], true);
        }
    }
    return true;
}

// Factors of all steps: LU (steps, blocks, S, S). Gives the number of a step that is singular, or -1.
template <int S>
FOR_EACH_PROCESSOR long factor(Order p, Steps s, long steps, double *LU) {
    std::vector<double> work(p.blocks() * S * S * LANES);
    Lanes<S> *x = reinterpret_cast<Lanes<S> *>(work.data());
    for (long first = 0; first < steps; first += LANES) {
        long step[LANES];
        for (int l = 0; l < LANES; l++) step[l] = first + l < steps ? first + l : steps - 1;
        if (!factor_lanes<S>(p, s, step, x)) return first;
        for (int l = 0; l < LANES && first + l < steps; l++) {
            double *of = LU + (first + l) * p.blocks() * S * S;
            for (long b = 0; b < p.blocks(); b++)
                for (int i = 0; i < S * S; i++) of[b * S * S + i] = x[b][i / S][i % S][l];
        }
    }
    return -1;
}

template <int S>
void subtract(const double *block, const double *x, double *y) {
    for (int i = 0; i < S; i++)
        for (int j = 0; j < S; j++) y[i] -= block[i * S + j] * x[j];
}

// Solve with the factors of a step, in place: y (N, S) in the order of elimination.
template <int S>
void solve(const Order &p, const double *LU, double *y) {
    const double *upper = LU + p.N * S * S, *lower = upper + p.above() * S * S;
    for (long k = 0; k < p.N; k++)
        for (long i = p.first[k]; i < p.first[k + 1]; i++) subtract<S>(lower + i * S * S, y + k * S, y + p.later[i] * S);
    for (long k = p.N - 1; k >= 0; k--) {
        double right[S], *x = y + k * S;
        std::memcpy(right, x, sizeof right);
        for (long i = p.first[k]; i < p.first[k + 1]; i++) subtract<S>(upper + i * S * S, y + p.later[i] * S, right);
        const double *inverse = LU + k * S * S;
        for (int i = 0; i < S; i++) {
            x[i] = 0;
            for (int j = 0; j < S; j++) x[i] += inverse[i * S + j] * right[j];
        }
    }
}

// The largest error of a solution whose parts are 1 or -1, over all steps: what eliminating in the planned order loses.
template <int S>
double missed(Order p, Steps s, long steps, const double *LU) {
    std::vector<double> work(p.N * S), known(p.N);
    std::vector<long> place(p.N);
    for (long k = 0; k < p.N; k++) place[p.order[k]] = k, known[k] = k * 7919 % 13 % 2 ? 1 : -1;
    double most = 0;
    for (long step = 0; step < steps; step++) {
        const double h = s.h[step];
        double *b = work.data();
        std::memset(b, 0, sizeof(double) * p.N * S);
        for (int i = 0; i < S; i++) {
            double once = 0, twice = 0;  // the same accelerations at all stages
            for (int j = 0; j < S; j++) once += h * s.A[i * S + j], twice += h * h * s.AA[i * S + j];
            for (long e = 0; e < p.entries; e++) {
                const long at = (step * S + i) * p.entries + e;
                b[place[s.row[e]] * S + i] += (s.M[at] + once * s.C[at] + twice * s.K[at]) * known[s.column[e]];
            }
        }
        solve<S>(p, LU + step * p.blocks() * S * S, b);
        for (long k = 0; k < p.N; k++)
            for (int i = 0; i < S; i++) {
                const double error = std::fabs(b[k * S + i] - known[p.order[k]]);
                most = error > most || std::isnan(error) ? error : most;
            }
    }
    return most;
}

// Take states (columns, 2 n), of coordinates and of rates times `unit`, through all steps under right (steps, S, N), and
// add gaps (steps, 2 n) after each; both may be null. Where blow (steps) is not -1, rates jump after that step by by_q
// (blows, n, n) times the coordinates. Accelerations of the first column (steps, S, N), and the states of all columns
// after each step (steps, columns, 2 n), are written where they are asked for.
template <int S>
FOR_EACH_PROCESSOR void march(Order p, Steps s, const double *LU, long n, double unit, long steps, long columns,
                              const double *right, const double *gaps, const int *blow, const double *by_q,
                              double *state, double *a, double *after) {
    std::vector<double> work(p.N * S), found(p.N * S);
    std::vector<long> place(p.N);
    for (long k = 0; k < p.N; k++) place[p.order[k]] = k;
    for (long step = 0; step < steps; step++) {
        const double *of = LU + step * p.blocks() * S * S, h = s.h[step];
        for (long column = 0; column < columns; column++) {
            double *x = state + column * 2 * n, *y = x + n, *b = work.data();
            for (long r = 0; r < p.N; r++)
                for (int i = 0; i < S; i++) b[place[r] * S + i] = right ? right[(step * S + i) * p.N + r] : 0;
            for (int i = 0; i < S; i++) {
                const double *C = s.C + (step * S + i) * p.entries, *K = s.K + (step * S + i) * p.entries;
                const double ahead = h / unit * s.c[i];
                for (long e = 0; e < p.entries; e++) {
                    const long j = s.column[e];
                    if (j < n) b[place[s.row[e]] * S + i] -= K[e] * (x[j] + ahead * y[j]) + C[e] * y[j] / unit;
                }
            }
            solve<S>(p, of, b);
            for (long k = 0; k < p.N; k++) std::memcpy(&found[p.order[k] * S], b + k * S, sizeof(double) * S);
            if (a && column == 0)
                for (long r = 0; r < p.N; r++)
                    for (int i = 0; i < S; i++) a[(step * S + i) * p.N + r] = found[r * S + i];
            for (long r = 0; r < n; r++) {
                double twice = 0, once = 0;
                for (int i = 0; i < S; i++) {
                    twice += s.AA[(S - 1) * S + i] * found[r * S + i];
                    once += s.A[(S - 1) * S + i] * found[r * S + i];
                }
                x[r] += h / unit * y[r] + h * h * twice;
                y[r] += h * unit * once;
            }
            if (blow[step] >= 0)
                for (long i = 0; i < n; i++)
                    for (long j = 0; j < n; j++) y[i] += unit * by_q[(blow[step] * n + i) * n + j] * x[j];
            if (gaps)
                for (long i = 0; i < 2 * n; i++) x[i] += gaps[step * 2 * n + i];
            if (after) std::memcpy(after + (step * columns + column) * 2 * n, x, sizeof(double) * 2 * n);
        }
    }
}

}  // namespace march_of_steps
