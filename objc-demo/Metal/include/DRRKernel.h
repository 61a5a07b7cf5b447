// A compute kernel of a .metal file of this folder, compiled when it is made.
#import <Metal/Metal.h>

NS_ASSUME_NONNULL_BEGIN

@interface DRRKernel : NSObject

@property (nonatomic, readonly) id<MTLComputePipelineState> state;

// `function` of `file`.metal, beside the program or in its bundle.
- (nullable instancetype)initWithFunction:(NSString *)function
                                     file:(NSString *)file
                                   device:(id<MTLDevice>)device
                                    error:(NSError **)error;

// Runs it for each of `grid`; `arguments` sets buffers and textures.
- (BOOL)encodeInto:(id<MTLCommandBuffer>)commands
              grid:(MTLSize)grid
         arguments:(void (NS_NOESCAPE ^)(id<MTLComputeCommandEncoder> encoder))arguments
             error:(NSError **)error;

@end

NS_ASSUME_NONNULL_END
