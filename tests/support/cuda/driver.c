/* A stand-in for NVIDIA's driver: one GPU whose memory is the host's and which runs what it is given at once. It holds
 * its caller to the driver's rules: every call in a current context, every address inside an allocation, and at the
 * context's end nothing left. What breaks a rule ends the process.
 *
 * DRR_STAND_IN_BYTES limits the memory; DRR_STAND_IN_LAUNCHES the launches that succeed. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { SUCCESS = 0, INVALID_VALUE = 1, OUT_OF_MEMORY = 2, INVALID_CONTEXT = 201, LAUNCH_FAILED = 719 };

typedef uint64_t Address;
typedef struct Allocation {
    struct Allocation *next;
    char *memory;
    size_t size;
} Allocation;
typedef struct {
    void *library;
} Module;
typedef void (*Thread)(const unsigned *place, void **parameters);

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static Allocation *allocations;
static size_t allocated;
/* Live objects: contexts retained, streams, events, modules, pools. */
static int contexts, streams, events, modules, pools, launches;
static _Thread_local int current;

#define RULE(condition)                                                            \
    do {                                                                           \
        if (!(condition)) {                                                        \
            fprintf(stderr, "stand-in driver: %s: not so: %s\n", __func__, #condition); \
            abort();                                                               \
        }                                                                          \
    } while (0)
#define IN_CONTEXT() RULE(current > 0 && contexts > 0)

static void count(int *objects, int change) {
    pthread_mutex_lock(&lock);
    *objects += change;
    RULE(*objects >= 0);
    pthread_mutex_unlock(&lock);
}

static size_t limit(const char *name) {
    const char *text = getenv(name);
    return text == NULL ? SIZE_MAX : strtoull(text, NULL, 10);
}

int cuDriverGetVersion(int *version) {
    *version = 13000;
    return SUCCESS;
}
int cuInit(unsigned flags) {
    RULE(flags == 0);
    return SUCCESS;
}
int cuGetErrorName(int error, const char **name) {
    *name = error == LAUNCH_FAILED ? "CUDA_ERROR_LAUNCH_FAILED" : "CUDA_ERROR_OF_THE_STAND_IN";
    return SUCCESS;
}
int cuGetErrorString(int error, const char **text) {
    *text = error == LAUNCH_FAILED ? "unspecified launch failure" : "some error";
    return SUCCESS;
}

int cuDeviceGetCount(int *devices) {
    *devices = 1;
    return SUCCESS;
}
int cuDeviceGet(int *device, int ordinal) {
    RULE(ordinal == 0);
    *device = 0;
    return SUCCESS;
}
int cuDeviceGetName(char *name, int length, int device) {
    RULE(device == 0);
    snprintf(name, (size_t)length, "stand-in");
    return SUCCESS;
}
int cuDeviceGetAttribute(int *value, int attribute, int device) {
    RULE(device == 0);
    switch (attribute) {
    case 75: *value = 9; return SUCCESS;  /* compute capability, major */
    case 76: *value = 0; return SUCCESS;  /* minor */
    case 115: *value = 1; return SUCCESS; /* memory pools */
    default: return INVALID_VALUE;
    }
}

/* Any pointer but NULL serves for what has no state. */
static char object;

int cuDevicePrimaryCtxRetain(void **context, int device) {
    RULE(device == 0);
    count(&contexts, 1);
    *context = &object;
    return SUCCESS;
}
int cuDevicePrimaryCtxRelease_v2(int device) {
    RULE(device == 0);
    count(&contexts, -1);
    if (contexts == 0) RULE(allocations == NULL && streams == 0 && events == 0 && modules == 0 && pools == 0);
    return SUCCESS;
}
int cuCtxPushCurrent_v2(void *context) {
    RULE(context == &object && contexts > 0);
    current++;
    return SUCCESS;
}
int cuCtxPopCurrent_v2(void **context) {
    if (current == 0) return INVALID_CONTEXT;
    current--;
    *context = &object;
    return SUCCESS;
}

int cuStreamCreate(void **stream, unsigned flags) {
    IN_CONTEXT();
    RULE(flags == 1);
    count(&streams, 1);
    *stream = &object;
    return SUCCESS;
}
int cuStreamSynchronize(void *stream) {
    IN_CONTEXT();
    (void)stream;
    return SUCCESS;
}
int cuStreamIsCapturing(void *stream, int *status) {
    IN_CONTEXT();
    (void)stream;
    *status = 0;
    return SUCCESS;
}
int cuStreamDestroy_v2(void *stream) {
    IN_CONTEXT();
    RULE(stream == &object);
    count(&streams, -1);
    return SUCCESS;
}

int cuEventCreate(void **event, unsigned flags) {
    IN_CONTEXT();
    RULE(flags == 0);
    count(&events, 1);
    *event = calloc(1, sizeof(struct timespec));
    return *event == NULL ? OUT_OF_MEMORY : SUCCESS;
}
int cuEventRecord(void *event, void *stream) {
    IN_CONTEXT();
    (void)stream;
    clock_gettime(CLOCK_MONOTONIC, (struct timespec *)event);
    return SUCCESS;
}
int cuEventElapsedTime(float *milliseconds, void *start, void *end) {
    const struct timespec *a = (struct timespec *)start, *b = (struct timespec *)end;
    RULE(a->tv_sec != 0 && b->tv_sec != 0);
    *milliseconds = (float)(1e3 * (double)(b->tv_sec - a->tv_sec) + 1e-6 * (double)(b->tv_nsec - a->tv_nsec));
    return SUCCESS;
}
int cuEventDestroy_v2(void *event) {
    IN_CONTEXT();
    free(event);
    count(&events, -1);
    return SUCCESS;
}

int cuMemAlloc_v2(Address *address, size_t size) {
    IN_CONTEXT();
    if (size == 0) return INVALID_VALUE;
    pthread_mutex_lock(&lock);
    Allocation *made = NULL;
    if (size <= limit("DRR_STAND_IN_BYTES") - allocated) made = (Allocation *)malloc(sizeof *made);
    if (made != NULL) {
        /* Not zeros: as little as a GPU's memory is. */
        *made = (Allocation){allocations, (char *)malloc(size), size};
        memset(made->memory, 0xa5, size);
        allocations = made;
        allocated += size;
        *address = (Address)(uintptr_t)made->memory;
    }
    pthread_mutex_unlock(&lock);
    return made == NULL ? OUT_OF_MEMORY : SUCCESS;
}
int cuMemFree_v2(Address address) {
    IN_CONTEXT();
    pthread_mutex_lock(&lock);
    Allocation **link = &allocations;
    while (*link != NULL && (Address)(uintptr_t)(*link)->memory != address) link = &(*link)->next;
    Allocation *freed = *link;
    RULE(freed != NULL);
    *link = freed->next;
    allocated -= freed->size;
    pthread_mutex_unlock(&lock);
    free(freed->memory);
    free(freed);
    return SUCCESS;
}
/* Whether bytes lie in one allocation. */
static int owned(Address address, size_t size) {
    pthread_mutex_lock(&lock);
    int found = 0;
    for (const Allocation *a = allocations; a != NULL && !found; a = a->next) {
        const Address first = (Address)(uintptr_t)a->memory;
        found = address >= first && address + size <= first + a->size;
    }
    pthread_mutex_unlock(&lock);
    return found;
}

int cuMemPoolCreate(void **pool, const void *properties) {
    const int32_t *p = (const int32_t *)properties; /* pinned memory, no handles, on a device, the first */
    RULE(p[0] == 1 && p[1] == 0 && p[2] == 1 && p[3] == 0);
    count(&pools, 1);
    *pool = &object;
    return SUCCESS;
}
int cuMemPoolSetAttribute(void *pool, int attribute, void *value) {
    RULE(pool == &object && attribute == 4 && *(uint64_t *)value > 0);
    return SUCCESS;
}
int cuMemPoolDestroy(void *pool) {
    RULE(pool == &object);
    count(&pools, -1);
    return SUCCESS;
}
int cuMemAllocFromPoolAsync(Address *address, size_t size, void *pool, void *stream) {
    RULE(pool == &object && pools > 0);
    (void)stream;
    return cuMemAlloc_v2(address, size);
}
int cuMemFreeAsync(Address address, void *stream) {
    (void)stream;
    return cuMemFree_v2(address);
}

int cuMemcpyHtoDAsync_v2(Address to, const void *from, size_t size, void *stream) {
    IN_CONTEXT();
    (void)stream;
    RULE(owned(to, size));
    memcpy((void *)(uintptr_t)to, from, size);
    return SUCCESS;
}
int cuMemcpyDtoH_v2(void *to, Address from, size_t size) {
    IN_CONTEXT();
    if (!owned(from, size)) return INVALID_VALUE;
    memcpy(to, (const void *)(uintptr_t)from, size);
    return SUCCESS;
}
int cuMemcpyDtoHAsync_v2(void *to, Address from, size_t size, void *stream) {
    (void)stream;
    RULE(owned(from, size));
    return cuMemcpyDtoH_v2(to, from, size);
}
int cuMemcpyDtoDAsync_v2(Address to, Address from, size_t size, void *stream) {
    IN_CONTEXT();
    (void)stream;
    RULE(owned(to, size) && owned(from, size));
    memcpy((void *)(uintptr_t)to, (const void *)(uintptr_t)from, size);
    return SUCCESS;
}
int cuMemsetD8Async(Address to, unsigned char byte, size_t size, void *stream) {
    IN_CONTEXT();
    (void)stream;
    RULE(owned(to, size));
    memset((void *)(uintptr_t)to, byte, size);
    return SUCCESS;
}
int cuLaunchHostFunc(void *stream, void (*function)(void *), void *data) {
    IN_CONTEXT();
    (void)stream;
    function(data);
    return SUCCESS;
}

/* The image is a path, made by compiler.c. */
int cuModuleLoadData(void **place, const void *image) {
    IN_CONTEXT();
    Module *module = (Module *)malloc(sizeof *module);
    if (module == NULL) return OUT_OF_MEMORY;
    module->library = dlopen((const char *)image, RTLD_NOW | RTLD_LOCAL);
    RULE(module->library != NULL);
    unlink((const char *)image);
    count(&modules, 1);
    *place = module;
    return SUCCESS;
}
int cuModuleGetFunction(void **function, void *module, const char *name) {
    char by_addresses[64];
    snprintf(by_addresses, sizeof by_addresses, "stand_in_%s", name);
    RULE(dlsym(((Module *)module)->library, name) != NULL);
    *function = dlsym(((Module *)module)->library, by_addresses);
    RULE(*function != NULL);
    return SUCCESS;
}
int cuModuleUnload(void *module) {
    IN_CONTEXT();
    dlclose(((Module *)module)->library);
    free(module);
    count(&modules, -1);
    return SUCCESS;
}
int cuFuncGetAttribute(int *value, int attribute, void *function) {
    RULE(function != NULL);
    *value = attribute == 4 ? 40 : attribute == 3 ? 0 : -1; /* registers, local memory */
    RULE(*value >= 0);
    return SUCCESS;
}
int cuLaunchKernel(void *function, unsigned gx, unsigned gy, unsigned gz, unsigned bx, unsigned by, unsigned bz,
                   unsigned shared, void *stream, void **parameters, void **extra) {
    IN_CONTEXT();
    RULE(gx > 0 && gy > 0 && gy <= 65535 && gz == 1 && bx * by <= 1024 && bz == 1 && shared == 0 && extra == NULL);
    (void)stream;
    count(&launches, 1);
    if ((size_t)launches > limit("DRR_STAND_IN_LAUNCHES")) return LAUNCH_FAILED;
    const Thread thread = *(Thread *)&function;
    unsigned p[6] = {bx, by};
    for (p[3] = 0; p[3] < gy; p[3]++)
        for (p[2] = 0; p[2] < gx; p[2]++)
            for (p[5] = 0; p[5] < by; p[5]++)
                for (p[4] = 0; p[4] < bx; p[4]++) thread(p, parameters);
    return SUCCESS;
}
