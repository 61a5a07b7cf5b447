#import "DRRStopwatch.h"

#include <math.h>

#import "DRRFailure.h"

@implementation DRRStopwatch {
    id<MTLDevice> _device;
    id<MTLCounterSampleBuffer> _samples;
    id<MTLBuffer> _scratch;
    MTLTimestamp _host, _gpu; // at one moment, when the watch was started
}

- (nullable instancetype)initWithDevice:(id<MTLDevice>)device error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _device = device;
    id<MTLCounterSet> times = nil;
    if ([device supportsCounterSampling:MTLCounterSamplingPointAtStageBoundary])
        for (id<MTLCounterSet> set in device.counterSets)
            if ([set.name isEqualToString:MTLCommonCounterSetTimestamp]) times = set;
    if (times == nil) {
        DRRFail((NSInteger)DRR_STATUS_UNSUPPORTED, @"this GPU has no time stamps at the boundaries of passes", error);
        return nil;
    }
    MTLCounterSampleBufferDescriptor *const descriptor = [MTLCounterSampleBufferDescriptor new];
    descriptor.counterSet = times;
    descriptor.storageMode = MTLStorageModeShared;
    descriptor.sampleCount = 2;
    _samples = [device newCounterSampleBufferWithDescriptor:descriptor error:error];
    _scratch = [device newBufferWithLength:4 options:MTLResourceStorageModePrivate];
    return _samples == nil ? nil : self;
}

// A pass that leaves its start or its end in a sample.
- (id<MTLBlitCommandEncoder>)passIn:(id<MTLCommandBuffer>)commands start:(NSUInteger)start end:(NSUInteger)end {
    MTLBlitPassDescriptor *const pass = [MTLBlitPassDescriptor blitPassDescriptor];
    pass.sampleBufferAttachments[0].sampleBuffer = _samples;
    pass.sampleBufferAttachments[0].startOfEncoderSampleIndex = start;
    pass.sampleBufferAttachments[0].endOfEncoderSampleIndex = end;
    return [commands blitCommandEncoderWithDescriptor:pass];
}

- (void)startIn:(id<MTLCommandBuffer>)commands before:(id<MTLBuffer>)written {
    [_device sampleTimestamps:&_host gpuTimestamp:&_gpu];
    const id<MTLBlitCommandEncoder> encoder = [self passIn:commands start:MTLCounterDontSample end:0];
    [encoder fillBuffer:written range:NSMakeRange(0, 4) value:0];
    [encoder endEncoding];
}

- (void)stopIn:(id<MTLCommandBuffer>)commands after:(id<MTLBuffer>)written {
    const id<MTLBlitCommandEncoder> encoder = [self passIn:commands start:1 end:MTLCounterDontSample];
    [encoder copyFromBuffer:written sourceOffset:0 toBuffer:_scratch destinationOffset:0 size:4];
    [encoder endEncoding];
}

- (NSTimeInterval)seconds {
    MTLTimestamp host = 0, gpu = 0;
    [_device sampleTimestamps:&host gpuTimestamp:&gpu];
    NSData *const data = [_samples resolveCounterRange:NSMakeRange(0, 2)];
    if (data.length < 2 * sizeof(MTLCounterResultTimestamp) || gpu <= _gpu) return NAN;
    const MTLCounterResultTimestamp *const times = data.bytes;
    if (times[0].timestamp == MTLCounterErrorValue || times[1].timestamp == MTLCounterErrorValue) return NAN;
    /* The GPU's ticks in the host's nanoseconds, by what passed on both since the start. */
    const double tick = (double)(host - _host) / (double)(gpu - _gpu) * 1e-9;
    return tick * (double)(times[1].timestamp - times[0].timestamp);
}

@end
