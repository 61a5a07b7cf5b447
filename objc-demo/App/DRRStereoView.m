#import "DRRStereoView.h"

@implementation DRRStereoView

- (instancetype)initWithDevice:(id<MTLDevice>)device size:(NSUInteger)size {
    if ((self = [super initWithFrame:NSMakeRect(0, 0, 2 * size, size)]) == nil) return nil;
    _metalLayer = [CAMetalLayer layer];
    _metalLayer.device = device;
    _metalLayer.pixelFormat = MTLPixelFormatBGRA8Unorm;
    _metalLayer.framebufferOnly = NO; /* a compute kernel writes it */
    _metalLayer.drawableSize = CGSizeMake(2 * size, size);
    self.wantsLayer = YES;
    self.layerContentsRedrawPolicy = NSViewLayerContentsRedrawNever; /* the renderer shows what there is to show */
    self.layerContentsPlacement = NSViewLayerContentsPlacementScaleProportionallyToFit;
    return self;
}

- (CALayer *)makeBackingLayer {
    return _metalLayer;
}

@end
