/* The machine behind both versions of FMI: one block of numbers and what is done with it. */
#ifndef NUTAMILL_CORE_H
#define NUTAMILL_CORE_H
#include <stddef.h>
#include <stdint.h>

enum mode { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16 };

typedef struct {
    int mode;          /* where the importer is in the order of calls */
    int fresh;         /* whether the outputs belong to the present state */
    double start;      /* communication time at the start [s] */
    double now;        /* present communication time [s] */
    double *slots;     /* columns of a row, then series computed of them */
    char *block;       /* model, state and work space */
    size_t size;       /* of the block [bytes] */
    double row_time;   /* time since the last row of a charge [s] */
    void *memory;      /* what was allocated for the block */
    const char *name;  /* of the instance */
    void *environment; /* of the importer */
    void *logger;
    char said[256];    /* the last message */
} instance;

const char *core_refusal(const char *token);
instance *core_new(const char *name);
void core_free(instance *it);
int core_reset(instance *it);
int core_step(instance *it, double time, double step);
int core_get(instance *it, uint32_t reference, double *value);
int core_set(instance *it, uint32_t reference, double value);
size_t core_state_size(const instance *it);
size_t core_saved_size(const void *state);
int core_get_state(const instance *it, void **state);
int core_set_bytes(void **state, const void *bytes, size_t size);
void core_free_state(void **state);
int core_load(instance *it, const char *from, size_t size);

/* of a mechanism alone (mechanism.c) or of a machine with its charge (whole.c) */
int model_advance(instance *it, double step, int64_t count);
int model_row(instance *it);
int model_holds(const char *block, size_t size);

/* for those two */
int core_room(instance *it, size_t size);
double *core_number(const instance *it, int64_t place);
#endif
