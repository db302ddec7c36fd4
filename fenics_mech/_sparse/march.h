/* The march of a state through the steps of a cycle, for one state or for several beside each other: NUMBER is a double,
   or LANES of them, and NAME makes the functions' names. Included by kernels.c. */

/* Products of ROWS rows of two matrices with a vector each, summed; rows are size apart. */
FAST static void NAME(dots)(long n, const double *a, const NUMBER *x, const double *b, const NUMBER *y, NUMBER *products)
{
    NUMBER p0 = {0.0}, p1 = {0.0}, p2 = {0.0}, p3 = {0.0};
    SIMD("omp simd reduction(+ : p0, p1, p2, p3)")
    for (long i = 0; i < n; i++) {
        p0 += a[i] * x[i] + b[i] * y[i];
        p1 += a[n + i] * x[i] + b[n + i] * y[i];
        p2 += a[2 * n + i] * x[i] + b[2 * n + i] * y[i];
        p3 += a[3 * n + i] * x[i] + b[3 * n + i] * y[i];
    }
    products[0] = p0, products[1] = p1, products[2] = p2, products[3] = p3;
}

/* The same of one row. */
FAST static void NAME(dot)(long n, const double *a, const NUMBER *x, const double *b, const NUMBER *y, NUMBER *product)
{
    NUMBER sum = {0.0};
    SIMD("omp simd reduction(+ : sum)")
    for (long i = 0; i < n; i++) sum += a[i] * x[i] + b[i] * y[i];
    *product = sum;
}

/* Add multiples of ROWS rows to a vector. */
FAST static void NAME(adds)(long n, const NUMBER *factors, const double *a, NUMBER *sum)
{
    NUMBER f0 = factors[0], f1 = factors[1], f2 = factors[2], f3 = factors[3];
    SIMD("omp simd")
    for (long i = 0; i < n; i++) sum[i] += f0 * a[i] + f1 * a[n + i] + f2 * a[2 * n + i] + f3 * a[3 * n + i];
}

/* The same of one row. */
FAST static void NAME(add)(long n, const NUMBER *factor, const double *a, NUMBER *sum)
{
    NUMBER times = *factor;
    SIMD("omp simd")
    for (long i = 0; i < n; i++) sum[i] += times * a[i];
}

/* Sum of multiples of rows; factors are a distance apart. */
KIND void NAME(combine)(long n, long rows, const NUMBER *factors, long apart, const double *a, NUMBER *sum)
{
    NUMBER some[ROWS];
    long i = 0;
    memset(sum, 0, sizeof(NUMBER) * n);
    for (; i + ROWS <= rows; i += ROWS) {
        for (int r = 0; r < ROWS; r++) some[r] = factors[(i + r) * apart];
        NAME(adds)(n, some, a + i * n, sum);
    }
    for (; i < rows; i++) NAME(add)(n, factors + i * apart, a + i * n, sum);
}

/* Solve with the factors of one step; x is (size, S), by the turns of the elimination. */
KIND void NAME(substitute)(const pattern *p, const double *b, NUMBER *x)
{
    for (long i = 0; i < p->size; i++)
        for (long z = p->first[i]; z < p->first[i + 1]; z++) {
            const double *l = b + LOWER(z);
            NUMBER *o = x + (long)p->below[z] * S;
            for (int r = 0; r < S; r++) {
                NUMBER sum = l[BLOCK(r, 0)] * x[i * S];
                for (int m = 1; m < S; m++) sum += l[BLOCK(r, m)] * x[i * S + m];
                o[r] -= sum;
            }
        }
    for (long i = p->size - 1; i >= 0; i--) {
        NUMBER y[S];
        for (int r = 0; r < S; r++) y[r] = x[i * S + r];
        for (long z = p->first[i]; z < p->first[i + 1]; z++) {
            const double *u = b + UPPER(z);
            const NUMBER *o = x + (long)p->below[z] * S;
            for (int r = 0; r < S; r++) {
                NUMBER sum = u[BLOCK(r, 0)] * o[0];
                for (int m = 1; m < S; m++) sum += u[BLOCK(r, m)] * o[m];
                y[r] -= sum;
            }
        }
        for (int r = 0; r < S; r++) {
            NUMBER sum = b[i * S * S + BLOCK(r, 0)] * y[0];
            for (int m = 1; m < S; m++) sum += b[i * S * S + BLOCK(r, m)] * y[m];
            x[i * S + r] = sum;
        }
    }
}

/* What the modes see of coordinates x, z = Z x. */
KIND void NAME(seen)(const pattern *p, const modal *d, const NUMBER *x, NUMBER *z)
{
    if (!d->begin) memcpy(z, x, sizeof(NUMBER) * p->size);
    for (long r = 0; d->begin && r < d->seen; r++) {
        NUMBER sum = {0.0};
        for (long e = d->begin[r]; e < d->begin[r + 1]; e++) sum += d->shares[e] * x[d->columns[e]];
        z[r] = sum;
    }
}

/* The same of x (size, S) by turns; z is (S, seen). */
KIND void NAME(seen_of_all)(const pattern *p, const modal *d, const NUMBER *x, NUMBER *z)
{
    for (long r = 0; r < d->seen; r++) {
        NUMBER sum[S];
        for (int l = 0; l < S; l++) sum[l] = d->begin ? (NUMBER){0.0} : x[(long)p->turn[r] * S + l];
        for (long e = d->begin ? d->begin[r] : 0; d->begin && e < d->begin[r + 1]; e++) {
            const NUMBER *made = x + (long)p->turn[d->columns[e]] * S;
            for (int l = 0; l < S; l++) sum[l] += d->shares[e] * made[l];
        }
        for (int l = 0; l < S; l++) z[l * d->seen + r] = sum[l];
    }
}

/* The modes' rates y (count, S) at point j of a step, by what they see of q' and q. */
KIND void NAME(rates_at)(const modal *d, long step, int j, const NUMBER *rate, const NUMBER *place, NUMBER *y)
{
    long n = d->seen, at = (step * S + j) * d->count * n, a = 0;
    NUMBER some[ROWS];
    for (; a + ROWS <= d->count; a += ROWS) {
        NAME(dots)(n, d->by_rate + at + a * n, rate, d->by_place + at + a * n, place, some);
        for (int r = 0; r < ROWS; r++) y[(a + r) * S + j] = some[r];
    }
    for (; a < d->count; a++) NAME(dot)(n, d->by_rate + at + a * n, rate, d->by_place + at + a * n, place, y + a * S + j);
}

/* The modes' rates y (count, S) by accelerations x of a step, (size, S) by turns. work is ((S + 2) seen,). */
KIND void NAME(rates_of)(const pattern *p, const modal *d, long step, double h, const double *inner,
                           const double *square, const NUMBER *x, NUMBER *y, NUMBER *work)
{
    long n = d->seen;
    NUMBER *rate = work, *place = work + n, *made = place + n;
    NAME(seen_of_all)(p, d, x, made);
    for (int j = 0; j < S; j++) {
        for (long i = 0; i < n; i++) {
            NUMBER first = inner[BLOCK(j, 0)] * made[i], second = square[BLOCK(j, 0)] * made[i];
            for (int l = 1; l < S; l++) {
                first += inner[BLOCK(j, l)] * made[l * n + i];
                second += square[BLOCK(j, l)] * made[l * n + i];
            }
            rate[i] = h * first;
            place[i] = h * h * second;
        }
        NAME(rates_at)(d, step, j, rate, place, y);
    }
}

/* Take forces Z^T f from x, (size, S) by turns; f is (S, seen). */
KIND void NAME(spread)(const pattern *p, const modal *d, const NUMBER *f, NUMBER *x)
{
    for (long i = 0; i < p->size; i++) {
        NUMBER *to = x + (long)p->turn[i] * S;
        for (int l = 0; !d->begin && l < S; l++) to[l] -= f[l * d->seen + i];
        for (long e = d->begin ? d->back[i] : 0; d->begin && e < d->back[i + 1]; e++)
            for (int l = 0; l < S; l++) to[l] -= d->back_shares[e] * f[l * d->seen + d->rows[e]];
    }
}

/* Take forces F^T y at all points of a step from x, (size, S) by turns; y is (count, S). work is (S seen,). */
KIND void NAME(brake)(const pattern *p, const modal *d, long step, const NUMBER *y, NUMBER *x, NUMBER *work)
{
    long n = d->seen;
    for (int j = 0; j < S; j++)
        NAME(combine)(n, d->count, y + j, S, d->outward + (step * S + j) * d->count * n, work + j * n);
    NAME(spread)(p, d, work, x);
}

/* Take states (q, pace q') through the steps first to last - 1: from each row of starts to that of ends. Where ends is
   starts one row later, each step starts from where the one before it ended, and from what is gained in it.

   load and accelerations are (points, size), gain has a row a step; each may be none, and so may modes. work is
   ((2 S + 2) size,), and for modes 2 S count + (S + 3) seen more. */
KIND void NAME(marched)(const pattern *p, long first, long last, const double *damping, const double *stiffness,
                          const double *load, const double *gain, const double *duration, const double *inner,
                          const double *weights, const double *square, const double *points, const double *factors,
                          const modal *modes, double pace, const NUMBER *starts, NUMBER *ends, NUMBER *accelerations,
                          NUMBER *work)
{
    long n = p->size, m = modes ? modes->count * S : 0;
    NUMBER *x = work, *place = work + n * S, *more_x = place + 2 * n, *y = more_x + n * S, *z = y + m, *free = z + m;
    double of_place[S];
    for (int j = 0; j < S; j++) { /* b^T A, the weights of accelerations in the displacement at the end */
        of_place[j] = 0.0;
        for (int i = 0; i < S; i++) of_place[j] += weights[i] * inner[BLOCK(i, j)];
    }
    for (long k = first; k < last; k++) {
        const double *more = gain ? gain + (k - first) * 2 * n : 0;
        const NUMBER *from = starts + (k - first) * 2 * n;
        NUMBER *to = ends + (k - first) * 2 * n, *rate = place + n;
        double h = duration[k];
        for (long i = 0; i < n; i++) rate[i] = from[n + i] / pace;
        for (int j = 0; j < S; j++) {
            const double *c = damping + (k * S + j) * p->entries, *s = stiffness + (k * S + j) * p->entries;
            double ahead = h * points[j];
            for (long i = 0; i < n; i++) place[i] = from[i] + ahead * rate[i];
            for (long i = 0; i < n; i++) {
                NUMBER sum = (NUMBER){0.0} + (load ? load[(k * S + j) * n + i] : 0.0);
                for (long e = p->begin[i]; e < p->begin[i + 1]; e++)
                    sum -= s[e] * place[p->columns[e]] + c[e] * rate[p->columns[e]];
                x[(long)p->turn[i] * S + j] = sum;
            }
        }
        if (m) { /* the modes' rates by the state at the start */
            long few = modes->seen;
            NUMBER *first_seen = free + few, *rate_seen = first_seen + few;
            NAME(seen)(p, modes, from, first_seen);
            NAME(seen)(p, modes, rate, rate_seen);
            for (int j = 0; j < S; j++) {
                double ahead = h * points[j];
                for (long i = 0; i < few; i++) free[i] = first_seen[i] + ahead * rate_seen[i];
                NAME(rates_at)(modes, k, j, rate_seen, free, y);
            }
            NAME(brake)(p, modes, k, y, x, free);
        }
        NAME(substitute)(p, factors + k * p->blocks * S * S, x);
        if (m) { /* the modes' rates by the accelerations */
            NAME(rates_of)(p, modes, k, h, inner, square, x, y, free);
            for (long a = 0; a < m; a++) y[a] = -y[a];
            NAME(combine)(m, m, y, 1, modes->inverse + k * m * m, z);
            memset(more_x, 0, sizeof(NUMBER) * n * S);
            NAME(brake)(p, modes, k, z, more_x, free);
            NAME(substitute)(p, factors + k * p->blocks * S * S, more_x);
            for (long i = 0; i < n * S; i++) x[i] -= more_x[i];
        }
        for (long i = 0; i < n; i++) {
            const NUMBER *made = x + (long)p->turn[i] * S;
            NUMBER moved = of_place[0] * made[0], gained = weights[0] * made[0];
            for (int j = 1; j < S; j++) {
                moved += of_place[j] * made[j];
                gained += weights[j] * made[j];
            }
            for (int j = 0; accelerations && j < S; j++) accelerations[(k * S + j) * n + i] = made[j];
            to[i] = from[i] + h * rate[i] + h * h * moved;
            to[n + i] = from[n + i] + pace * h * gained;
            if (more) {
                to[i] += more[i];
                to[n + i] += more[n + i];
            }
        }
    }
}
