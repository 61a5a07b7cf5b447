#import "DRROverlap.h"

#include <math.h>

#import "DRRFailure.h"
#import "DRRKernel.h"
#import "DRRMetalPair.h"

@implementation DRROverlap {
    DRRMetalPair *_pair;
    DRRKernel *_denoise;
}

- (nullable instancetype)initWithPair:(DRRMetalPair *)pair error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _pair = pair;
    _denoise = [[DRRKernel alloc] initWithFunction:@"drr_denoise" file:@"Denoise" device:pair.device error:error];
    return _denoise == nil ? nil : self;
}

- (BOOL)filter:(id<MTLBuffer>)before
          into:(id<MTLBuffer>)filtered
      commands:(id<MTLCommandBuffer>)commands
         error:(NSError **)error {
    const uint32_t size = (uint32_t)_pair.size;
    return [_denoise encodeInto:commands
                           grid:MTLSizeMake(size, size, DRRViews)
                      arguments:^(id<MTLComputeCommandEncoder> encoder) {
                          [encoder setBuffer:before offset:0 atIndex:0];
                          [encoder setBuffer:filtered offset:0 atIndex:1];
                          [encoder setBytes:&size length:sizeof size atIndex:2];
                      }
                          error:error];
}

- (BOOL)project:(DRRShot *)shot
         filter:(id<MTLBuffer>)before
           into:(id<MTLBuffer>)filtered
          queue:(id<MTLCommandQueue>)queue
          error:(NSError **)error {
    const id<MTLCommandBuffer> projection = [queue commandBuffer], filter = [queue commandBuffer];
    if (projection == nil || filter == nil) return DRRFail((NSInteger)DRR_STATUS_DEVICE, @"Metal has no command buffer", error);
    /* The order on the queue, before anything is encoded. */
    [projection enqueue];
    [filter enqueue];

    __block NSError *first = nil, *second = nil;
    const dispatch_group_t threads = dispatch_group_create();
    const dispatch_queue_t workers = dispatch_get_global_queue(QOS_CLASS_USER_INITIATED, 0);
    /* What is enqueued must be committed, encoded or not: the queue waits for it. */
    dispatch_group_async(threads, workers, ^{
        NSError *reason = nil;
        if (![self->_pair encode:shot into:projection error:&reason]) first = reason;
        [projection commit];
    });
    dispatch_group_async(threads, workers, ^{
        NSError *reason = nil;
        if (![self filter:before into:filtered commands:filter error:&reason]) second = reason;
        [filter commit];
    });
    dispatch_group_wait(threads, DISPATCH_TIME_FOREVER);
    [projection waitUntilCompleted];
    [filter waitUntilCompleted];

    NSError *failed = first ?: second ?: projection.error ?: filter.error;
    if (failed != nil) {
        if (error != NULL) *error = failed;
        return NO;
    }
    _projectionSeconds = projection.GPUEndTime - projection.GPUStartTime;
    _filterSeconds = filter.GPUEndTime - filter.GPUStartTime;
    _bothSeconds = fmax(projection.GPUEndTime, filter.GPUEndTime) - fmin(projection.GPUStartTime, filter.GPUStartTime);
    return YES;
}

@end
