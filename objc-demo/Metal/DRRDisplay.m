#import "DRRDisplay.h"

#import "DRRKernel.h"
#import "DRRShot.h"

// As in Display.metal.
typedef struct {
    float window, level;
    uint32_t views, size;
} DRRDisplayUniforms;

@implementation DRRDisplay {
    DRRKernel *_kernel;
}

- (nullable instancetype)initWithDevice:(id<MTLDevice>)device error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _kernel = [[DRRKernel alloc] initWithFunction:@"drr_display" file:@"Display" device:device error:error];
    return _kernel == nil ? nil : self;
}

- (BOOL)show:(id<MTLBuffer>)intensity
        size:(NSUInteger)size
      window:(float)window
       level:(float)level
          on:(id<MTLTexture>)picture
    commands:(id<MTLCommandBuffer>)commands
       error:(NSError **)error {
    const DRRDisplayUniforms uniforms = {window, level, DRRViews, (uint32_t)size};
    return [_kernel encodeInto:commands
                          grid:MTLSizeMake(DRRViews * size, size, 1)
                     arguments:^(id<MTLComputeCommandEncoder> encoder) {
                         [encoder setBuffer:intensity offset:0 atIndex:0];
                         [encoder setBytes:&uniforms length:sizeof uniforms atIndex:1];
                         [encoder setTexture:picture atIndex:0];
                     }
                         error:error];
}

@end
