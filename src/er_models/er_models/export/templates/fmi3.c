/* FMI 3.0 for co-simulation around the damper. Names and types are those of the standard (fmi-standard.org). */
#include "unit.h"

#include <stdbool.h>
#include <stdint.h>

#define UNUSED(x) (void) (x)

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char *fmi3String;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);

static fmi3Status status(int well) { return well ? fmi3OK : fmi3Error; }

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    UNUSED(c); UNUSED(on); UNUSED(n); UNUSED(categories);
    return fmi3OK;
}
EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
    fmi3Boolean early, const fmi3ValueReference wanted[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, void *update)
{
    UNUSED(name); UNUSED(resources); UNUSED(visible); UNUSED(logging); UNUSED(early); UNUSED(wanted); UNUSED(n);
    UNUSED(update);
    if (!events && token && !strcmp(token, TOKEN)) return unit_new();
    if (log) log(environment, fmi3Error, "error", "the token is that of another FMU, or event mode is asked for");
    return NULL;
}
EXPORT fmi3Instance fmi3InstantiateModelExchange(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    UNUSED(name); UNUSED(token); UNUSED(resources); UNUSED(visible); UNUSED(logging); UNUSED(environment); UNUSED(log);
    return NULL;
}
EXPORT fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, void *clock, void *lock, void *unlock)
{
    UNUSED(name); UNUSED(token); UNUSED(resources); UNUSED(visible); UNUSED(logging); UNUSED(environment); UNUSED(log);
    UNUSED(clock); UNUSED(lock); UNUSED(unlock);
    return NULL;
}
EXPORT void fmi3FreeInstance(fmi3Instance c) { free(c); }
EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                              fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop)
{
    UNUSED(has_tolerance); UNUSED(tolerance); UNUSED(has_stop); UNUSED(stop);
    ((UNIT *) c)->time = start;
    return fmi3OK;
}
EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    UNIT *m = c;
    unit_begin(m);
    m->begun = 1;
    return status(isfinite(m->d.force));
}
EXPORT fmi3Status fmi3Terminate(fmi3Instance c) { UNUSED(c); return fmi3OK; }
EXPORT fmi3Status fmi3Reset(fmi3Instance c) { unit_reset(c); return fmi3OK; }
EXPORT fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[], size_t m)
{
    return status(n == m && unit_get(c, vr, n, values));
}
EXPORT fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[], size_t m)
{
    return status(n == m && unit_set(c, vr, n, values));
}
EXPORT fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean values[], size_t m)
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != AT_START || i >= m) return fmi3Error;
        values[i] = ((UNIT *) c)->at_start != 0;
    }
    return fmi3OK;
}
EXPORT fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean values[], size_t m)
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != AT_START || i >= m) return fmi3Error;
        ((UNIT *) c)->at_start = values[i];
    }
    return fmi3OK;
}
/* Types that the damper has no variables of. */
#define NONE(name) \
    EXPORT fmi3Status fmi3Get##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##name values[], size_t m) \
    { \
        UNUSED(c); UNUSED(vr); UNUSED(values); UNUSED(m); \
        return status(n == 0); \
    } \
    EXPORT fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##name values[], size_t m) \
    { \
        UNUSED(c); UNUSED(vr); UNUSED(values); UNUSED(m); \
        return status(n == 0); \
    }
NONE(Float32)
NONE(Int8)
NONE(UInt8)
NONE(Int16)
NONE(UInt16)
NONE(Int32)
NONE(UInt32)
NONE(Int64)
NONE(UInt64)
NONE(String)
/* Functions of what the damper does not offer; whoever reads modelDescription.xml does not call them. */
#define NOT_OFFERED(name) \
    EXPORT fmi3Status fmi3##name(fmi3Instance c) \
    { \
        UNUSED(c); \
        return fmi3Error; \
    }
NOT_OFFERED(GetBinary)
NOT_OFFERED(SetBinary)
NOT_OFFERED(GetClock)
NOT_OFFERED(SetClock)
NOT_OFFERED(GetNumberOfVariableDependencies)
NOT_OFFERED(GetVariableDependencies)
NOT_OFFERED(GetDirectionalDerivative)
NOT_OFFERED(GetAdjointDerivative)
NOT_OFFERED(EnterConfigurationMode)
NOT_OFFERED(ExitConfigurationMode)
NOT_OFFERED(GetIntervalDecimal)
NOT_OFFERED(GetIntervalFraction)
NOT_OFFERED(GetShiftDecimal)
NOT_OFFERED(GetShiftFraction)
NOT_OFFERED(SetIntervalDecimal)
NOT_OFFERED(SetIntervalFraction)
NOT_OFFERED(SetShiftDecimal)
NOT_OFFERED(SetShiftFraction)
NOT_OFFERED(EnterEventMode)
NOT_OFFERED(EvaluateDiscreteStates)
NOT_OFFERED(UpdateDiscreteStates)
NOT_OFFERED(EnterStepMode)
NOT_OFFERED(EnterContinuousTimeMode)
NOT_OFFERED(CompletedIntegratorStep)
NOT_OFFERED(SetTime)
NOT_OFFERED(SetContinuousStates)
NOT_OFFERED(GetContinuousStateDerivatives)
NOT_OFFERED(GetEventIndicators)
NOT_OFFERED(GetContinuousStates)
NOT_OFFERED(GetNominalsOfContinuousStates)
NOT_OFFERED(GetNumberOfEventIndicators)
NOT_OFFERED(GetNumberOfContinuousStates)
NOT_OFFERED(GetOutputDerivatives)
NOT_OFFERED(ActivateModelPartition)

EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return status(unit_save(c, state));
}
EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { memcpy(c, state, sizeof(UNIT)); return fmi3OK; }
EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    UNUSED(c);
    free(*state);
    *state = NULL;
    return fmi3OK;
}
EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    UNUSED(c); UNUSED(state);
    *size = sizeof(UNIT);
    return fmi3OK;
}
EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    UNUSED(c);
    return status(unit_write(state, bytes, size));
}
EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    return status(unit_read(c, bytes, size, state));
}
EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 start, fmi3Float64 step, fmi3Boolean no_return, fmi3Boolean *event,
                             fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    const int well = unit_step(c, start, step);
    UNUSED(no_return);
    *event = *terminate = *early = false;
    *last = ((UNIT *) c)->time;
    return status(well);
}
