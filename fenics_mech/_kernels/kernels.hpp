// The loops over instants and elements, for the plane and for space. Arrays are contiguous; T instants come first.
#pragma once
#include <cstring>
#include "measures.hpp"

// Motion of all poses, (T, poses, ...): absolute places, chart vectors, rotations of the charts.
struct Poses {
    long count;
    const double *r, *c, *R0;
};

template <class G, class Values>
void over_ends(long T, long E, const Poses &p, const int *pose, const double *arms, const Values &values) {
    constexpr int d = G::d, n = G::turns;
    for (long t = 0; t < T; t++)
        for (long e = 0; e < E; e++) {
            const long a = t * p.count + pose[2 * e], b = t * p.count + pose[2 * e + 1];
            values(t * E + e, e, Ends<G>(p.r + a * d, p.r + b * d, p.c + a * n, p.c + b * n, p.R0 + a * d * d,
                                         p.R0 + b * d * d, arms + e * 2 * (d + d * d)));
        }
}

template <int N>
void put(const Jet<N> &x, long at, double *v, double *g, double *h) {
    v[at] = x.v;
    std::memcpy(g + at * N, x.g, sizeof x.g);
    std::memcpy(h + at * Jet<N>::pairs, x.h, sizeof x.h);
}

// Strains of E beams, with par of 1 + 3 bends numbers each: v (T, E, strains), with gradients and Hessians.
template <class G>
void beam_strains(long T, long E, Poses p, const int *pose, const double *arms, const double *par, double *v, double *g,
                  double *h) {
    constexpr int m = G::strains;
    over_ends<G>(T, E, p, pose, arms, [&](long at, long e, const Ends<G> &ends) {
        typename Ends<G>::Number s[m];
        strains<G>(ends, par + e * (1 + 3 * G::bends), s);
        for (int i = 0; i < m; i++) put(s[i], at * m + i, v, g, h);
    });
}

// Strains of E beams with m places inside, of the lengths par: pose (E, 2 + m), arms of both ends; table of `points`.
template <class G, int m>
void inner_strains(long T, long E, Poses p, const int *pose, const double *arms, const double *par, long points,
                   const double *table, double *v, double *g, double *h) {
    using I = Inner<G, m>;
    constexpr int d = G::d, k = G::turns;
    for (long t = 0; t < T; t++)
        for (long e = 0; e < E; e++) {
            const double *r[2 + m], *c[2 + m], *R0[2 + m];
            for (int j = 0; j < 2 + m; j++) {
                const long a = t * p.count + pose[(2 + m) * e + j];
                r[j] = p.r + a * d, c[j] = p.c + a * k, R0[j] = p.R0 + a * d * d;
            }
            typename I::Number s[I::strains];
            I::strained(r, c, R0, arms + e * 2 * (d + d * d), par[e], points, table, s);
            for (int i = 0; i < I::strains; i++) put(s[i], (t * E + e) * I::strains + i, v, g, h);
        }
}

// One measure of each of E pairs of ends, coded by (measure, i, j); `before` (T, E) holds angles near by.
template <class G>
void relations(long T, long E, Poses p, const int *pose, const double *arms, const int *code, const double *before,
               double *v, double *g, double *h) {
    over_ends<G>(T, E, p, pose, arms, [&](long at, long e, const Ends<G> &ends) {
        put(relation(ends, code[3 * e], code[3 * e + 1], code[3 * e + 2], before[at]), at, v, g, h);
    });
}

// What E pins look at on the elements on which they may ride: pose (E, 3), arms of both ends and of the pin, a Riding of
// each; strokes at both ends, length and length over stiffness of each element (E, 2); pulls (T, E, 2). The gradient g is
// that of v, the gradient f and the Hessian h are those of the work. soft (T, E, 2), share (T, E).
template <class G>
void rides(long T, long E, Poses p, const int *pose, const double *arms, const int *look, const double *marks,
           const double *bend, const double *pulls, double *v, double *g, double *f, double *h, double *soft,
           double *share) {
    constexpr int d = G::d, k = G::turns;
    for (long t = 0; t < T; t++)
        for (long e = 0; e < E; e++) {
            const double *r[3], *c[3], *R0[3];
            for (int j = 0; j < 3; j++) {
                const long a = t * p.count + pose[3 * e + j];
                r[j] = p.r + a * d, c[j] = p.c + a * k, R0[j] = p.R0 + a * d * d;
            }
            typename Ride<G>::Number x, work;
            const long at = t * E + e;
            share[at] = Ride<G>::measured(r, c, R0, arms + e * 3 * (d + d * d), look[e], marks + 2 * e, bend + 2 * e,
                                          pulls + 2 * at, x, work, soft[2 * at], soft[2 * at + 1]);
            put(work, at, v, f, h);
            v[at] = x.v;
            std::memcpy(g + at * Ride<G>::N, x.g, sizeof x.g);
        }
}

// Rotations of n poses and their rates. Given chart vectors and rates c, v, a, and rotation, spin and its rate of the
// chart (R0, w0, al0). Of every column of R: J and H, first and second derivatives by c; its second rate z2, with
// derivatives by c and v (those by a are J). And the rates u of the chart vectors beside a chart at rest, with their
// derivatives by c.
template <class G>
void rotations(long n, const double *c, const double *v, const double *a, const double *R0, const double *w0,
               const double *al0, double *R, double *J, double *H, double *z1, double *z2, double *z2_c, double *z2_v,
               double *u, double *u_c) {
    constexpr int d = G::d, k = G::turns;
    using First = Dual<3 * k>;
    using Second = Jet<k>;
    for (long p = 0; p < n; p++) {
        const double *base = R0 + p * d * d;
        Second chart[k], turn[d][d];
        for (int i = 0; i < k; i++) chart[i] = Second::variable(c[p * k + i], i);
        G::turn(chart, turn);
        for (int j = 0; j < d; j++)
            for (int i = 0; i < d; i++) {
                Second x = turn[i][0] * base[j];
                for (int l = 1; l < d; l++) x += turn[i][l] * base[l * d + j];
                const long at = (p * d + j) * d + i;  // column j, component i
                R[p * d * d + i * d + j] = x.v;
                for (int s = 0, q = 0; s < k; s++) {
                    J[at * k + s] = x.g[s];
                    for (int o = 0; o <= s; o++, q++) H[(at * k + s) * k + o] = H[(at * k + o) * k + s] = x.h[q];
                }
            }

        First cv[k], vv[k], av[k], T[d][d], w[k], al[k], own[k], known[k], more[k], x[k], chart_rate[k];
        for (int i = 0; i < k; i++) {
            cv[i] = First::variable(c[p * k + i], i);
            vv[i] = First::variable(v[p * k + i], k + i);
            av[i] = First::variable(a[p * k + i], 2 * k + i);
        }
        G::turn(cv, T);
        G::spin(cv, vv, av, own, al);
        G::turned(T, w0 + p * k, known);
        G::turned(T, al0 + p * k, more);
        G::commute(own, known, x);
        for (int i = 0; i < k; i++) w[i] = own[i] + known[i], al[i] = al[i] + more[i] + x[i];
        G::chart_rate(cv, w, chart_rate);
        for (int i = 0; i < k; i++) {
            u[p * k + i] = chart_rate[i].v;
            for (int s = 0; s < k; s++) u_c[(p * k + i) * k + s] = chart_rate[i].g[s];
        }
        for (int j = 0; j < d; j++) {
            First column[d], rate[d], turned[d], twice[d];
            for (int i = 0; i < d; i++) {
                column[i] = T[i][0] * base[j];
                for (int l = 1; l < d; l++) column[i] = column[i] + T[i][l] * base[l * d + j];
            }
            G::cross(w, column, rate);
            G::cross(al, column, turned);
            G::cross(w, rate, twice);
            for (int i = 0; i < d; i++) {
                const long at = (p * d + j) * d + i;
                const First second = turned[i] + twice[i];
                z1[at] = rate[i].v;
                z2[at] = second.v;
                for (int s = 0; s < k; s++) z2_c[at * k + s] = second.g[s], z2_v[at * k + s] = second.g[k + s];
            }
        }
    }
}

// Where local derivatives go: positions in the values of a sparse matrix, -1 for none.
struct Target {
    long size, entries;  // of a vector, and of a matrix
    double *F, *M, *C, *K;
};

static inline void put_in(double *values, int at, double x) {
    if (at >= 0) values[at] += x;
}

// Variable of Ends of each of the 2 (d + turns) coordinates of both poses, and its sign there.
template <class G>
struct Locals {
    static constexpr int d = G::d, k = G::turns, count = 2 * (d + k), variables = d + 2 * k;
    int place[count];
    double sign[count];

    Locals() {
        for (int i = 0; i < d; i++) place[i] = i, sign[i] = -1, place[d + k + i] = i, sign[d + k + i] = 1;
        for (int i = 0; i < k; i++) {
            place[d + i] = d + i, sign[d + i] = 1;
            place[2 * d + k + i] = d + k + i, sign[2 * d + k + i] = 1;
        }
    }
};

// The same of `Ride` and `Inner`, whose variables are the n coordinates of their poses.
template <int n>
struct Own {
    static constexpr int count = n, variables = count;
    int place[count];
    double sign[count];

    Own() {
        for (int i = 0; i < count; i++) place[i] = i, sign[i] = 1;
    }
};

// Derivatives of E conditions: of each by the coordinates, into K at `by` (E, n), and of the forces by its multiplier, into
// M at `on`.
template <class G, class L = Locals<G>>
void conditions(long T, long E, const double *g, const int *by, const int *on, Target y) {
    const L l;
    constexpr int N = L::variables, n = L::count;
    for (long t = 0; t < T; t++)
        for (long e = 0; e < E; e++)
            for (int j = 0; j < n; j++) {
                const double x = l.sign[j] * g[(t * E + e) * N + l.place[j]];
                put_in(y.K + t * y.entries, by[e * n + j], x);
                put_in(y.M + t * y.entries, on[e * n + j], x);
            }
}

// Forces of E elements of m measures with stresses s, which depend on the measures by D and on their rates by B:
// F += G' s, K += G'(D G + B (H v)) + H . predicted, C += G' B G. v holds rates of N variables. Local coordinates
// are 2 (d + turns), those of both poses; `dof` (E, 2 (d + turns)) and `at` (E, n, n) say where they lie.
template <class G, class L = Locals<G>>
void spread(long T, long E, long m, const double *g, const double *h, const double *s, const double *predicted,
            const double *D, const double *B, const double *v, const int *dof, const int *at, bool tangents, Target y) {
    constexpr int N = L::variables, n = L::count, pairs = Jet<N>::pairs;
    const L l;
    const int *place = l.place;
    const double *sign = l.sign;
    for (long t = 0; t < T; t++)
        for (long e = 0; e < E; e++) {
            const long el = t * E + e;
            const double *ge = g + el * m * N, *he = h + el * m * pairs, *se = s + el * m;
            double f[N] = {}, K[N][N] = {}, C[N][N] = {};
            for (long i = 0; i < m; i++)
                for (int j = 0; j < N; j++) f[j] += ge[i * N + j] * se[i];
            for (int j = 0; j < n; j++)
                if (dof[e * n + j] >= 0) y.F[t * y.size + dof[e * n + j]] += sign[j] * f[place[j]];
            if (!tangents) continue;
            for (long i = 0; i < m; i++)
                for (int a = 0, q = 0; a < N; a++)
                    for (int b = 0; b <= a; b++, q++) K[a][b] += predicted[el * m + i] * he[i * pairs + q];
            for (int a = 0; a < N; a++)
                for (int b = 0; b < a; b++) K[b][a] = K[a][b];
            for (long i = 0; i < m; i++)
                for (long j = 0; j < m; j++) {
                    const double Dij = D[(el * m + i) * m + j], Bij = B ? B[(el * m + i) * m + j] : 0;
                    if (Dij == 0 && Bij == 0) continue;
                    double rate[N] = {};  // of the gradient of measure j
                    if (Bij != 0)
                        for (int a = 0, q = 0; a < N; a++)
                            for (int b = 0; b <= a; b++, q++) {
                                rate[a] += he[j * pairs + q] * v[el * N + b];
                                if (b < a) rate[b] += he[j * pairs + q] * v[el * N + a];
                            }
                    for (int a = 0; a < N; a++)
                        for (int b = 0; b < N; b++) {
                            K[a][b] += ge[i * N + a] * (Dij * ge[j * N + b] + Bij * rate[b]);
                            C[a][b] += ge[i * N + a] * Bij * ge[j * N + b];
                        }
                }
            for (int a = 0; a < n; a++)
                for (int b = 0; b < n; b++) {
                    const int where = at[(e * n + a) * n + b];
                    if (where < 0) continue;
                    y.K[t * y.entries + where] += sign[a] * sign[b] * K[place[a]][place[b]];
                    if (B) y.C[t * y.entries + where] += sign[a] * sign[b] * C[place[a]][place[b]];
                }
        }
}

// Inertia: L entries of the constant mass between vectors of poses, where vector 0 of a pose is its place and 1 + j the
// column j of its rotation. entry: (pose, vector, pose, vector), mass (L), at (L, d + turns, d + turns).
// acc (T, P, 1 + d, d) are second rates less those of gravity. own (P, d + turns, d + turns): where the pose's own block is.
template <class G>
void inertia(long T, long P, long L, const int *entry, const double *mass, const int *at, const int *own, const int *dof,
             const double *acc, const double *J, const double *H, const double *z2_c, const double *z2_v, bool tangents,
             double *work, Target y) {
    constexpr int d = G::d, k = G::turns, n = d + k;
    for (long t = 0; t < T; t++) {
        std::memset(work, 0, sizeof(double) * P * (1 + d) * d);  // forces on the vectors
        double *F = y.F + t * y.size, *M = y.M + t * y.entries, *C = y.C + t * y.entries, *K = y.K + t * y.entries;
        const long first = t * P;
        for (long l = 0; l < L; l++) {
            const int *en = entry + 4 * l;
            const double *a = acc + ((first + en[2]) * (1 + d) + en[3]) * d;
            for (int i = 0; i < d; i++) work[(en[0] * (1 + d) + en[1]) * d + i] += mass[l] * a[i];
        }
        for (long p = 0; p < P; p++) {
            const int *of = dof + p * n;
            const double *f = work + p * (1 + d) * d;
            for (int i = 0; i < d; i++) put_in(F, of[i], f[i]);
            for (int s = 0; s < k; s++) {
                double sum = 0;
                for (int i = 0; i < d * d; i++) sum += J[((first + p) * d * d + i) * k + s] * f[d + i];
                put_in(F, of[d + s], sum);
                if (!tangents) continue;
                for (int o = 0; o < k; o++) {
                    double bend = 0;
                    for (int i = 0; i < d * d; i++) bend += H[(((first + p) * d * d + i) * k + s) * k + o] * f[d + i];
                    put_in(K, own[(p * n + d + s) * n + d + o], bend);
                }
            }
        }
        if (!tangents) continue;
        for (long l = 0; l < L; l++) {
            const int *en = entry + 4 * l, *where = at + l * n * n;
            const long one = ((first + en[0]) * d + en[1] - 1) * d * k, other = ((first + en[2]) * d + en[3] - 1) * d * k;
            const double m = mass[l];
            double left[n][d] = {}, right[n][d] = {}, by_c[k][d] = {}, by_v[k][d] = {};  // J of both vectors
            for (int i = 0; i < d; i++) {
                if (en[1] == 0) left[i][i] = 1;
                else for (int s = 0; s < k; s++) left[d + s][i] = J[one + i * k + s];
                if (en[3] == 0) right[i][i] = 1;
                else for (int s = 0; s < k; s++) {
                    right[d + s][i] = J[other + i * k + s];
                    by_c[s][i] = z2_c[other + i * k + s], by_v[s][i] = z2_v[other + i * k + s];
                }
            }
            const int a0 = en[1] ? d : 0, a1 = en[1] ? n : d, b0 = en[3] ? d : 0, b1 = en[3] ? n : d;
            for (int a = a0; a < a1; a++)
                for (int b = b0; b < b1; b++) {
                    const int to = where[a * n + b];
                    if (to < 0) continue;
                    double x = 0, xc = 0, xv = 0;
                    for (int i = 0; i < d; i++) {
                        x += left[a][i] * right[b][i];
                        if (b >= d) xc += left[a][i] * by_c[b - d][i], xv += left[a][i] * by_v[b - d][i];
                    }
                    M[to] += m * x;
                    if (b >= d) K[to] += m * xc, C[to] += m * xv;
                }
        }
    }
}
