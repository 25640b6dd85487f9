/* The damper as a unit of a co-simulation, the same for FMI 2 and 3. */
#include "@NAME@.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

#define TOKEN "@TOKEN@"

/* Value references; parameters follow from FIRST on in the order of their struct. */
enum { TIME, DEFLECTION, VELOCITY, ACCELERATION, DUTY, TEMPERATURE, FORCE, TRUE_FORCE, AT_START, FIRST = 16, LAST = FIRST + @COUNT@ };
enum { INPUTS = 5 };

typedef struct {
    @NAME@_parameters p;
    @NAME@_state d;
    double time, in[INPUTS], rate[INPUTS];
    int at_start, begun;
} UNIT;

static UNIT *unit_new(void)
{
    UNIT *m = calloc(1, sizeof *m);
    if (m) @NAME@_defaults(&m->p);
    return m;
}

/* Begin in equilibrium with the inputs as they are. */
static void unit_begin(UNIT *m)
{
    @NAME@_init(&m->d, &m->p, m->in[0], m->in[1], m->in[2], m->in[3], m->in[4]);
}

static double *unit_place(UNIT *m, unsigned int reference)
{
    if (reference >= FIRST && reference < LAST) return (double *) &m->p + (reference - FIRST);
    if (reference >= DEFLECTION && reference <= TEMPERATURE) return &m->in[reference - DEFLECTION];
    if (!m->begun && (reference == FORCE || reference == TRUE_FORCE)) unit_begin(m);
    return reference == TIME ? &m->time : reference == FORCE ? &m->d.force : reference == TRUE_FORCE ? &m->d.true_force : NULL;
}

/* Whether all went well. */
static int unit_get(UNIT *m, const unsigned int references[], size_t n, double values[])
{
    for (size_t i = 0; i < n; i++) {
        const double *place = unit_place(m, references[i]);
        if (!place) return 0;
        values[i] = *place;
    }
    return 1;
}

static int unit_set(UNIT *m, const unsigned int references[], size_t n, const double values[])
{
    for (size_t i = 0; i < n; i++) {
        const unsigned int r = references[i];
        double *place = unit_place(m, r);
        if (!place || r == TIME || r == FORCE || r == TRUE_FORCE) return 0;
        *place = values[i];
        if (r <= TEMPERATURE) m->rate[r - DEFLECTION] = 0.0;
    }
    return 1;
}

/* One step of length h. The inputs, and what their derivatives add to them within the step, are those at its end; where
 * `inputs_at_start` is set they are those at its beginning, and velocity and acceleration carry the motion on. */
static int unit_step(UNIT *m, double start, double h)
{
    double end[INPUTS];
    if (!(h >= 0.0) || isinf(h)) return 0;
    if (m->at_start) {
        @NAME@_step(&m->d, &m->p, 0.0, m->in[0], m->in[1], m->in[2], m->in[3], m->in[4]);
    }
    for (int i = 0; i < INPUTS; i++) {
        end[i] = m->in[i] + h * (m->at_start ? 0.0 : m->rate[i]);
        m->rate[i] = 0.0;
    }
    if (m->at_start) {
        end[0] += h * (m->in[1] + 0.5 * h * m->in[2]);
        end[1] += h * m->in[2];
    }
    @NAME@_step(&m->d, &m->p, h, end[0], end[1], end[2], end[3], end[4]);
    m->time = start + h;
    return isfinite(m->d.force) != 0;
}

/* A unit as it is, in memory of its own or as bytes. */
static int unit_save(const void *m, void **state)
{
    if (!*state) *state = malloc(sizeof(UNIT));
    if (*state) memcpy(*state, m, sizeof(UNIT));
    return *state != NULL;
}

static int unit_write(const void *state, void *bytes, size_t size)
{
    if (size < sizeof(UNIT)) return 0;
    memcpy(bytes, state, sizeof(UNIT));
    return 1;
}

static int unit_read(const void *m, const void *bytes, size_t size, void **state)
{
    if (size != sizeof(UNIT) || !unit_save(m, state)) return 0;
    memcpy(*state, bytes, sizeof(UNIT));
    return 1;
}

static void unit_reset(UNIT *m)
{
    memset(m, 0, sizeof *m);
    @NAME@_defaults(&m->p);
}
