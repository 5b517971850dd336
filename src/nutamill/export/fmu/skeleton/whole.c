/* A machine with its charge: the coupled march on one thread, which writes a row after a number of windows, and
   lists that grow when they are full. */
#include "core.h"
#include "model.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ALIGNMENT 64
#define WORD 8
#define SAME_TIME 1e-9 /* share by which the time between two rows may miss that of whole windows */

enum outcome { RUNNING, CHARGE_FAILED, LISTS_FULL, NOT_CONVERGED, NOT_FINITE };
static const char *const meaning[] = {
    "", "a particle left the machine, moved too far in a step, or overlaps beyond overlap_stop", "",
    "the passes over a window did not converge", "the motion of the mechanism is not finite"};

/* compiled kernel: rows written, exception, arguments */
extern int nutamill_advance(int64_t *rows, void **exception, void *block, int64_t windows);

/* What Numba's compiled code asks for: exponents of numbers, also of zero and of what is not finite. */
#define EXPONENTS(type, suffix)                                \
    type numba_frexp##suffix(type x, int *exponent) {          \
        *exponent = 0;                                         \
        return isfinite(x) && x ? frexp##suffix(x, exponent) : x; \
    }                                                          \
    type numba_ldexp##suffix(type x, int exponent) {           \
        return isfinite(x) && x && exponent ? ldexp##suffix(x, exponent) : x; \
    }
EXPONENTS(double, )
EXPONENTS(float, f)

static int64_t *whole(const char *block, int64_t place) { return (int64_t *)(block + place); }

static size_t aligned(size_t size) { return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT; }

/* Room of the lists of a chunk after the present one, as the engine takes it. */
static int64_t larger(int64_t room) {
    return (2 * room / CHUNK * CHUNK + 2 * PADDING + 15) / 16 * 16;
}

static int64_t lanes(int64_t room) { return (room > SURFACE_LANES ? room : SURFACE_LANES) + 2 * BATCH; }

/* Return the size of an array with a room [bytes]; `outer` and `inner` are numbers of pieces and bytes. */
static size_t array_size(const char *block, const struct growing *g, int64_t room, int64_t *outer, int64_t *inner) {
    const int64_t *shape = whole(block, g->entry + WORD);
    *outer = 1, *inner = g->item;
    for (int k = 0; k < g->grows; k++) *outer *= shape[k];
    for (int k = g->grows + 1; k < g->dimensions; k++) *inner *= shape[k];
    return (size_t)(*outer * (g->lanes ? lanes(room) : room) * *inner);
}

/* Return the size of a block with a room for its lists [bytes]. */
static size_t block_size(const char *block, int64_t room) {
    size_t end = (size_t)*whole(block, growing[0].entry);
    for (int k = 0; k < N_GROWING; k++) {
        int64_t outer, inner;
        end = aligned(end + array_size(block, growing + k, room, &outer, &inner));
    }
    return end;
}

/* Lay the block anew with more room for the lists, and let the march go on. */
static int grow(instance *it) {
    char *old = it->block, *old_memory = it->memory;
    int64_t room = *whole(old, CAPACITY_AT), next = larger(room);
    it->memory = NULL;
    if (!core_room(it, block_size(old, next))) {
        it->memory = old_memory;
        return 0;
    }
    char *block = it->block;
    size_t end = (size_t)*whole(old, growing[0].entry);
    memcpy(block, old, end);
    memset(block + end, 0, it->size - end);
    for (int k = 0; k < N_GROWING; k++) {
        const struct growing *g = growing + k;
        int64_t outer, inner, from = *whole(old, g->entry);
        int64_t before = g->lanes ? lanes(room) : room, after = g->lanes ? lanes(next) : next;
        size_t size = array_size(old, g, next, &outer, &inner);
        for (int64_t j = 0; j < outer; j++)
            memcpy(block + end + j * after * inner, old + from + j * before * inner, (size_t)(before * inner));
        *whole(block, g->entry) = (int64_t)end;
        whole(block, g->entry + WORD)[g->grows] = after;
        end = aligned(end + size);
    }
    for (int k = 0; k < N_SAVED; k++) { /* places of saved contacts count through all chunks */
        int64_t *start = whole(block, saved[k].starts_at), last = whole(block, saved[k].partners + WORD)[0] - 1;
        for (int64_t j = 0; j < saved[k].count; j++) {
            int64_t chunk = start[j] / room, place = start[j] % room;
            start[j] = (chunk < last ? chunk : last) * next + place;
        }
    }
    *whole(block, CROWDED_AT) = 0;
    if (*whole(block, OUTCOME_AT) == LISTS_FULL) memset(block + STATUS_AT, 0, 4 * WORD);
    free(old_memory);
    return 1;
}

/* A row has means over whole windows: correct those of a row in which one was shorter. */
static void correct_means(instance *it, double window) {
    double share = window * PER_ROW / it->row_time, *row = core_number(it, ROW_AT);
    if (fabs(share - 1.0) > SAME_TIME)
        for (int k = 0; k < N_WRENCH; k++) row[FIRST_WRENCH + k] *= share;
    it->row_time = 0.0;
}

int model_advance(instance *it, double step, int64_t count) {
    *core_number(it, WINDOW_AT) = step;
    while (count > 0) {
        void *exception = NULL;
        int64_t rows = 0, before = *whole(it->block, WINDOWS_AT), to_row = PER_ROW - before % PER_ROW;
        int failed = nutamill_advance(&rows, &exception, it->block, count < to_row ? count : to_row);
        int64_t done = *whole(it->block, WINDOWS_AT) - before, outcome = *whole(it->block, OUTCOME_AT);
        count -= done;
        it->row_time += (double)done * step;
        if (rows > 0) correct_means(it, step);
        if ((outcome == LISTS_FULL || *whole(it->block, CROWDED_AT)) && !grow(it)) {
            snprintf(it->said, sizeof it->said, "t = %.9g s: no memory for larger lists", it->now);
            return 0;
        }
        if (failed || (outcome != RUNNING && outcome != LISTS_FULL)) {
            int known = !failed && outcome > 0 && outcome <= NOT_FINITE;
            snprintf(it->said, sizeof it->said, "t = %.9g s: %s", *core_number(it, TIME_AT),
                     known ? meaning[outcome] : "the march failed");
            return 0;
        }
    }
    *core_number(it, WINDOW_AT) = INNER_STEP;
    return 1;
}

int model_row(instance *it) {
    (void)it; /* the march has written it */
    return 1;
}

int model_holds(const char *block, size_t size) {
    int64_t room;
    if (memcmp(block, nutamill_block, (size_t)growing[0].entry)) return 0;
    room = *whole(block, CAPACITY_AT);
    return room > 0 && room < INT32_MAX && block_size(block, room) == size;
}
