#import "DRREngine.h"

#import "DRRFailure.h"
#import "DRRMemory.h"

@implementation DRREngine

- (const DrrContext *)context {
    return _context;
}

- (instancetype)initWithBackend:(DrrBackend)backend device:(void *)device error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = backend;
    options.metal_device = device;
    if (DRRSucceeds(drr_context_create(&options, &_context), error)) return self;
    DRR_RELEASE(self);
    return nil;
}

- (instancetype)initWithBackend:(DrrBackend)backend error:(NSError **)error {
    return [self initWithBackend:backend device:NULL error:error];
}

- (instancetype)initWithMetalDevice:(id)device error:(NSError **)error {
#if defined(DRR_ARC)
    return [self initWithBackend:DRR_BACKEND_METAL device:(__bridge void *)device error:error];
#else
    return [self initWithBackend:DRR_BACKEND_METAL device:(void *)device error:error];
#endif
}

- (void)dealloc {
    drr_context_destroy(_context);
    DRR_SUPER_DEALLOC;
}

- (NSString *)name {
    static const char *const names[] = {"auto", "cpu", "reference", "cuda", "metal"};
    DrrBackend backend = DRR_BACKEND_AUTO;
    drr_context_backend(_context, &backend);
    const char *const known = backend < sizeof names / sizeof *names ? names[backend] : "unknown";
    NSString *const name = [NSString stringWithUTF8String:known];
    NSString *const device = [NSString stringWithUTF8String:drr_context_device_name(_context)];
    return [device length] == 0 ? name : [NSString stringWithFormat:@"%@ %@", name, device];
}

@end
