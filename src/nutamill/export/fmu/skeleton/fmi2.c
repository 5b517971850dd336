/* FMI 2.0 for co-simulation: the order of calls, and the core behind it. */
#include "core.h"
#include "model.h"
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } status;
typedef void (*log_function)(void *, const char *, status, const char *, const char *, ...);
typedef struct {
    log_function logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, status);
    void *environment;
} callbacks;

#define ANY (INSTANTIATED | INITIALIZATION | STEPPING | TERMINATED | FAILED)

static status fail(instance *it, const char *call) {
    log_function log = (log_function)it->logger;
    if (log) log(it->environment, it->name, ERROR, "logStatusError", "%s: %s", call, it->said);
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

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }

API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const callbacks *f, int visible, int logging) {
    (void)resources, (void)visible, (void)logging;
    if (!name || type != 1) return NULL;
    const char *refusal = core_refusal(guid);
    if (refusal) {
        if (f && f->logger)
            f->logger(f->environment, name, ERROR, "logStatusError", "%s: %s", __func__, refusal);
        return NULL;
    }
    instance *it = core_new(name);
    if (it && f) {
        it->logger = (void *)f->logger;
        it->environment = f->environment;
    }
    return it;
}

API void fmi2FreeInstance(void *c) {
    if (c) core_free(c);
}

API status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *categories) {
    (void)on, (void)n, (void)categories;
    CHECK(ANY)
    return OK;
}

API status fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int has_stop,
                               double stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    CHECK(INSTANTIATED)
    it->start = it->now = start;
    return OK;
}

API status fmi2EnterInitializationMode(void *c) {
    CHECK(INSTANTIATED)
    it->mode = INITIALIZATION;
    return OK;
}

API status fmi2ExitInitializationMode(void *c) {
    CHECK(INITIALIZATION)
    it->mode = STEPPING;
    return OK;
}

API status fmi2Terminate(void *c) {
    CHECK(STEPPING)
    it->mode = TERMINATED;
    return OK;
}

API status fmi2Reset(void *c) {
    CHECK(ANY)
    if (!core_reset(it)) return fail(it, __func__);
    return OK;
}

API status fmi2GetReal(void *c, const unsigned *r, size_t n, double *values) {
    CHECK(INITIALIZATION | STEPPING | TERMINATED)
    if (n && (!r || !values)) return fail(it, __func__);
    for (size_t k = 0; k < n; k++)
        if (!core_get(it, r[k], values + k)) return fail(it, __func__);
    return OK;
}

API status fmi2SetReal(void *c, const unsigned *r, size_t n, const double *values) {
    CHECK(INSTANTIATED | INITIALIZATION | STEPPING)
    if (n && (!r || !values)) return fail(it, __func__);
    for (size_t k = 0; k < n; k++)
        if (!core_set(it, r[k], values[k])) return fail(it, __func__);
    return OK;
}

/* there are real variables only */
#define NO_VARIABLES(call, type)                                       \
    API status call(void *c, const unsigned *r, size_t n, type values) { \
        (void)r, (void)values;                                         \
        CHECK(ANY)                                                     \
        return n ? ERROR : OK;                                         \
    }
NO_VARIABLES(fmi2GetInteger, int *)
NO_VARIABLES(fmi2GetBoolean, int *)
NO_VARIABLES(fmi2GetString, const char **)
NO_VARIABLES(fmi2SetInteger, const int *)
NO_VARIABLES(fmi2SetBoolean, const int *)
NO_VARIABLES(fmi2SetString, const char *const *)

API status fmi2DoStep(void *c, double time, double step, int no_return) {
    (void)no_return;
    CHECK(STEPPING)
    if (core_step(it, time, step)) return OK;
    it->mode = FAILED;
    return fail(it, __func__);
}

API status fmi2GetFMUstate(void *c, void **state) {
    CHECK(ANY)
    return core_get_state(it, state) ? OK : fail(it, __func__);
}

API status fmi2SetFMUstate(void *c, void *state) {
    CHECK(ANY)
    return state && core_load(it, state, core_saved_size(state)) ? OK : fail(it, __func__);
}

API status fmi2FreeFMUstate(void *c, void **state) {
    CHECK(ANY)
    core_free_state(state);
    return OK;
}

API status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) {
    CHECK(ANY)
    if (!state || !size) return fail(it, __func__);
    *size = core_saved_size(state);
    return OK;
}

API status fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t size) {
    CHECK(ANY)
    if (!state || !bytes || size < core_saved_size(state)) return fail(it, __func__);
    memcpy(bytes, state, core_saved_size(state));
    return OK;
}

API status fmi2DeSerializeFMUstate(void *c, const char *bytes, size_t size, void **state) {
    CHECK(ANY)
    return core_set_bytes(state, bytes, size) ? OK : fail(it, __func__);
}

/* what the description says it cannot do */
API status fmi2GetDirectionalDerivative(void *c, const unsigned *u, size_t nu, const unsigned *k, size_t nk,
                                        const double *dk, double *du) {
    (void)c, (void)u, (void)nu, (void)k, (void)nk, (void)dk, (void)du;
    return ERROR;
}
API status fmi2SetRealInputDerivatives(void *c, const unsigned *r, size_t n, const int *order,
                                       const double *values) {
    (void)c, (void)r, (void)n, (void)order, (void)values;
    return ERROR;
}
API status fmi2GetRealOutputDerivatives(void *c, const unsigned *r, size_t n, const int *order,
                                        double *values) {
    (void)c, (void)r, (void)n, (void)order, (void)values;
    return ERROR;
}
API status fmi2CancelStep(void *c) {
    (void)c;
    return ERROR;
}
API status fmi2GetStatus(void *c, int kind, status *value) {
    (void)c, (void)kind, (void)value;
    return DISCARD;
}
API status fmi2GetRealStatus(void *c, int kind, double *value) {
    CHECK(STEPPING | FAILED)
    if (kind != 2 || !value) return DISCARD; /* the last successful time */
    *value = it->now;
    return OK;
}
API status fmi2GetIntegerStatus(void *c, int kind, int *value) {
    (void)c, (void)kind, (void)value;
    return DISCARD;
}
API status fmi2GetBooleanStatus(void *c, int kind, int *value) {
    CHECK(STEPPING | FAILED)
    if (kind != 3 || !value) return DISCARD; /* whether it ended by itself */
    *value = 0;
    return OK;
}
API status fmi2GetStringStatus(void *c, int kind, const char **value) {
    (void)c, (void)kind, (void)value;
    return DISCARD;
}
