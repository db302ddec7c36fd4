/* Sparse matrices of one pattern at many positions: their products with the transformation, their factors, and the march
   of a state through the steps of a cycle. S is the number of stages of a step, LANES that of right-hand sides that are
   solved for at once; they are set as the file is compiled.

   An unknown of a step is a block of S numbers, one a stage. Blocks are eliminated in a fixed order that keeps the factors
   sparse; rows are exchanged within a block only. Blocks are numbered: the diagonal ones by their turn, then those below
   the diagonal, column by column, then their mirror images. */
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct {
    long size;            /* unknowns of a stage */
    long entries;         /* nonzeros of a matrix */
    long blocks;          /* of the factors */
    long below_all;       /* blocks below the diagonal */
    const int *begin;     /* first nonzero of each row, and their number */
    const int *columns;   /* of the nonzeros, row by row */
    const int *place;     /* block of each nonzero */
    const int *order;     /* unknown that is eliminated at each turn */
    const int *turn;      /* turn of each unknown */
    const int *first;     /* first block below the diagonal of each turn's column */
    const int *below;     /* row of each of these, as a turn */
    const long *update;   /* first of each turn's updates */
    const int *target;    /* block that is changed by each update */
} pattern;

/* Forces Z^T F^T y at collocation points, of the rates y = G Z q' + H Z q of a few modes. */
typedef struct {
    long count;               /* modes */
    long seen;                /* rows of Z: what the modes see of the coordinates */
    const double *outward;    /* F, G and H, (points, count, seen) */
    const double *by_rate;
    const double *by_place;
    double *inverse;          /* of the rates' own equations in each step, transposed, (steps, count S, count S) */
    const int *begin;         /* Z by its rows: where each begins, and columns and values; none where Z is 1 */
    const int *columns;
    const double *shares;
    const int *back;          /* Z by its columns */
    const int *rows;
    const double *back_shares;
} modal;

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define FAST __attribute__((target_clones("avx2", "default"))) /* static functions only: others meet their namesakes */
#else
#define FAST
#endif
/* Numbers of several right-hand sides, which a processor takes at once. */
typedef double lanes __attribute__((vector_size(8 * LANES), aligned(8)));

#define ROWS 4 /* rows that are taken at once, so that sums do not wait for each other */
#define BLOCK(i, j) ((i) * S + (j))
#define LOWER(z) ((p->size + (z)) * S * S)
#define UPPER(z) ((p->size + p->below_all + (z)) * S * S)

/* Replace a matrix (n, n) by its inverse: Gauss-Jordan with exchange of rows. Returns whether it is regular. */
static inline __attribute__((always_inline)) int invert(double *a, long n)
{
    long moved[n];
    for (long k = 0; k < n; k++) {
        long best = k;
        for (long i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k])) best = i;
        moved[k] = best;
        if (!(fabs(a[best * n + k]) > 0.0)) return 0;
        for (long j = 0; best != k && j < n; j++) {
            double swap = a[k * n + j];
            a[k * n + j] = a[best * n + j];
            a[best * n + j] = swap;
        }
        double pivot = 1.0 / a[k * n + k];
        a[k * n + k] = 1.0;
        for (long j = 0; j < n; j++) a[k * n + j] *= pivot;
        for (long i = 0; i < n; i++) {
            if (i == k) continue;
            double times = a[i * n + k];
            a[i * n + k] = 0.0;
            for (long j = 0; j < n; j++) a[i * n + j] -= times * a[k * n + j];
        }
    }
    for (long k = n - 1; k >= 0; k--)
        for (long i = 0; moved[k] != k && i < n; i++) {
            double swap = a[i * n + k];
            a[i * n + k] = a[i * n + moved[k]];
            a[i * n + moved[k]] = swap;
        }
    return 1;
}

FAST static int invert_large(double *a, long n)
{
    return invert(a, n);
}

/* Invert the diagonal blocks d of the steps k to k + many - 1, which stand in the lanes. Returns the first step whose block
   is singular, or -1. */
static long invert_lanes(lanes *d, long k, long many)
{
    long singular = -1;
    double block[S * S];
    for (long c = many - 1; c >= 0; c--) {
        for (int i = 0; i < S * S; i++) block[i] = d[i][c];
        if (!invert(block, S)) singular = k + c;
        for (int i = 0; i < S * S; i++) d[i][c] = block[i];
    }
    return singular;
}

/* Factorise LANES steps beside each other; b holds their matrices, block by block. */
FAST static long factorise_lanes(const pattern *p, long k, long many, lanes *b)
{
    long singular = -1;
    for (long i = 0; i < p->size; i++) {
        lanes *d = b + i * S * S;
        long below = p->first[i + 1] - p->first[i], failed = invert_lanes(d, k, many);
        if (failed >= 0 && (singular < 0 || failed < singular)) singular = failed;
        for (long z = p->first[i]; z < p->first[i + 1]; z++) { /* blocks of L: times the inverse */
            lanes *l = b + LOWER(z), row[S];
            for (int r = 0; r < S; r++) {
                for (int j = 0; j < S; j++) row[j] = l[BLOCK(r, j)];
                for (int j = 0; j < S; j++) {
                    lanes sum = row[0] * d[BLOCK(0, j)];
                    for (int m = 1; m < S; m++) sum += row[m] * d[BLOCK(m, j)];
                    l[BLOCK(r, j)] = sum;
                }
            }
        }
        const int *target = p->target + p->update[i];
        for (long y = 0; y < below; y++) {
            const lanes *l = b + LOWER(p->first[i] + y);
            for (long z = 0; z < below; z++) {
                const lanes *u = b + UPPER(p->first[i] + z);
                lanes *o = b + (long)target[y * below + z] * S * S;
                for (int r = 0; r < S; r++)
                    for (int j = 0; j < S; j++) {
                        lanes sum = l[BLOCK(r, 0)] * u[BLOCK(0, j)];
                        for (int m = 1; m < S; m++) sum += l[BLOCK(r, m)] * u[BLOCK(m, j)];
                        o[BLOCK(r, j)] -= sum;
                    }
            }
        }
    }
    return singular;
}

/* Factors of M + h A C + h^2 A^2 K in every step; without C and K, those of M at every position (S = 1).
   work is (blocks, S, S, LANES). Returns the first step whose matrix is singular, or -1. */
long factor(const pattern *p, long steps, const double *mass, const double *damping, const double *stiffness,
            const double *duration, const double *inner, const double *square, double *factors, double *work)
{
    long singular = -1, numbers = p->blocks * S * S;
    for (long k = 0, many; k < steps; k += many) {
        many = steps - k < LANES ? steps - k : LANES;
        memset(work, 0, sizeof(lanes) * numbers);
        for (long e = 0; e < p->entries; e++) {
            double *o = work + (long)p->place[e] * S * S * LANES;
            for (int i = 0; i < S; i++) /* the equation at point i */
                for (long c = 0; c < many; c++) {
                    long at = ((k + c) * S + i) * p->entries + e;
                    o[BLOCK(i, i) * LANES + c] += mass[at];
                    if (!damping) continue;
                    double h = duration[k + c], by_rate = h * damping[at], by_place = h * h * stiffness[at];
                    for (int j = 0; j < S; j++)
                        o[BLOCK(i, j) * LANES + c] += inner[BLOCK(i, j)] * by_rate + square[BLOCK(i, j)] * by_place;
                }
        }
        long failed = factorise_lanes(p, k, many, (lanes *)work);
        if (singular < 0) singular = failed;
        for (long c = 0; c < many; c++)
            for (long i = 0; i < numbers; i++) factors[(k + c) * numbers + i] = work[i * LANES + c];
    }
    return singular;
}

#define NUMBER double
#define NAME(name) name
#define KIND static
#define SIMD(loop) _Pragma(loop)
#include "march.h"
#undef NUMBER
#undef NAME
#undef KIND
#undef SIMD
#define NUMBER lanes
#define NAME(name) name##_many
#define KIND FAST static
#define SIMD(loop)
#include "march.h"

/* Products of the matrices at all positions with vectors (positions, many, size). */
void multiply(const pattern *p, long positions, long many, const double *values, const double *vectors, double *result)
{
    for (long k = 0; k < positions * many; k++) {
        const double *v = values + (k / many) * p->entries, *x = vectors + k * p->size;
        for (long i = 0; i < p->size; i++) {
            double sum = 0.0;
            for (long e = p->begin[i]; e < p->begin[i + 1]; e++) sum += v[e] * x[p->columns[e]];
            result[k * p->size + i] = sum;
        }
    }
}

/* Replace right-hand sides (positions, many, size) by answers, with factors of S = 1. work is (size, LANES). */
void solve(const pattern *p, long positions, long many, const double *factors, double *right, double *work)
{
    long n = p->size;
    for (long k = 0; k < positions; k++) {
        const double *b = factors + k * p->blocks * S * S;
        for (long done = 0, count; done < many; done += count) {
            double *column = right + (k * many + done) * n;
            count = many - done < LANES ? 1 : LANES;
            for (long i = 0; i < n; i++)
                for (long c = 0; c < count; c++) work[i * count + c] = column[c * n + p->order[i]];
            if (count == 1) substitute(p, b, work);
            else substitute_many(p, b, (lanes *)work);
            for (long i = 0; i < n; i++)
                for (long c = 0; c < count; c++) column[c * n + p->order[i]] = work[i * count + c];
        }
    }
}

/* Invert the equations of the modes' rates in every step, the transpose of 1 + V B^-1 U, with the factors of B. work is
   ((S size + (S + 2) seen) LANES + S count (S count + 2 LANES),). Returns the first step where they are singular, or -1. */
long factor_modal(const pattern *p, const modal *d, long steps, const double *duration, const double *inner,
                  const double *square, const double *factors, double *work)
{
    long n = p->size, seen = d->seen, m = d->count * S, singular = -1, row = m + LANES; /* the last columns may be no one's */
    lanes *x = (lanes *)work, *y = x + n * S, *more = y + m;
    double *wide = (double *)(more + (S + 2) * seen);
    for (long k = 0; k < steps; k++) {
        double *a = d->inverse + k * m * m;
        for (long column = 0; column < m; column += LANES) {
            memset(x, 0, sizeof(lanes) * n * S);
            memset(more, 0, sizeof(lanes) * seen * S);
            for (long c = 0; c < LANES && column + c < m; c++) { /* a unit rate of a mode at a point */
                long j = (column + c) % S;
                const double *force = d->outward + ((k * S + j) * d->count + (column + c) / S) * seen;
                for (long i = 0; i < seen; i++) more[j * seen + i][c] = -force[i];
            }
            spread_many(p, d, more, x);
            substitute_many(p, factors + k * p->blocks * S * S, x);
            rates_of_many(p, d, k, duration[k], inner, square, x, y, more);
            for (long i = 0; i < m; i++) *(lanes *)(wide + i * row + column) = y[i];
        }
        for (long i = 0; i < m; i++) {
            for (long j = 0; j < m; j++) a[j * m + i] = wide[i * row + j];
            a[i * m + i] += 1.0;
        }
        if (!invert_large(a, m) && singular < 0) singular = k;
    }
    return singular;
}

/* Take one state, or LANES beside each other, through steps; see march.h. */
void march(const pattern *p, long first, long last, const double *damping, const double *stiffness, const double *load,
           const double *gain, const double *duration, const double *inner, const double *weights,
           const double *square, const double *points, const double *factors, const modal *modes, double pace,
           const double *starts, double *ends, double *accelerations, double *work)
{
    marched(p, first, last, damping, stiffness, load, gain, duration, inner, weights, square, points, factors, modes, pace,
            starts, ends, accelerations, work);
}

void march_many(const pattern *p, long first, long last, const double *damping, const double *stiffness,
                const double *load, const double *gain, const double *duration, const double *inner,
                const double *weights, const double *square, const double *points, const double *factors,
                const modal *modes, double pace, const double *starts, double *ends, double *accelerations,
                double *work)
{
    marched_many(p, first, last, damping, stiffness, load, gain, duration, inner, weights, square, points, factors, modes,
                 pace, (const lanes *)starts, (lanes *)ends, (lanes *)accelerations, (lanes *)work);
}

/* Add to every target the products of two nonzeros, at every position. A stride of 0 belongs to numbers that are the same
   at all positions. */
void products(long positions, long pairs, const int *left, const int *right, const int *target, const double *one,
              long one_stride, const double *other, long other_stride, double *result, long stride)
{
    for (long t = 0; t < positions; t++) {
        const double *a = one + t * one_stride, *b = other + t * other_stride;
        double *out = result + t * stride;
        for (long e = 0; e < pairs; e++) out[target[e]] += a[left[e]] * b[right[e]];
    }
}

/* Add to every place of a row the entries that belong there, in every row of values. */
void collect(long rows, long entries, const long *place, const double *values, long size, double *result)
{
    for (long t = 0; t < rows; t++) {
        const double *given = values + t * entries;
        double *out = result + t * size;
        for (long e = 0; e < entries; e++) out[place[e]] += given[e];
    }
}

/* Call the kernel of a form, as FFCx compiles it, for every cell at every position. Values are those of the coefficients,
   (positions, cells, given), places the vertices of each cell, results (positions, cells, made). Kernels of FFCx before
   0.10 do not take the last argument, and leave it to the caller, which by the calling conventions removes it. */
typedef void form_kernel(double *, const double *, const double *, const double *, const int *, const uint8_t *, void *);
void tabulate(uintptr_t kernel, long positions, long cells, long given, long made, const double *values,
              const double *places, double *results)
{
    form_kernel *f = (form_kernel *)kernel;
    for (long k = 0; k < positions * cells; k++)
        f(results + k * made, values + k * given, 0, places + (k % cells) * 6, 0, 0, 0);
}
