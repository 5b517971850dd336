/* FMI 3.0 for co-simulation: the order of calls, and the core behind it. */
#include "core.h"
#include "model.h"
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status;
typedef void (*log_function)(void *, status, const char *, const char *);
typedef uint32_t reference;

#define ANY (INSTANTIATED | INITIALIZATION | STEPPING | TERMINATED | FAILED)

static status fail(instance *it, const char *call) {
    char text[400];
    log_function log = (log_function)it->logger;
    snprintf(text, sizeof text, "%s: %s", call, it->said);
    if (log) log(it->environment, ERROR, "logStatusError", text);
    return ERROR;
}

static int allowed(instance *it, int modes, const char *call) {
    if (!it) return 0;
    if (it->mode & modes) return 1;
    strcpy(it->said, "is not allowed now");
    fail(it, call);
    return 0;
}

#define CHECK(modes)                                     \
    instance *it = c;                                    \
    if (!allowed(it, (modes), __func__)) return ERROR;

API const char *fmi3GetVersion(void) { return "3.0"; }

API void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                      bool logging, bool events, bool early, const reference *required,
                                      size_t n, void *environment, log_function log, void *update) {
    (void)resources, (void)visible, (void)logging, (void)early, (void)required, (void)n, (void)update;
    if (!name || events) return NULL;
    const char *refusal = core_refusal(token);
    if (refusal) {
        if (log) log(environment, ERROR, "logStatusError", refusal);
        return NULL;
    }
    instance *it = core_new(name);
    if (it) {
        it->logger = (void *)log;
        it->environment = environment;
    }
    return it;
}

API void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible,
                                       bool logging, void *environment, log_function log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
    return NULL;
}

API void *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources,
                                            bool visible, bool logging, void *environment, log_function log,
                                            void *update, void *lock, void *unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
    (void)update, (void)lock, (void)unlock;
    return NULL;
}

API void fmi3FreeInstance(void *c) {
    if (c) core_free(c);
}

API status fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const *categories) {
    (void)on, (void)n, (void)categories;
    CHECK(ANY)
    return OK;
}

API status fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start,
                                       bool has_stop, double stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    CHECK(INSTANTIATED)
    it->start = it->now = start;
    it->mode = INITIALIZATION;
    return OK;
}

API status fmi3ExitInitializationMode(void *c) {
    CHECK(INITIALIZATION)
    it->mode = STEPPING;
    return OK;
}

API status fmi3Terminate(void *c) {
    CHECK(STEPPING)
    it->mode = TERMINATED;
    return OK;
}

API status fmi3Reset(void *c) {
    CHECK(ANY)
    if (!core_reset(it)) return fail(it, __func__);
    return OK;
}

API status fmi3GetFloat64(void *c, const reference *r, size_t n, double *values, size_t n_values) {
    CHECK(INITIALIZATION | STEPPING | TERMINATED)
    if (n != n_values || (n && (!r || !values))) return fail(it, __func__);
    for (size_t k = 0; k < n; k++)
        if (!core_get(it, r[k], values + k)) return fail(it, __func__);
    return OK;
}

API status fmi3SetFloat64(void *c, const reference *r, size_t n, const double *values, size_t n_values) {
    CHECK(INSTANTIATED | INITIALIZATION | STEPPING)
    if (n != n_values || (n && (!r || !values))) return fail(it, __func__);
    for (size_t k = 0; k < n; k++)
        if (!core_set(it, r[k], values[k])) return fail(it, __func__);
    return OK;
}

API status fmi3DoStep(void *c, double time, double step, bool no_return, bool *event, bool *terminate,
                      bool *early, double *last) {
    (void)no_return;
    CHECK(STEPPING)
    if (event) *event = false;
    if (terminate) *terminate = false;
    if (early) *early = false;
    int done = core_step(it, time, step);
    if (last) *last = it->now;
    if (done) return OK;
    it->mode = FAILED;
    return fail(it, __func__);
}

API status fmi3GetFMUState(void *c, void **state) {
    CHECK(ANY)
    return core_get_state(it, state) ? OK : fail(it, __func__);
}

API status fmi3SetFMUState(void *c, void *state) {
    CHECK(ANY)
    return state && core_load(it, state, core_saved_size(state)) ? OK : fail(it, __func__);
}

API status fmi3FreeFMUState(void *c, void **state) {
    CHECK(ANY)
    core_free_state(state);
    return OK;
}

API status fmi3SerializedFMUStateSize(void *c, void *state, size_t *size) {
    CHECK(ANY)
    if (!state || !size) return fail(it, __func__);
    *size = core_saved_size(state);
    return OK;
}

API status fmi3SerializeFMUState(void *c, void *state, uint8_t *bytes, size_t size) {
    CHECK(ANY)
    if (!state || !bytes || size < core_saved_size(state)) return fail(it, __func__);
    memcpy(bytes, state, core_saved_size(state));
    return OK;
}

API status fmi3DeserializeFMUState(void *c, const uint8_t *bytes, size_t size, void **state) {
    CHECK(ANY)
    return core_set_bytes(state, bytes, size) ? OK : fail(it, __func__);
}

/* there are variables of type Float64 only, and none that changes at events */
#define NO_VARIABLES(type, c_type)                                                                       \
    API status fmi3Get##type(void *c, const reference *r, size_t n, c_type *values, size_t n_values) {   \
        (void)r, (void)values, (void)n_values;                                                           \
        CHECK(ANY)                                                                                       \
        return n ? ERROR : OK;                                                                           \
    }                                                                                                    \
    API status fmi3Set##type(void *c, const reference *r, size_t n, const c_type *values,                \
                             size_t n_values) {                                                          \
        (void)r, (void)values, (void)n_values;                                                           \
        CHECK(ANY)                                                                                       \
        return n ? ERROR : OK;                                                                           \
    }
NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
NO_VARIABLES(Boolean, bool)
NO_VARIABLES(String, const char *)

/* what the description says it cannot do */
#define CANNOT(call)                \
    API status call(void *c) {      \
        (void)c;                    \
        return ERROR;               \
    }
CANNOT(fmi3GetBinary)
CANNOT(fmi3SetBinary)
CANNOT(fmi3GetClock)
CANNOT(fmi3SetClock)
CANNOT(fmi3GetNumberOfVariableDependencies)
CANNOT(fmi3GetVariableDependencies)
CANNOT(fmi3GetDirectionalDerivative)
CANNOT(fmi3GetAdjointDerivative)
CANNOT(fmi3EnterConfigurationMode)
CANNOT(fmi3ExitConfigurationMode)
CANNOT(fmi3GetIntervalDecimal)
CANNOT(fmi3GetIntervalFraction)
CANNOT(fmi3GetShiftDecimal)
CANNOT(fmi3GetShiftFraction)
CANNOT(fmi3SetIntervalDecimal)
CANNOT(fmi3SetIntervalFraction)
CANNOT(fmi3SetShiftDecimal)
CANNOT(fmi3SetShiftFraction)
CANNOT(fmi3EvaluateDiscreteStates)
CANNOT(fmi3UpdateDiscreteStates)
CANNOT(fmi3EnterEventMode)
CANNOT(fmi3EnterStepMode)
CANNOT(fmi3EnterContinuousTimeMode)
CANNOT(fmi3CompletedIntegratorStep)
CANNOT(fmi3SetTime)
CANNOT(fmi3SetContinuousStates)
CANNOT(fmi3GetContinuousStateDerivatives)
CANNOT(fmi3GetEventIndicators)
CANNOT(fmi3GetContinuousStates)
CANNOT(fmi3GetNominalsOfContinuousStates)
CANNOT(fmi3GetNumberOfEventIndicators)
CANNOT(fmi3GetNumberOfContinuousStates)
CANNOT(fmi3GetOutputDerivatives)
CANNOT(fmi3ActivateModelPartition)
