// The two views of a scan in a buffer that GPU and CPU share: encoded into the program's own command buffers where the GPU does
// all of it, developed into the same memory where effects need the CPU. Nothing is copied in either case.
#import <Metal/Metal.h>

#import "DRRShot.h"

@class DRRScan;

NS_ASSUME_NONNULL_BEGIN

@interface DRRMetalPair : NSObject

@property (nonatomic, readonly) id<MTLDevice> device;
// DRRViews x size x size floats, as -[DRRStereoPair take:into:error:] writes them.
@property (nonatomic, readonly) id<MTLBuffer> intensity;
@property (nonatomic, readonly) NSUInteger size;

// `scan` is of an engine of the same GPU. nil with an error.
- (nullable instancetype)initWithScan:(DRRScan *)scan
                               device:(id<MTLDevice>)device
                                 size:(NSUInteger)size
                                error:(NSError **)error;

// Puts the projection of a shot without effects into `commands`, which has no open encoder and is not committed: what comes
// later there finds `intensity` complete. The plan of each voltage is made once and kept; it lives at least until `commands` has
// completed. Any thread, one at a time.
- (BOOL)encode:(DRRShot *)shot into:(id<MTLCommandBuffer>)commands error:(NSError **)error;

// Makes the images of a shot with effects before it returns; rays are cast on the GPU, and only when angle or focal spot are new.
// No command buffer may be using `intensity`. One thread at a time.
- (BOOL)develop:(DRRShot *)shot error:(NSError **)error;

@end

NS_ASSUME_NONNULL_END
