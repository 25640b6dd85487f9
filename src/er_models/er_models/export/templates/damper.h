/* @title@
 *
 * Written from the equations of er_models @version@ (model @digest@); do not edit. C99, no allocation, no globals.
 *
 * Deflection and force are positive in extension; a positive force resists extension. SI units; duty 0 to 1.
 */
#ifndef @GUARD@
#define @GUARD@

#ifdef __cplusplus
extern "C" {
#endif

/* Values of the model; @NAME@_defaults sets them. Bounds are those within which the lab fits. */
typedef struct {
@parameters@
} @NAME@_parameters;

/* The damper between two steps. Its members are its own affair, but for the two forces. */
typedef struct {
    double force;      /* [N] as the load cell shows it: what er_models predicts */
    double true_force; /* [N] of the damper itself, before the lag, gain and delay of its sensor */
    double x, v, a, u, theta;
    double began, dt, steps;
    double s[@ROWS@][@STATES@];
//if input_delay
    struct { double due, duty; } waiting[@QUEUE@]; /* changes of the duty within the dead time */
    int many;
    double asked;
//end
//if output_delay
    double past[@QUEUE@][2]; /* times and forces, the newest at `newest` */
    int newest, kept;
//end
} @NAME@_state;

void @NAME@_defaults(@NAME@_parameters *p);

/* Begin in equilibrium with the first sample (states that integrate begin at zero). Returns the force [N].
 * x deflection [m], v velocity [m/s], a acceleration [m/s2], u duty [1], theta temperature above the reference [K]. */
double @NAME@_init(@NAME@_state *d, const @NAME@_parameters *p, double x, double v, double a, double u, double theta);

/* One step of dt [s], to the motion x, v, a and temperature theta at its end. Returns the force [N] there.
 * Within the step the deflection is the cubic through both ends and their velocities, the velocity that through both
 * ends and their accelerations; acceleration and temperature are straight lines. The duty u acts from the end on: within
 * the step the one before is held. A step of no length only looks at other inputs. Steps of the integrator are at most @SUBSTEP@ s long, whatever dt.
//if input_delay
 * Of the changes of the duty within the dead time @QUEUE@ are kept; of more the newest one replaces the last.
//end
//if output_delay
 * A force that is delayed by less than one step, or comes early, is that of what is known: its end is not foreseen.
//end
 */
double @NAME@_step(@NAME@_state *d, const @NAME@_parameters *p, double dt, double x, double v, double a, double u, double theta);

#ifdef __cplusplus
}
#endif

#endif
