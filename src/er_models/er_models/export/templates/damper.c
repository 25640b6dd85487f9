/* @title@
 *
 * Written from the equations of er_models @version@ (model @digest@); do not edit.
 */
#include "@NAME@.h"

#include <math.h>
#include <string.h>

typedef @NAME@_parameters PARAMETERS;
typedef @NAME@_state STATE;

@types@

@functions@

/* Look at the equations at the end of a step of length h. */
static void look(STATE *d, const PARAMETERS *p, double h, double x, double v, double a, double t, double theta)
{
    const tuple_ddd found = solve(p, d->s, h, @HOLD@, x, v, a, d->u, t, theta);
    keep(d->s);
    d->true_force = found.v0;
    d->force = found.v1;
}

/* Another duty from now on: the equations are looked at before and after. */
static void turn(STATE *d, const PARAMETERS *p, double h, double x, double v, double a, double u, double t, double theta)
{
    look(d, p, h, x, v, a, t, theta);
    d->u = u;
    look(d, p, 0.0, x, v, a, t, theta);
}
//if input_delay

/* The oldest change of the duty that waits is taken away. */
static double next(STATE *d)
{
    const double duty = d->waiting[0].duty;
    d->many--;
    memmove(d->waiting, d->waiting + 1, (size_t) d->many * sizeof d->waiting[0]);
    return duty;
}
//end
//if output_delay

/* The force as it is shown `delay` later: a cubic through those that are kept, held beyond them. */
static double shown(STATE *d, double now, double delay)
{
    const double at_time = now - delay;
    int i, older;
    if (!d->kept || now > d->past[d->newest][0]) {
        d->newest = (d->newest + 1) % @QUEUE@;
        d->kept += d->kept < @QUEUE@;
    }
    d->past[d->newest][0] = now;
    d->past[d->newest][1] = d->force;
    if (d->kept < 2 || at_time >= now) return d->force;
#define AT(k) d->past[(d->newest + @QUEUE@ - (k)) % @QUEUE@]
    for (older = 1; older < d->kept - 1 && AT(older)[0] > at_time; older++) { }
    i = older;
    {
        const double t0 = AT(i)[0], t1 = AT(i - 1)[0], y0 = AT(i)[1], y1 = AT(i - 1)[1], slope = (y1 - y0) / (t1 - t0);
        const double m0 = i + 1 < d->kept ? (y1 - AT(i + 1)[1]) / (t1 - AT(i + 1)[0]) : slope;
        const double m1 = i > 1 ? (AT(i - 2)[1] - y0) / (AT(i - 2)[0] - t0) : slope;
        return hermite(y0, m0, y1, m1, t1 - t0, greater((at_time - t0) / (t1 - t0), 0.0));
    }
#undef AT
}
//end

void @NAME@_defaults(PARAMETERS *p)
{
@defaults@
}

double @NAME@_init(STATE *d, const PARAMETERS *p, double x, double v, double a, double u, double theta)
{
    double apart[@ROWS@][@STATES@];
    memset(d, 0, sizeof *d);
    d->x = x; d->v = v; d->a = a; d->u = u; d->theta = theta;
    d->force = settle(p, d->s, x, v, a, u, theta);
    memcpy(apart, d->s, sizeof apart);
    d->true_force = solve(p, apart, 0.0, @HOLD@, x, v, a, u, 0.0, theta).v0;
//if input_delay
    d->asked = u;
//end
//if output_delay
    d->newest = -1;
    d->force = shown(d, 0.0, 0.0);
//end
    return d->force;
}

double @NAME@_step(STATE *d, const PARAMETERS *p, double dt, double x, double v, double a, double u, double theta)
{
    const int n = (int) greater(1.0, ceil(dt / @SUBSTEP@ - 1e-9));
    const tuple_dddd x_k = cubic(d->x, d->v, x, v, dt), v_k = cubic(d->v, d->a, v, a, dt);
    double end = 0.0, now;
    int j, on_grid = 1;
    if (!(dt >= 0.0)) return d->force;
    if (dt == 0.0) {
        look(d, p, 0.0, x, v, a, d->began + d->steps * d->dt, theta);
    } else if (dt != d->dt) {
        d->began += d->steps * d->dt;
        d->steps = 0.0;
        d->dt = dt;
    }
    for (j = 1; j <= n && dt > 0.0; j++) {
        const double q = (double) j / n;
//if input_delay
        while (d->many && d->waiting[0].due < (1.0 - @ROUNDING@) * dt && d->waiting[0].due < q * dt) {
            const double c = greater(d->waiting[0].due / dt, end);
            turn(d, p, (c - end) * dt, at(x_k, c), at(v_k, c), d->a + c * (a - d->a), next(d),
                 d->began + (d->steps + c) * dt, d->theta + c * (theta - d->theta));
            end = c;
            on_grid = 0;
        }
//end
        look(d, p, on_grid ? dt / n : (q - end) * dt, at(x_k, q), at(v_k, q), d->a + q * (a - d->a),
             d->began + (d->steps + q) * dt, d->theta + q * (theta - d->theta));
        end = q;
        on_grid = 1;
    }
    d->steps += dt > 0.0;
    now = d->began + d->steps * d->dt;
//if input_delay
    for (j = 0; j < d->many; j++) d->waiting[j].due -= dt;
    if (u != d->asked) {
        if (d->many == @QUEUE@) d->many--;
        d->waiting[d->many].due = input_delay(p);
        d->waiting[d->many++].duty = d->asked = u;
    }
    while (d->many && d->waiting[0].due <= @ROUNDING@ * dt) turn(d, p, 0.0, x, v, a, next(d), now, theta);
//end
//if not input_delay
    if (u != d->u) turn(d, p, 0.0, x, v, a, u, now, theta);
//end
    d->x = x; d->v = v; d->a = a; d->theta = theta;
//if output_delay
    d->force = shown(d, now, output_delay(p));
//end
    return d->force;
}
