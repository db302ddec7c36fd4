// Rotations of the plane and of space. What differs between the two stands here, and nowhere else.
#pragma once
#include "jet.hpp"

template <class S, int D> using Vector = S[D];
template <class S, int D> using Matrix = S[D][D];

struct Plane {
    static constexpr int d = 2, turns = 1, bends = 1, strains = 3;  // strains of a beam: stretch, shear mode, curvature mode

    // Rotation of a chart vector: here its angle.
    template <class S> static void turn(const S *c, S (&R)[2][2]) {
        const S co = cos(c[0]), si = sin(c[0]);
        R[0][0] = co, R[0][1] = -si, R[1][0] = si, R[1][1] = co;
    }

    // w x v
    template <class S, class V> static void cross(const S *w, const V *v, S *y) { y[0] = -1. * (w[0] * v[1]), y[1] = w[0] * v[0]; }

    // Angular velocity by the rate of a chart vector, and angular acceleration.
    template <class S> static void spin(const S *, const S *v, const S *a, S *w, S *al) { w[0] = v[0], al[0] = a[0]; }

    // Rate that a chart vector has if a rotation spins by w.
    template <class S> static void chart_rate(const S *, const S *w, S *v) { v[0] = w[0]; }

    // Turn a spin by a rotation.
    template <class S> static void turned(const S (&)[2][2], const double *w, S *y) { y[0] = S(w[0]); }

    // w x u of two spins
    template <class S> static void commute(const S *, const S *, S *y) { y[0] = S(0.); }

    // 2 tan(angle/2) times the axis of a rotation, and the rotation of such a vector.
    template <class S> static void cayley_of(const S (&R)[2][2], S *c) { c[0] = 2. * R[1][0] / (1. + R[0][0]); }

    template <class S> static void cayley(const S *c, S (&R)[2][2]) {
        const S n = 1. / (1. + 0.25 * (c[0] * c[0]));
        R[0][0] = 1. + -0.5 * (c[0] * c[0]) * n, R[1][1] = R[0][0], R[1][0] = c[0] * n, R[0][1] = -R[1][0];
    }

    // Strains of a beam but its stretch, by minus the slope of its middle against the chord, and by how its ends are
    // turned against each other.
    template <class S> static void along_chord(const S *slope, const S *turn, S *e) { e[0] = slope[0], e[1] = turn[0]; }
};

struct Space {
    static constexpr int d = 3, turns = 3, bends = 2, strains = 6;  // stretch, two shear, two curvature modes, twist

    // Rotation of a chart vector: a Cayley vector, 2 tan(angle/2) times its axis.
    template <class S> static void turn(const S *c, S (&R)[3][3]) {
        const S n = 1. / (1. + 0.25 * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]));
        const S half = 0.5 * n;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < i; j++) R[i][j] = R[j][i] = half * (c[i] * c[j]);
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            R[i][i] = 1. + -1. * (half * (c[j] * c[j] + c[k] * c[k]));
            const S w = n * c[i];
            R[k][j] = R[k][j] + w, R[j][k] = R[j][k] - w;
        }
    }

    template <class S, class V> static void cross(const S *w, const V *v, S *y) {
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            y[i] = w[j] * v[k] - w[k] * v[j];
        }
    }

    // w = (c' + c x c'/2)/(1 + |c|^2/4), and its rate.
    template <class S> static void spin(const S *c, const S *v, const S *a, S *w, S *al) {
        const S n = 1. / (1. + 0.25 * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]));
        const S m = 0.5 * (c[0] * v[0] + c[1] * v[1] + c[2] * v[2]);
        S x[3], y[3];
        cross(c, v, x), cross(c, a, y);
        for (int i = 0; i < 3; i++) {
            w[i] = n * (v[i] + 0.5 * x[i]);
            al[i] = n * (a[i] + 0.5 * y[i] - m * w[i]);
        }
    }

    // c' = w - c x w/2 + c (c.w)/4
    template <class S> static void chart_rate(const S *c, const S *w, S *v) {
        S x[3];
        cross(c, w, x);
        const S s = 0.25 * (c[0] * w[0] + c[1] * w[1] + c[2] * w[2]);
        for (int i = 0; i < 3; i++) v[i] = w[i] + -0.5 * x[i] + s * c[i];
    }

    template <class S> static void turned(const S (&R)[3][3], const double *w, S *y) {
        for (int i = 0; i < 3; i++) y[i] = R[i][0] * w[0] + R[i][1] * w[1] + R[i][2] * w[2];
    }

    template <class S> static void commute(const S *w, const S *u, S *y) { cross(w, u, y); }

    template <class S> static void cayley_of(const S (&R)[3][3], S *c) {
        const S n = 2. / (1. + R[0][0] + R[1][1] + R[2][2]);
        for (int i = 0; i < 3; i++) c[i] = n * (R[(i + 2) % 3][(i + 1) % 3] - R[(i + 1) % 3][(i + 2) % 3]);
    }

    template <class S> static void cayley(const S *c, S (&R)[3][3]) { turn(c, R); }

    // The same in space. An even curvature k with an even twist t makes a helix, whose middle has the slope t k/24 against
    // its chord. The turn counts about axes whose first is along the chord: there the sections stand on average.
    template <class S> static void along_chord(const S *slope, const S *turn, S *e) {
        const S &s2 = slope[0], &s3 = slope[1], &t = turn[0], &k2 = turn[2], k3 = -turn[1];
        e[0] = s2 + -1. / 24 * (t * k3), e[1] = s3 + 1. / 24 * (t * k2);
        e[2] = k2 + t * s3, e[3] = k3 - t * s2;
        e[4] = t + s2 * k3 - s3 * k2;
    }
};
