/* The loops of the kernel for one damper, the dynamic Guo model, and for the quarter car with it, as one would write them
   in C for that model alone: no masks, no list of effects, constants kept in registers.

   Same equations (1.12), (2.5), same integrators and tolerances as er_models/kernel; the results agree to rounding. */

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct { double k0, c0, f_c, k1, c1, tau; } damper_t;
typedef struct { double m_s, m_us, k_s, k_t; } car_t;

enum { BITS = 6, PIECES = 1 << BITS };
static int64_t table[PIECES];
static double low_part, high_part;

/* Table of 2^(i / PIECES) less the bits of i, and the length of a piece in two parts. */
void prepare(const int64_t *powers, double high, double low) {
    memcpy(table, powers, sizeof table);
    high_part = high;
    low_part = low;
}

/* fmax of the library is a call. */
static inline double larger(double a, double b) { return a > b ? a : b; }

/* Exponential of -708 < x <= 0, by the table and a polynomial. */
static inline double exponential(double x) {
    const double shift = 6755399441055744.0;
    double whole = x * (PIECES / 0.69314718055994530942) + shift, power, r, square;
    int64_t n, bits;
    memcpy(&n, &whole, sizeof n);
    whole -= shift;
    r = (x - whole * high_part) - whole * low_part;
    bits = table[n & (PIECES - 1)] + (int64_t)((uint64_t)n << (52 - BITS));
    memcpy(&power, &bits, sizeof power);
    square = r * r;
    return power + power * (r + square * ((0.5 + r / 6.0) + square * (1.0 / 24.0 + r / 120.0)));
}

static inline double hyperbolic(double x) {
    double e = exponential(larger(-2.0 * fabs(x), -700.0));
    return copysign((1.0 - e) / (1.0 + e), x);
}

static inline double asked(const damper_t *d, double x, double v, double u) {
    return d->f_c * u * hyperbolic(d->k1 * x + d->c1 * v);
}

/* Force (n,) along a motion, n_sub steps of first-order hold a sample. */
void predict(const damper_t *d, int64_t n, double dt, int64_t n_sub, const double *x, const double *v, const double *a,
             const double *u, double *force) {
    const double h = dt / n_sub, rate = 1.0 / d->tau, z = h * rate;
    const double decay = exponential(-z), one = (1.0 - decay) / z, two = (1.0 - one) / z;
    const double before = h * (one - two) * rate, after = h * two * rate;
    double w = asked(d, x[0], v[0], u[0]), last = w;
    force[0] = d->k0 * x[0] + d->c0 * v[0] + w;
    for (int64_t k = 0; k + 1 < n; k++) {
        double rise = x[k + 1] - x[k], e0 = dt * v[k], e1 = dt * v[k + 1];
        double x2 = 3.0 * rise - 2.0 * e0 - e1, x3 = e0 + e1 - 2.0 * rise;
        double climb = v[k + 1] - v[k], g0 = dt * a[k], g1 = dt * a[k + 1];
        double v2 = 3.0 * climb - 2.0 * g0 - g1, v3 = g0 + g1 - 2.0 * climb, x_q = x[k], v_q = v[k];
        if (k > 0 && u[k] != u[k - 1]) last = asked(d, x[k], v[k], u[k]);
        for (int64_t j = 0; j < n_sub; j++) {
            double q = (j + 1.0) / n_sub, y;
            x_q = x[k] + q * (e0 + q * (x2 + q * x3));
            v_q = v[k] + q * (g0 + q * (v2 + q * v3));
            y = asked(d, x_q, v_q, u[k]);
            w = decay * w + (before * last + after * y);
            last = y;
        }
        force[k + 1] = d->k0 * x_q + d->c0 * v_q + w;
    }
}

/* Velocities of both masses at the end of a stage; the wheel's by a secant of slope q0[4]. */
static inline void bodies(const car_t *c, double *q0, double *q, double f_d, double h, double road_rate, double tolerance) {
    double at = q[3], miss = 0.0, f_s = c->k_s * q[0];
    for (int i = 0; i < 60; i++) {
        double ahead;
        q[2] = q0[2] + h * (q[3] - road_rate);
        q[1] = q0[1] - h * (f_s + f_d) / c->m_s;
        ahead = q0[3] + h * (f_s + f_d - c->k_t * q[2]) / c->m_us - q[3];
        if (!(fabs(ahead) > 1e-3 * tolerance)) break;
        if (i > 0 && q[3] != at) q0[4] = larger((miss - ahead) / (q[3] - at), 0.5);
        at = q[3], miss = ahead;
        q[3] += ahead / q0[4];
    }
}

/* One implicit stage, a bracketed secant in the deflection velocity; returns the slope of the miss. */
static inline double stage(const damper_t *d, const car_t *c, double *q0, double w0, double *w, double *q, double v, double slope,
                           double u, double h, double road_rate, double tolerance) {
    const double rate = 1.0 / d->tau;
    double low = -INFINITY, high = INFINITY, v_last = v, miss_last = 0.0;
    for (int i = 0; i < 60; i++) {
        double miss;
        q[0] = q0[0] + h * v;
        *w = (w0 + h * rate * asked(d, q[0], v, u)) / (1.0 + h * rate);
        bodies(c, q0, q, d->k0 * q[0] + d->c0 * v + *w, h, road_rate, tolerance);
        miss = v - (q[1] - q[3]);
        if (!(fabs(miss) > tolerance)) break;
        if (miss > 0.0) high = v; else low = v;
        if (i > 0 && v != v_last) slope = larger((miss - miss_last) / (v - v_last), 0.5);
        v_last = v, miss_last = miss;
        v -= miss / slope;
        if (!(low < v && v < high)) v = isfinite(low) && isfinite(high) ? 0.5 * (low + high) : v_last - miss;
    }
    return slope;
}

/* The quarter car from rest over n samples of a road (n + 1,); outputs (n, 5): both accelerations, force, deflection and its velocity. */
void simulate(const damper_t *d, const car_t *c, int64_t n, double dt, int64_t n_sub, double tolerance, const double *road,
              const double *u, double *outputs) {
    const double gamma = 1.0 - 1.0 / sqrt(2.0), again = (1.0 - gamma) / gamma, gh = gamma * dt / n_sub;
    double q[4] = {0}, q0[5], w = 0.0;
    for (int64_t k = 0; k < n; k++) {
        double road_rate = (road[k + 1] - road[k]) / dt, slope = 1.0, rate = 0.0, f_d, *out = outputs + 5 * k;
        q0[4] = 1.0;
        for (int64_t i = 0; i < n_sub; i++) {
            double w0 = w, base;
            memcpy(q0, q, sizeof q);
            for (int s = 0; s < 2; s++) {
                if (s == 1) {
                    for (int j = 0; j < 4; j++) q0[j] += again * (q[j] - q0[j]);
                    w0 += again * (w - w0);
                }
                base = q0[1] - q0[3];
                slope = stage(d, c, q0, w0, &w, q, base + gh * rate, slope, u[k], gh, road_rate, tolerance);
                rate = (q[1] - q[3] - base) / gh;
            }
        }
        f_d = d->k0 * q[0] + d->c0 * (q[1] - q[3]) + w;
        out[0] = -(c->k_s * q[0] + f_d) / c->m_s;
        out[1] = (c->k_s * q[0] + f_d - c->k_t * q[2]) / c->m_us;
        out[2] = f_d, out[3] = q[0], out[4] = q[1] - q[3];
    }
}
