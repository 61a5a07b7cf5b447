// The specification's section 6.3: two command buffers of one queue, in an order that is decided before either is encoded,
// encoded on two threads, committed each on its own.
//
// The second one stands for the specification's task of the Neural Engine: Metal does not reach that; Core ML does, and runs
// beside any command buffer. Here it is a median filter on the GPU, of the pair before this one: what a denoiser would work on
// while the next pair is projected. Nothing that it touches is touched by the projection, so that the GPU may run both at once.
#import <Metal/Metal.h>

@class DRRMetalPair, DRRShot;

NS_ASSUME_NONNULL_BEGIN

@interface DRROverlap : NSObject

// Of the last run, seconds on the GPU: of the projection, of the filter, and of both together, from the first start to the last
// end. They overlapped if the last is less than the sum.
@property (nonatomic, readonly) NSTimeInterval projectionSeconds;
@property (nonatomic, readonly) NSTimeInterval filterSeconds;
@property (nonatomic, readonly) NSTimeInterval bothSeconds;

- (nullable instancetype)initWithPair:(DRRMetalPair *)pair error:(NSError **)error;

// Projects `shot`, which has no effects, into the pair's buffer and filters `before` into `filtered`, buffers like the pair's
// own. Returns when both are done.
- (BOOL)project:(DRRShot *)shot
         filter:(id<MTLBuffer>)before
           into:(id<MTLBuffer>)filtered
          queue:(id<MTLCommandQueue>)queue
          error:(NSError **)error;

@end

NS_ASSUME_NONNULL_END
