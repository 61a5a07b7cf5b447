/* What contexts refuse, and the initialisers of structs. */
#ifndef CONTEXT_ROWS_H
#define CONTEXT_ROWS_H

#include "row.h"

/* Every struct that begins with its size. */
#define STRUCT_SIZE_ROWS(function, name, member, size)                                                              \
    {function, name ".struct_size", "zero", NULL, PUT(to.member.struct_size, size_t, 0), INVALID,                   \
     name ".struct_size is 0;", size ", as set by the struct's init function"},                                     \
    {function, name ".struct_size", "small", NULL, PUT(to.member.struct_size, size_t, 4), INVALID,                  \
     name ".struct_size is 4;", size ", as set"},                                                                   \
    {function, name ".struct_size", "big", NULL, PUT(to.member.struct_size, size_t, sizeof given.to.member + 8),    \
     INVALID, name ".struct_size is ", size ", as set"},                                                            \
    {function, name ".struct_size", "SIZE_MAX", NULL, PUT(to.member.struct_size, size_t, SIZE_MAX), INVALID,        \
     name ".struct_size is 18446744073709551615;", size ", as set"}
#define POINTER_ROWS(function, name, pointee, alignment)                                                            \
    {function, #name, "NULL", NULL, POINT(name, NULL), INVALID, #name " is NULL;", "a pointer"},                    \
    {function, #name, "misaligned", NULL, ASKEW(name, pointee), INVALID, #name " is 0x", "aligned to " alignment}

static DrrStatus call_options_init(const Given *g) { return drr_context_options_init((DrrContextOptions *)g->options); }
static DrrStatus call_descriptor_init(const Given *g) {
    return drr_volume_descriptor_init((DrrVolumeDescriptor *)g->descriptor);
}
static DrrStatus call_scene_init(const Given *g) { return drr_scene_init((DrrScene *)g->scene); }
static DrrStatus call_outputs_init(const Given *g) { return drr_outputs_init((DrrOutputs *)g->outputs); }
static DrrStatus call_reference_outputs_init(const Given *g) {
    return drr_reference_outputs_init((DrrReferenceOutputs *)g->outputs);
}
static DrrStatus call_device_outputs_init(const Given *g) {
    return drr_device_outputs_init((DrrDeviceOutputs *)g->outputs);
}
static DrrStatus call_certificate_init(const Given *g) {
    return drr_certificate_init((DrrCertificate *)g->certificate);
}
static DrrStatus call_context_create(const Given *g) {
    return drr_context_create((const DrrContextOptions *)g->options, (DrrContext **)g->context);
}
static void context_place(Given *g) { g->context = &g->to.handle; }
static void destroy_made_context(const Given *g) { drr_context_destroy((DrrContext *)g->to.handle); }
static DrrStatus call_context_backend(const Given *g) {
    return drr_context_backend((const DrrContext *)g->context, (DrrBackend *)g->backend);
}
static DrrStatus call_context_device_name(const Given *g) {
    return drr_context_device_name((const DrrContext *)g->context) == NULL ? INVALID : DRR_STATUS_OK;
}
static DrrStatus call_context_destroy(const Given *g) { return drr_context_destroy((DrrContext *)g->context); }
/* Destroying nothing is the good call: what a refused call leaves alone is not leaked. */
static void no_context(Given *g) { g->context = NULL; }

static const Function options_init = {"drr_context_options_init", NULL, call_options_init, NULL},
                      descriptor_init = {"drr_volume_descriptor_init", NULL, call_descriptor_init, NULL},
                      scene_init = {"drr_scene_init", NULL, call_scene_init, NULL},
                      outputs_init = {"drr_outputs_init", NULL, call_outputs_init, NULL},
                      reference_outputs_init = {"drr_reference_outputs_init", NULL, call_reference_outputs_init, NULL},
                      device_outputs_init = {"drr_device_outputs_init", NULL, call_device_outputs_init, NULL},
                      certificate_init = {"drr_certificate_init", NULL, call_certificate_init, NULL},
                      context_backend = {"drr_context_backend", NULL, call_context_backend, NULL},
                      context_device_name = {"drr_context_device_name", NULL, call_context_device_name, NULL},
                      context_create = {"drr_context_create", context_place, call_context_create, destroy_made_context},
                      context_destroy = {"drr_context_destroy", no_context, call_context_destroy, NULL};

static void context_askew(Given *g) { g->context = (char *)live.context + 1; }
static void context_foreign(Given *g) { g->context = live.volume; }
static void context_destroyed(Given *g) {
    DrrContext *context = NULL;
    drr_context_create((const DrrContextOptions *)g->options, &context);
    drr_context_destroy(context);
    g->context = context;
}

#define CONTEXT_ROWS(f)                                                                                             \
    {f, "context", "misaligned", context_askew, NOTHING, INVALID, "context is 0x", "a DrrContext"},                 \
    {f, "context", "foreign", context_foreign, NOTHING, INVALID, "context is no such handle;",                      \
     "a DrrContext that has not been destroyed"},                                                                   \
    {f, "context", "destroyed", context_destroyed, NOTHING, INVALID, "context is ",                                 \
     "a DrrContext that has not been destroyed"}
#define BACKEND_ROW(code)                                                                                           \
    {&context_create, "options.backend", "unknown", NULL, PUT(to.options.backend, DrrBackend, code), INVALID,       \
     "options.backend is " #code ";", "DRR_BACKEND constants, 0 … 4"}
#define DEVICE_ROW(index, value)                                                                                    \
    {&context_create, "options.device_index", "huge", NULL, PUT(to.options.device_index, size_t, index), INVALID,   \
     "options.device_index is " value ";", "0, because the engine cpu runs on the CPU"}

#define TIMINGS_ROW(kind, text, value)                                                                              \
    {&context_create, "options.timings", kind, NULL, PUT(to.options.timings, const char *, text), INVALID, value,   \
     "valid: "}

static const Row context_rows[] = {
    POINTER_ROWS(&options_init, options, options, "8 bytes"),
    POINTER_ROWS(&descriptor_init, descriptor, descriptor, "8 bytes"),
    POINTER_ROWS(&scene_init, scene, scene, "8 bytes"),
    POINTER_ROWS(&outputs_init, outputs, outputs, "8 bytes"),
    POINTER_ROWS(&certificate_init, certificate, certificate, "8 bytes"),
    POINTER_ROWS(&device_outputs_init, outputs, device_outputs, "8 bytes"),
    POINTER_ROWS(&reference_outputs_init, outputs, reference_outputs, "8 bytes"),
    {&context_create, "options", "misaligned", NULL, ASKEW(options, options), INVALID, "options is 0x", "aligned to 8"},
    STRUCT_SIZE_ROWS(&context_create, "options", options, "40"),
    BACKEND_ROW(5),
    BACKEND_ROW(4294967295),
    DEVICE_ROW(1, "1"),
    DEVICE_ROW(SIZE_MAX, "18446744073709551615"),
    {&context_create, "options.metal_device", "not NULL", NULL, POINT(to.options.metal_device, &given), INVALID,
     "options.metal_device is not NULL;", "NULL, because the engine is cpu"},
    {&context_create, "options.thread_count", "huge", NULL, PUT(to.options.thread_count, uint32_t, 1025), INVALID,
     "options.thread_count is 1025;", "0 (one per core) … 1024"},
    {&context_create, "options.thread_count", "huge", NULL, PUT(to.options.thread_count, uint32_t, UINT32_MAX), INVALID,
     "options.thread_count is 4294967295;", "0 (one per core) … 1024"},
    TIMINGS_ROW("unknown", "no numbers at all", "options.timings is expected"),
    TIMINGS_ROW("unknown", "{\"name\":\"here\",\"engines\":{\"cpu\":{\"sample_ns\":{},\"ray_ns\":-1,\"energy_ns\":1}}}",
                "options.timings.cpu.ray_ns is -1;"),
    TIMINGS_ROW("not UTF-8", "\xff", "options.timings is "),
    POINTER_ROWS(&context_create, context, handle, "8 bytes"),
    CONTEXT_ROWS(&context_destroy),
    CONTEXT_ROWS(&context_backend),
    CONTEXT_ROWS(&context_device_name),
    {&context_backend, "context", "NULL", NULL, POINT(context, NULL), INVALID, "context is NULL;", "a DrrContext"},
    {&context_device_name, "context", "NULL", NULL, POINT(context, NULL), INVALID, "context is NULL;", "a DrrContext"},
    POINTER_ROWS(&context_backend, backend, backend, "4 bytes"),
};

#endif
