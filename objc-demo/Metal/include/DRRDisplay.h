// Window and level on the GPU.
#import <Metal/Metal.h>

NS_ASSUME_NONNULL_BEGIN

@interface DRRDisplay : NSObject

- (nullable instancetype)initWithDevice:(id<MTLDevice>)device error:(NSError **)error;

// Puts both views side by side into `picture`, 2 `size` x `size` pixels with MTLTextureUsageShaderWrite: -ln of `intensity`,
// DRRViews x size x size floats, with `level` in the middle of the greys and `window` from black to white.
- (BOOL)show:(id<MTLBuffer>)intensity
        size:(NSUInteger)size
      window:(float)window
       level:(float)level
          on:(id<MTLTexture>)picture
    commands:(id<MTLCommandBuffer>)commands
       error:(NSError **)error;

@end

NS_ASSUME_NONNULL_END
