#import "DRRScan+Texture.h"

#import "DRREngine.h"
#import "DRRFailure.h"
#import "DRRPhantom.h"

@implementation DRRScan (Texture)

+ (nullable id<MTLTexture>)textureOf:(DRRPhantom *)phantom device:(id<MTLDevice>)device {
    const size_t *const n = phantom.descriptor->dimensions;
    MTLTextureDescriptor *const descriptor = [MTLTextureDescriptor new];
    descriptor.textureType = MTLTextureType3D;
    descriptor.pixelFormat = MTLPixelFormatR16Sint;
    descriptor.width = n[0];
    descriptor.height = n[1];
    descriptor.depth = n[2];
    descriptor.usage = MTLTextureUsageShaderRead;
    descriptor.storageMode = MTLStorageModeShared; /* memory that CPU and GPU share, on Apple silicon */
    const id<MTLTexture> texture = [device newTextureWithDescriptor:descriptor];
    [texture replaceRegion:MTLRegionMake3D(0, 0, 0, n[0], n[1], n[2])
               mipmapLevel:0
                     slice:0
                 withBytes:phantom.hu
               bytesPerRow:n[0] * sizeof(int16_t)
             bytesPerImage:n[0] * n[1] * sizeof(int16_t)];
    return texture;
}

- (nullable instancetype)initWithTexture:(id<MTLTexture>)texture
                              descriptor:(const DrrVolumeDescriptor *)descriptor
                                  engine:(DRREngine *)engine
                                   error:(NSError **)error {
    DrrVolume *volume = NULL;
    const DrrStatus status =
        drr_volume_create_metal_texture(engine.context, descriptor, (__bridge void *)texture, &volume);
    return DRRSucceeds(status, error) ? [self initWithVolume:volume descriptor:descriptor] : nil;
}

@end
