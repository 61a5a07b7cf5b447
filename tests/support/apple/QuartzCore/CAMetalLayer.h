// Stand-in, see ../README.md. With CALayer.
#pragma once
#import <Metal/Metal.h>

NS_ASSUME_NONNULL_BEGIN

@interface CALayer : NSObject
+ (instancetype)layer;
@end

@protocol CAMetalDrawable <MTLDrawable>
@property (readonly) id<MTLTexture> texture;
@end

@interface CAMetalLayer : CALayer
@property (nullable, retain) id<MTLDevice> device;
@property MTLPixelFormat pixelFormat;
@property BOOL framebufferOnly;
@property CGSize drawableSize;
- (nullable id<CAMetalDrawable>)nextDrawable;
@end

NS_ASSUME_NONNULL_END
