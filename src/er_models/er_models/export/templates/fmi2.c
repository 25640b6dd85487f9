/* FMI 2.0 for co-simulation around the damper. Names and types are those of the standard (fmi-standard.org). */
#include "unit.h"

#define UNUSED(x) (void) (x)

typedef void *fmi2Component;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

static fmi2Status status(int well) { return well ? fmi2OK : fmi2Error; }

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    UNUSED(c); UNUSED(on); UNUSED(n); UNUSED(categories);
    return fmi2OK;
}
EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const void *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    UNUSED(name); UNUSED(resources); UNUSED(functions); UNUSED(visible); UNUSED(logging);
    return type == fmi2CoSimulation && guid && !strcmp(guid, TOKEN) ? unit_new() : NULL;
}
EXPORT void fmi2FreeInstance(fmi2Component c) { free(c); }
EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                      fmi2Boolean has_stop, fmi2Real stop)
{
    UNUSED(has_tolerance); UNUSED(tolerance); UNUSED(has_stop); UNUSED(stop);
    ((UNIT *) c)->time = start;
    return fmi2OK;
}
EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) { UNUSED(c); return fmi2OK; }
EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    UNIT *m = c;
    unit_begin(m);
    m->begun = 1;
    return status(isfinite(m->d.force));
}
EXPORT fmi2Status fmi2Terminate(fmi2Component c) { UNUSED(c); return fmi2OK; }
EXPORT fmi2Status fmi2Reset(fmi2Component c) { unit_reset(c); return fmi2OK; }
EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    return status(unit_get(c, vr, n, value));
}
EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    return status(unit_set(c, vr, n, value));
}
EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != AT_START) return fmi2Error;
        value[i] = ((UNIT *) c)->at_start;
    }
    return fmi2OK;
}
EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != AT_START) return fmi2Error;
        ((UNIT *) c)->at_start = value[i] != 0;
    }
    return fmi2OK;
}
#define NONE(what, type) \
    EXPORT fmi2Status fmi2##what(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) \
    { \
        UNUSED(c); UNUSED(vr); UNUSED(value); \
        return status(n == 0); \
    }
NONE(GetInteger, fmi2Integer)
NONE(SetInteger, const fmi2Integer)
NONE(GetString, fmi2String)
NONE(SetString, const fmi2String)

EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return status(unit_save(c, state));
}
EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { memcpy(c, state, sizeof(UNIT)); return fmi2OK; }
EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    UNUSED(c);
    free(*state);
    *state = NULL;
    return fmi2OK;
}
EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    UNUSED(c); UNUSED(state);
    *size = sizeof(UNIT);
    return fmi2OK;
}
EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    UNUSED(c);
    return status(unit_write(state, bytes, size));
}
EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    return status(unit_read(c, bytes, size, state));
}
EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n,
                                               const fmi2ValueReference known[], size_t m, const fmi2Real seed[],
                                               fmi2Real value[])
{
    UNUSED(c); UNUSED(unknown); UNUSED(n); UNUSED(known); UNUSED(m); UNUSED(seed); UNUSED(value);
    return fmi2Error;
}
EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                              const fmi2Integer order[], const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < DEFLECTION || vr[i] > TEMPERATURE || order[i] != 1) return fmi2Error;
        ((UNIT *) c)->rate[vr[i] - DEFLECTION] = value[i];
    }
    return fmi2OK;
}
EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                               const fmi2Integer order[], fmi2Real value[])
{
    UNUSED(c); UNUSED(vr); UNUSED(order); UNUSED(value);
    return status(n == 0);
}
EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real start, fmi2Real step, fmi2Boolean no_return)
{
    UNUSED(no_return);
    return status(unit_step(c, start, step));
}
EXPORT fmi2Status fmi2CancelStep(fmi2Component c) { UNUSED(c); return fmi2Error; }
EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    UNUSED(c); UNUSED(kind); UNUSED(value);
    return fmi2Discard;
}
EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((UNIT *) c)->time;
    return fmi2OK;
}
EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    UNUSED(c); UNUSED(kind); UNUSED(value);
    return fmi2Discard;
}
EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    UNUSED(c);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = 0;
    return fmi2OK;
}
EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    UNUSED(c); UNUSED(kind); UNUSED(value);
    return fmi2Discard;
}
