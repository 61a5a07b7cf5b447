// A scan whose voxels are in a texture of the program's own: the library reads them there and copies nothing.
#import <Metal/Metal.h>

#import "DRRScan.h"

NS_ASSUME_NONNULL_BEGIN

@interface DRRScan (Texture)

// A texture of int16 HU, one texel per voxel, as a pipeline that loads CTs itself would have it. nil without memory.
+ (nullable id<MTLTexture>)textureOf:(DRRPhantom *)phantom device:(id<MTLDevice>)device;

// `texture` is of the engine's GPU, and retained; its texels must stay as they are while the scan is projected.
- (nullable instancetype)initWithTexture:(id<MTLTexture>)texture
                              descriptor:(const DrrVolumeDescriptor *)descriptor
                                  engine:(DRREngine *)engine
                                   error:(NSError **)error;

@end

NS_ASSUME_NONNULL_END
