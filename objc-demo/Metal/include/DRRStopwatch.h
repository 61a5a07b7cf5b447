// GPU time of what is encoded between two places of a command buffer, by MTLCounterSampleBuffer.
#import <Metal/Metal.h>

NS_ASSUME_NONNULL_BEGIN

@interface DRRStopwatch : NSObject

// nil with an error where the GPU has no time stamps at the boundaries of passes.
- (nullable instancetype)initWithDevice:(id<MTLDevice>)device error:(NSError **)error;

// What is timed is put into a command buffer by other code, whose passes cannot be given a sample buffer. So the time begins at
// the end of a pass that writes 4 bytes at the start of `written`, which what is timed then writes, and ends at the start of one
// that reads them: Metal's hazard tracking keeps the passes in this order. No encoder may be open.
- (void)startIn:(id<MTLCommandBuffer>)commands before:(id<MTLBuffer>)written;
- (void)stopIn:(id<MTLCommandBuffer>)commands after:(id<MTLBuffer>)written;

// Seconds from one to the other, once the command buffer has completed; NaN when a counter failed.
- (NSTimeInterval)seconds;

@end

NS_ASSUME_NONNULL_END
