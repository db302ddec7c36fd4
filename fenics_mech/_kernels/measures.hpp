// Measures of two ends: the strains of a beam, and what joints, springs and loads look at. An end is a pose with an
// offset p and a turn S: a rigid arm, a hub, a weld, the axes of a member. All depend on dr, the way from the first
// pose's place to the second's, and on both chart vectors: N = d + 2 turns variables.
#pragma once
#include "rotations.hpp"

// Arm p and axes E of an end, by the chart vector of its pose, whose variables begin at `first`.
template <class G, class Number>
void end_of(const double *c, int first, const double *R0, const double *arm, Number *p, Number (&E)[G::d][G::d]) {
    constexpr int d = G::d;
    Number chart[G::turns], turn[d][d];
    for (int i = 0; i < G::turns; i++) chart[i] = Number::variable(c[i], first + i);
    G::turn(chart, turn);
    double known[d][d + 1] = {};  // R0 S, and R0 p
    for (int i = 0; i < d; i++)
        for (int k = 0; k < d; k++) {
            for (int j = 0; j < d; j++) known[i][j] += R0[i * d + k] * arm[d + k * d + j];
            known[i][d] += R0[i * d + k] * arm[k];
        }
    for (int i = 0; i < d; i++) {
        for (int j = 0; j < d; j++) {
            E[i][j] = turn[i][0] * known[0][j];
            for (int k = 1; k < d; k++) E[i][j] += turn[i][k] * known[k][j];
        }
        p[i] = turn[i][0] * known[0][d];
        for (int k = 1; k < d; k++) p[i] += turn[i][k] * known[k][d];
    }
}

template <class G>
struct Ends {
    static constexpr int d = G::d, N = d + 2 * G::turns;
    using Number = Jet<N>;
    Number x[d], A[d][d], B[d][d];  // from the first end to the second, and the axes of both

    // arms: p and S (row by row) of both ends; R0: rotations of both charts
    Ends(const double *r1, const double *r2, const double *c1, const double *c2, const double *R1, const double *R2,
         const double *arms) {
        Number p1[d], p2[d];
        end_of<G>(c1, d, R1, arms, p1, A);
        end_of<G>(c2, d + G::turns, R2, arms + d + d * d, p2, B);
        for (int i = 0; i < d; i++) x[i] = Number::variable(r2[i] - r1[i], i) + p2[i] - p1[i];
    }

    static Number dot(const Number (&X)[d][d], int i, const Number (&Y)[d][d], int j) {
        Number s = X[0][i] * Y[0][j];
        for (int k = 1; k < d; k++) s += X[k][i] * Y[k][j];
        return s;
    }

    Number along(const Number (&X)[d][d], int i) const {
        Number s = X[0][i] * x[0];
        for (int k = 1; k < d; k++) s += X[k][i] * x[k];
        return s;
    }

    Number square() const {
        Number s = x[0] * x[0];
        for (int k = 1; k < d; k++) s += x[k] * x[k];
        return s;
    }
};

// Strains of a beam between two ends: stretch, shear modes s (both ends turned alike from the chord), curvature modes k
// (turned against each other), twist. par: the length L, then for each plane of bending the numbers of the shallow arch,
// (2 int w'w' dx/L of the shapes of s and s, s and k, k and k)/2: 1/10, 0, 1/24 in a uniform beam.
template <class G>
void strains(const Ends<G> &ends, const double *par, typename Ends<G>::Number *e) {
    using Number = typename Ends<G>::Number;
    constexpr int d = G::d, b = G::bends;
    Number relative[d][d], c[G::turns], half[G::turns], mid[d][d], R[d][d];
    for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) relative[i][j] = ends.dot(ends.A, i, ends.B, j);
    G::cayley_of(relative, c);
    Number size = c[0] * c[0];
    for (int i = 1; i < G::turns; i++) size += c[i] * c[i];
    const Number n = 1. / (1. + sqrt(1. + 0.25 * size)), turn = atan_over(0.25 * size);
    for (int i = 0; i < G::turns; i++) half[i] = c[i] * n;
    G::cayley(half, mid);
    for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
            R[i][j] = ends.A[i][0] * mid[0][j];
            for (int k = 1; k < d; k++) R[i][j] += ends.A[i][k] * mid[k][j];
        }
    const Number length = sqrt(ends.square()), inverse_length = inverse(length);
    Number slope[b], spin[G::turns];
    e[0] = length * (1 / par[0]) - 1.;
    for (int i = 0; i < b; i++) slope[i] = -(ends.along(R, i + 1) * inverse_length);
    for (int i = 0; i < G::turns; i++) spin[i] = c[i] * turn;
    G::along_chord(slope, spin, e + 1);
    for (int i = 0; i < b; i++) {
        const Number &s = e[1 + i], &k = e[1 + b + i];
        const double *q = par + 1 + 3 * i;
        e[0] += q[0] * (s * s) + q[1] * (s * k) + q[2] * (k * k);
    }
}

// Strains of a beam in the plane whose axis is the polynomial through both ends' places, their first axes and m places
// inside. Variables are the place and the chart vector of both ends' poses, then the places inside. The stretch and the
// turn per share xi of the length are known by their Legendre modes, int P_i (.) dxi: 1 + m of the stretch, so many as
// places can level, then 2 + m of the turn. table, for each of `count` points: weight; first and second derivatives of the
// shapes of the first axis, the second place, the second axis and the places inside; P_0 to P_{1 + m}.
template <class G, int m>
struct Inner {
    static constexpr int d = G::d, k = G::turns, own = d + k, N = 2 * own + m * d, shapes = 3 + m, strains = 3 + 2 * m;
    using Number = Jet<N>;

    static void strained(const double *const *r, const double *const *c, const double *const *R0, const double *arms,
                         double length, int count, const double *table, Number *e) {
        static_assert(d == 2, "places inside elements are known in the plane");
        Number p[2][d], E[2][d][d], along[d][shapes];  // over the length, from the first end's place
        for (int j = 0; j < 2; j++) end_of<G>(c[j], j * own + d, R0[j], arms + j * (d + d * d), p[j], E[j]);
        for (int i = 0; i < d; i++) {
            for (int j = 0; j < 2; j++) p[j][i] += Number::variable(r[j][i], j * own + i);
            along[i][0] = E[0][i][0], along[i][1] = (p[1][i] - p[0][i]) * (1 / length), along[i][2] = E[1][i][0];
            for (int j = 0; j < m; j++)
                along[i][3 + j] = (Number::variable(r[2 + j][i], 2 * own + j * d + i) - p[0][i]) * (1 / length);
        }
        for (int i = 0; i < strains; i++) e[i] = Number(0.);
        for (int q = 0; q < count; q++, table += 1 + 2 * shapes + 2 + m) {
            const double *first = table + 1, *second = first + shapes, *legendre = second + shapes;
            Number u[d], v[d];
            for (int i = 0; i < d; i++)
                for (int j = 0; j < shapes; j++) u[i] += first[j] * along[i][j], v[i] += second[j] * along[i][j];
            const Number square = u[0] * u[0] + u[1] * u[1], stretch = sqrt(square) - 1.;
            const Number turn = (u[0] * v[1] - u[1] * v[0]) / square;
            for (int i = 0; i < 1 + m; i++) e[i] += table[0] * legendre[i] * stretch;
            for (int i = 0; i < 2 + m; i++) e[1 + m + i] += table[0] * legendre[i] * turn;
        }
    }
};

// What a relation looks at.
enum Measure {
    PLACE,     // way from the first end to the second, along axis i of the fixed frame
    ALONG,     // the same along axis i of the first end
    ALIGNED,   // cosine between axis i of the first end and axis j of the second
    DISTANCE,  // length of the way
    ANGLE      // turn of the second end against the first about the last axis of the first; whole turns by the angle before
};

template <class G>
typename Ends<G>::Number relation(const Ends<G> &ends, int measure, int i, int j, double before) {
    using Number = typename Ends<G>::Number;
    switch (measure) {
        case PLACE: return ends.x[i];
        case ALONG: return ends.along(ends.A, i);
        case ALIGNED: return ends.dot(ends.A, i, ends.B, j);
        case DISTANCE: return sqrt(ends.square());
        default: {
            Number angle = atan2(ends.dot(ends.A, 1, ends.B, 0), ends.dot(ends.A, 0, ends.B, 0));
            angle.v += 2 * M_PI * std::round((before - angle.v) / (2 * M_PI));
            return angle;
        }
    }
}

// What a pin looks at on the bent axis of an element. That is the cubic y(x) over its chord that has the slopes of both
// first axes, and beside it the bow that the pin's own force and couple make, as between clamped ends.
// Variables are the place and the chart vector of both ends' poses, then of the pin's.
enum Riding {
    ACROSS,  // distance of the pin from the axis
    TURNED,  // sine of the angle by which the pin's first axis is turned from the tangent there
    STROKE   // place along the straight element, from a mark at its first end
};

template <class G>
struct Ride {
    static constexpr int d = G::d, own = d + G::turns, N = 3 * own;
    using Number = Jet<N>;

    // marks: strokes at both ends; bend: the length L of the element, and L/EI; pulls: the pin's force and couple. by_own
    // and by_other are the compliances by the own pull and by the other one. The work of the pulls p against the bow is
    // half of p times it, so that `work` is the value with half of the bow. Gives the pin's share of the chord.
    static double measured(const double *const *r, const double *const *c, const double *const *R0, const double *arms,
                           int look, const double *marks, const double *bend, const double *pulls, Number &value,
                           Number &work, double &by_own, double &by_other) {
        Number p[3][d], E[3][d][d], e[d], n[d];
        for (int j = 0; j < 3; j++) {
            end_of<G>(c[j], j * own + d, R0[j], arms + j * (d + d * d), p[j], E[j]);
            for (int i = 0; i < d; i++) p[j][i] += Number::variable(r[j][i], j * own + i);
        }
        for (int i = 0; i < d; i++) e[i] = p[1][i] - p[0][i], p[2][i] = p[2][i] - p[0][i];
        const Number length = sqrt(dot(e, e)), inverse_length = inverse(length);
        for (int i = 0; i < d; i++) e[i] = e[i] * inverse_length;
        Number first[d], last[d], side[d];
        for (int i = 0; i < d; i++) first[i] = E[0][i][0], last[i] = E[1][i][0], side[i] = E[0][i][1];
        const Number off = dot(e, side);
        for (int i = 0; i < d; i++) n[i] = side[i] - off * e[i];
        const Number size = inverse(sqrt(dot(n, n)));
        for (int i = 0; i < d; i++) n[i] = n[i] * size;
        const Number x = dot(e, p[2]) * inverse_length, rest = 1. - x;
        const Number one = dot(n, first) / dot(e, first), two = dot(n, last) / dot(e, last);  // slopes
        by_own = by_other = 0;
        if (look == STROKE) {
            value = work = marks[0] + (marks[1] - marks[0]) * x;
            return x.v;
        }
        if (look == ACROSS) value = dot(n, p[2]) - length * (x * rest) * (rest * one - x * two);
        else {
            const Number slope = rest * (1. - 3. * x) * one + x * (3. * x - 2.) * two;
            Number across[d], axis[d];
            for (int i = 0; i < d; i++) across[i] = n[i] - slope * e[i], axis[i] = E[2][i][0];
            value = dot(across, axis) * inverse(sqrt(1. + slope * slope));
        }
        work = value;
        if (bend[1] == 0 || x.v < 0 || x.v > 1) return x.v;
        const Number both = x * rest, cross = (0.5 * bend[0] * bend[1]) * (both * both * (1. - 2. * x));
        const Number mine = look == ACROSS ? (bend[0] * bend[0] * bend[1] / 3) * (both * both * both)
                                           : bend[1] * (both * (1. - 3. * both));
        const Number bow = mine * pulls[look] + cross * pulls[1 - look];
        by_own = mine.v, by_other = cross.v, value = value - bow, work = work - 0.5 * bow;
        return x.v;
    }

    static Number dot(const Number *a, const Number *b) {
        Number s = a[0] * b[0];
        for (int i = 1; i < d; i++) s += a[i] * b[i];
        return s;
    }
};
