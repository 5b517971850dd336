/* A mechanism without its charge: one kernel that marches, one that reads a row. */
#include "core.h"
#include "model.h"
#include <stdio.h>

/* compiled kernels: result, exception, arguments */
extern int nutamill_advance(int64_t *status, void **exception, void *block, double step, int64_t count);
extern int nutamill_read(int64_t *status, void **exception, void *block);

int model_advance(instance *it, double step, int64_t count) {
    int64_t status = 0;
    void *exception = NULL;
    if (count > 0 && (nutamill_advance(&status, &exception, it->block, step, count) || status)) {
        snprintf(it->said, sizeof it->said, "t = %.9g s: the motion is not finite", it->now);
        return 0;
    }
    return 1;
}

int model_row(instance *it) {
    int64_t status = 0;
    void *exception = NULL;
    return !nutamill_read(&status, &exception, it->block);
}

int model_holds(const char *block, size_t size) {
    (void)block;
    return size == BLOCK_SIZE;
}
