// Values with their derivatives by N variables: a formula that is written once gives its gradient and its Hessian.
#pragma once
#include <cmath>

// A value with its gradient g and its Hessian h (lower triangle, row by row).
template <int N>
struct Jet {
    static constexpr int pairs = N * (N + 1) / 2;
    double v = 0, g[N] = {}, h[pairs] = {};

    Jet() = default;
    Jet(double value) : v(value) {}

    static Jet variable(double value, int i) {
        Jet x(value);
        x.g[i] = 1;
        return x;
    }

    Jet &operator+=(const Jet &b) {
        v += b.v;
        for (int i = 0; i < N; i++) g[i] += b.g[i];
        for (int i = 0; i < pairs; i++) h[i] += b.h[i];
        return *this;
    }

    Jet &operator*=(double b) {
        v *= b;
        for (int i = 0; i < N; i++) g[i] *= b;
        for (int i = 0; i < pairs; i++) h[i] *= b;
        return *this;
    }

    // f(x) by its value and its first two derivatives there
    Jet mapped(double f, double f1, double f2) const {
        Jet y(f);
        for (int i = 0; i < N; i++) y.g[i] = f1 * g[i];
        for (int i = 0, k = 0; i < N; i++)
            for (int j = 0; j <= i; j++, k++) y.h[k] = f1 * h[k] + f2 * g[i] * g[j];
        return y;
    }
};

template <int N> Jet<N> operator+(Jet<N> a, const Jet<N> &b) { return a += b; }
template <int N> Jet<N> operator*(Jet<N> a, double b) { return a *= b; }
template <int N> Jet<N> operator*(double b, Jet<N> a) { return a *= b; }
template <int N> Jet<N> operator-(Jet<N> a) { return a *= -1; }
template <int N> Jet<N> operator-(const Jet<N> &a, const Jet<N> &b) { return a + -b; }
template <int N> Jet<N> operator+(Jet<N> a, double b) { a.v += b; return a; }
template <int N> Jet<N> operator+(double b, Jet<N> a) { a.v += b; return a; }
template <int N> Jet<N> operator-(Jet<N> a, double b) { a.v -= b; return a; }
template <int N> Jet<N> operator-(double b, const Jet<N> &a) { return -a + b; }

template <int N>
Jet<N> operator*(const Jet<N> &a, const Jet<N> &b) {
    Jet<N> y(a.v * b.v);
    for (int i = 0; i < N; i++) y.g[i] = a.v * b.g[i] + b.v * a.g[i];
    for (int i = 0, k = 0; i < N; i++)
        for (int j = 0; j <= i; j++, k++)
            y.h[k] = a.v * b.h[k] + b.v * a.h[k] + a.g[i] * b.g[j] + a.g[j] * b.g[i];
    return y;
}

template <int N> Jet<N> inverse(const Jet<N> &x) { const double i = 1 / x.v; return x.mapped(i, -i * i, 2 * i * i * i); }
template <int N> Jet<N> operator/(const Jet<N> &a, const Jet<N> &b) { return a * inverse(b); }
template <int N> Jet<N> operator/(double a, const Jet<N> &b) { return inverse(b) * a; }
template <int N> Jet<N> sqrt(const Jet<N> &x) { const double s = std::sqrt(x.v); return x.mapped(s, 0.5 / s, -0.25 / (s * x.v)); }
template <int N> Jet<N> cos(const Jet<N> &x) { const double c = std::cos(x.v); return x.mapped(c, -std::sin(x.v), -c); }
template <int N> Jet<N> sin(const Jet<N> &x) { const double s = std::sin(x.v); return x.mapped(s, std::cos(x.v), -s); }

// The angle of the vector (x, y).
template <int N>
Jet<N> atan2(const Jet<N> &y, const Jet<N> &x) {
    const Jet<N> turned = (y * x.v - x * y.v) / (x * x.v + y * y.v);  // its tangent, beside the present angle
    return turned.mapped(std::atan2(y.v, x.v), 1, 0);  // atan is the identity up to third order
}

// atan(x)/x as a function of z = x^2.
template <int N>
Jet<N> atan_over(const Jet<N> &z) {
    const double s = z.v;
    if (s < 1e-3)  // its series: below rounding after s^5
        return z.mapped(1 - s * (1. / 3 - s * (1. / 5 - s * (1. / 7 - s * (1. / 9 - s / 11)))),
                        -1. / 3 + s * (2. / 5 - s * (3. / 7 - s * (4. / 9 - s * 5. / 11))),
                        2. / 5 - s * (6. / 7 - s * (12. / 9 - s * 20. / 11)));
    const double x = std::sqrt(s), f = std::atan(x) / x, p = 1 / (1 + s);  // with f' = (p - f)/(2 s)
    const double f1 = (p - f) / (2 * s);
    return z.mapped(f, f1, (-p * p - f1) / (2 * s) - f1 / s);
}

// A value with its gradient alone.
template <int N>
struct Dual {
    double v = 0, g[N] = {};

    Dual() = default;
    Dual(double value) : v(value) {}

    static Dual variable(double value, int i) {
        Dual x(value);
        x.g[i] = 1;
        return x;
    }

    Dual mapped(double f, double f1) const {
        Dual y(f);
        for (int i = 0; i < N; i++) y.g[i] = f1 * g[i];
        return y;
    }
};

template <int N> Dual<N> operator+(Dual<N> a, const Dual<N> &b) { a.v += b.v; for (int i = 0; i < N; i++) a.g[i] += b.g[i]; return a; }
template <int N> Dual<N> operator*(const Dual<N> &a, double b) { return a.mapped(a.v * b, b); }
template <int N> Dual<N> operator*(double b, const Dual<N> &a) { return a.mapped(a.v * b, b); }
template <int N> Dual<N> operator-(const Dual<N> &a) { return a * -1.; }
template <int N> Dual<N> operator-(const Dual<N> &a, const Dual<N> &b) { return a + -b; }
template <int N> Dual<N> operator+(Dual<N> a, double b) { a.v += b; return a; }
template <int N> Dual<N> operator+(double b, Dual<N> a) { a.v += b; return a; }

template <int N>
Dual<N> operator*(const Dual<N> &a, const Dual<N> &b) {
    Dual<N> y(a.v * b.v);
    for (int i = 0; i < N; i++) y.g[i] = a.v * b.g[i] + b.v * a.g[i];
    return y;
}

template <int N> Dual<N> operator/(double a, const Dual<N> &b) { return b.mapped(a / b.v, -a / (b.v * b.v)); }
template <int N> Dual<N> cos(const Dual<N> &x) { return x.mapped(std::cos(x.v), -std::sin(x.v)); }
template <int N> Dual<N> sin(const Dual<N> &x) { return x.mapped(std::sin(x.v), std::cos(x.v)); }
