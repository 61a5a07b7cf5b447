#import "DRRKernel.h"

#import "DRRFailure.h"

@implementation DRRKernel

+ (NSBundle *)bundle {
#if defined(SWIFT_PACKAGE)
    return SWIFTPM_MODULE_BUNDLE;
#else
    return NSBundle.mainBundle; /* an app's Resources, or a command's own folder */
#endif
}

- (nullable instancetype)initWithFunction:(NSString *)function
                                     file:(NSString *)file
                                   device:(id<MTLDevice>)device
                                    error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    NSURL *const url = [DRRKernel.bundle URLForResource:file withExtension:@"metal"];
    if (url == nil) {
        NSString *const message = [NSString stringWithFormat:@"%@.metal is not in %@", file, DRRKernel.bundle.bundlePath];
        DRRFail(DRRErrorFile, message, error);
        return nil;
    }
    NSString *const text = [NSString stringWithContentsOfURL:url encoding:NSUTF8StringEncoding error:error];
    if (text == nil) return nil;
    const id<MTLLibrary> library = [device newLibraryWithSource:text options:nil error:error];
    if (library == nil) return nil;
    const id<MTLFunction> found = [library newFunctionWithName:function];
    if (found == nil) {
        DRRFail(DRRErrorFile, [NSString stringWithFormat:@"%@.metal has no kernel %@", file, function], error);
        return nil;
    }
    _state = [device newComputePipelineStateWithFunction:found error:error];
    return _state == nil ? nil : self;
}

- (BOOL)encodeInto:(id<MTLCommandBuffer>)commands
              grid:(MTLSize)grid
         arguments:(void (NS_NOESCAPE ^)(id<MTLComputeCommandEncoder> encoder))arguments
             error:(NSError **)error {
    const id<MTLComputeCommandEncoder> encoder = [commands computeCommandEncoder];
    if (encoder == nil) return DRRFail((NSInteger)DRR_STATUS_DEVICE, @"Metal has no encoder", error);
    [encoder setComputePipelineState:_state];
    arguments(encoder);
    const NSUInteger width = _state.threadExecutionWidth;
    const MTLSize group = MTLSizeMake(width, _state.maxTotalThreadsPerThreadgroup / width, 1);
    [encoder dispatchThreads:grid threadsPerThreadgroup:group];
    [encoder endEncoding];
    return YES;
}

@end
