/* The machine behind both versions of FMI.  What moves it is compiled from the kernels of nutamill; tables and
   first block are those of its export. */
#include "core.h"
#include "model.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

#define ALIGNMENT 64
#define SAME_STEP 1e-6 /* share of the inner step by which a communication step may miss a multiple */

#if !defined(__linux__)
void sincos(double x, double *s, double *c) {
    *s = sin(x);
    *c = cos(x);
}
#endif

/* What Numba's compiled code asks for: strides [bytes] of a contiguous array in another shape. */
int numba_attempt_nocopy_reshape(int64_t n, const int64_t *shape, const int64_t *strides, int64_t new_n,
                                 const int64_t *new_shape, int64_t *new_strides, int64_t item, int fortran) {
    (void)n, (void)shape, (void)strides, (void)fortran;
    for (int64_t k = new_n - 1; k >= 0; k--) {
        new_strides[k] = item;
        item *= new_shape[k];
    }
    return 1;
}

#define HEAD (2 * sizeof(int64_t) + 4 * sizeof(double))

size_t core_state_size(const instance *it) { return HEAD + it->size; }

size_t core_saved_size(const void *state) {
    int64_t size;
    memcpy(&size, state, sizeof size);
    return (size_t)size;
}

double *core_number(const instance *it, int64_t place) { return (double *)(it->block + place); }
#define number core_number

/* Give the block a size, with undefined content.  Without memory the old block stays. */
int core_room(instance *it, size_t size) {
    char *memory = malloc(size + ALIGNMENT);
    if (!memory) return 0;
    free(it->memory);
    it->memory = memory;
    it->block = (char *)(((uintptr_t)memory + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    it->size = size;
    return 1;
}

/* Return whether this processor has the instructions of the kernels. */
static int processor_fits(void) {
#if defined(__x86_64__)
    unsigned a, b, c, d, low = 0, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & NEEDS_ECX_1) != NEEDS_ECX_1) return 0;
    if (NEEDS_SAVED) __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    if ((low & NEEDS_SAVED) != NEEDS_SAVED) return 0;
    return !NEEDS_EBX_7 || (__get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & NEEDS_EBX_7) == NEEDS_EBX_7);
#else
    return 1;
#endif
}

/* Return why there can be no instance here, NULL if there can be one. */
const char *core_refusal(const char *token) {
    if (!token || strcmp(token, TOKEN)) return "the library does not belong to this modelDescription.xml";
    if (!processor_fits())
        return "this processor lacks instructions of the one that the library was made for: "
               "export the machine on this computer, or with --platforms all";
    return NULL;
}

instance *core_new(const char *name) {
    char *memory = calloc(1, sizeof(instance) + 8 + sizeof(double) * N_SLOTS + strlen(name) + 1);
    if (!memory) return NULL;
    instance *it = (instance *)memory;
    it->slots = (double *)(memory + (sizeof(instance) + 7) / 8 * 8);
    char *text = (char *)(it->slots + N_SLOTS);
    strcpy(text, name);
    it->name = text;
    if (!core_reset(it)) {
        free(it);
        return NULL;
    }
    return it;
}

void core_free(instance *it) {
    free(it->memory);
    free(it);
}

int core_reset(instance *it) {
    if (it->size != BLOCK_SIZE && !core_room(it, BLOCK_SIZE)) return 0;
    memcpy(it->block, nutamill_block, BLOCK_SIZE);
    it->mode = INSTANTIATED;
    it->fresh = 0;
    it->start = it->now = it->row_time = 0.0;
    return 1;
}

/* Put the inputs of the importer where the kernels read them; `step` is the communication step. */
static void take_inputs(instance *it, double step) {
    for (int k = 0; k < N_INPUTS; k++) {
        const struct input *in = inputs + k;
        double value = *number(it, INPUTS_AT + 8 * (int64_t)k);
        if (in->kind == PLAIN) {
            *number(it, in->at) = value;
        } else { /* a prescribed speed: linear from the present one to the input at the end of the step, on a
                    line that goes on, so that the acceleration at the end is that of the step */
            double *knot = number(it, in->at), time = *number(it, TIME_AT);
            double angle = number(it, in->motion)[0], speed = number(it, in->motion)[1];
            knot[0] = time, knot[1] = speed, knot[2] = angle;
            knot[3] = time + 2.0 * step, knot[4] = 2.0 * value - speed, knot[5] = angle + 2.0 * step * value;
        }
    }
}

int core_step(instance *it, double time, double step) {
    if (!(step > 0.0) || !isfinite(step)) {
        snprintf(it->said, sizeof it->said, "a step has a positive length, got %g s", step);
        return 0;
    }
    if (!(fabs(time - it->now) <= 1e-9 * fmax(1.0, fabs(time)) + 1e-3 * INNER_STEP)) {
        snprintf(it->said, sizeof it->said, "the step begins at %.9g s, the model is at %.9g s", time, it->now);
        return 0;
    }
    double ratio = step / INNER_STEP, nearest = floor(ratio + 0.5);
    int whole = fabs(ratio - nearest) <= SAME_STEP && nearest >= 1.0;
    int64_t count = (int64_t)(whole ? nearest : floor(ratio));
    take_inputs(it, step);
    it->fresh = 0;
    if (!model_advance(it, INNER_STEP, count)) return 0;
    if (!whole && !model_advance(it, step - (double)count * INNER_STEP, 1)) return 0;
    it->now = time + step;
    return 1;
}

/* Compute what is recorded: a row, then series of its columns. */
static int refresh(instance *it) {
    if (it->fresh) return 1;
    if (!model_row(it)) return 0;
    memcpy(it->slots, it->block + ROW_AT, sizeof(double) * N_COLUMNS);
    for (int k = 0; k < N_SERIES; k++) {
        const struct series *s = series + k;
        double t[MOST_TERMS], value = 0.0;
        for (int j = 0; j < s->count; j++) {
            const struct term *a = terms + s->first + j;
            t[j] = a->sign * it->slots[a->slot] - a->zero;
        }
        if (s->take == SUM) {
            value = t[0];
            for (int j = 1; j < s->count; j++) value += t[j];
        } else if (s->take == PRODUCT) {
            value = t[0];
            for (int j = 1; j < s->count; j++) value *= t[j];
        } else if (s->take == RESULTANT && s->count == 2) {
            value = hypot(t[0], t[1]);
        } else if (s->take == RESULTANT) {
            for (int j = 0; j < s->count; j++) value += t[j] * t[j];
            value = sqrt(value);
        } else { /* the lag of a direction behind an angle, into (-pi, pi] */
            double rest = fmod(PI - (t[0] - atan2(t[2] - t[4], t[1] - t[3])), 2 * PI);
            value = PI - (rest < 0.0 ? rest + 2 * PI : rest);
        }
        it->slots[N_COLUMNS + k] = value;
    }
    it->fresh = 1;
    return 1;
}

int core_get(instance *it, uint32_t reference, double *value) {
    if (reference >= N_VARIABLES) return 0;
    const struct variable *v = variables + reference;
    if (v->kind == IN_BLOCK) {
        *value = *number(it, v->at);
        return 1;
    }
    if (v->kind == CLOCK) {
        *value = it->now;
        return 1;
    }
    if (!refresh(it)) return 0;
    *value = it->slots[v->at];
    return 1;
}

int core_set(instance *it, uint32_t reference, double value) {
    if (reference >= N_VARIABLES || !variables[reference].settable) {
        snprintf(it->said, sizeof it->said, "value reference %u is no input", (unsigned)reference);
        return 0;
    }
    if (!isfinite(value)) {
        snprintf(it->said, sizeof it->said, "an input is not a finite number");
        return 0;
    }
    *number(it, variables[reference].at) = value;
    it->fresh = 0;
    return 1;
}

static void save(const instance *it, char *to) {
    int64_t head[2] = {(int64_t)core_state_size(it), it->mode};
    double times[4] = {it->start, it->now, it->row_time, INNER_STEP};
    memcpy(to, head, sizeof head);
    memcpy(to + sizeof head, times, sizeof times);
    memcpy(to + HEAD, it->block, it->size);
}

int core_load(instance *it, const char *from, size_t size) {
    int64_t head[2];
    double times[4];
    if (size < HEAD + BLOCK_SIZE) return 0;
    memcpy(head, from, sizeof head);
    memcpy(times, from + sizeof head, sizeof times);
    if (head[0] != (int64_t)size || times[3] != INNER_STEP) return 0;
    if (!model_holds(from + HEAD, size - HEAD)) return 0;
    if (it->size != size - HEAD && !core_room(it, size - HEAD)) return 0;
    it->mode = (int)head[1];
    it->start = times[0];
    it->now = times[1];
    it->row_time = times[2];
    it->fresh = 0;
    memcpy(it->block, from + HEAD, it->size);
    return 1;
}

/* Give a state of the importer its size.  One of another size is freed first. */
static int room_for_state(void **state, size_t size) {
    if (*state && core_saved_size(*state) != size) core_free_state(state);
    if (!*state) *state = malloc(size);
    return *state != NULL;
}

int core_get_state(const instance *it, void **state) {
    if (!state || !room_for_state(state, core_state_size(it))) return 0;
    save(it, *state);
    return 1;
}

/* Make a state of the bytes of an earlier one. */
int core_set_bytes(void **state, const void *bytes, size_t size) {
    if (!bytes || !state || size < sizeof(int64_t) || size != core_saved_size(bytes)) return 0;
    if (!room_for_state(state, size)) return 0;
    memcpy(*state, bytes, size);
    return 1;
}

void core_free_state(void **state) {
    if (!state) return;
    free(*state);
    *state = NULL;
}
