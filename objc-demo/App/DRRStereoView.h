// A view whose layer a Metal kernel writes: two square pictures side by side.
#import <AppKit/AppKit.h>
#import <QuartzCore/CAMetalLayer.h>

NS_ASSUME_NONNULL_BEGIN

@interface DRRStereoView : NSView

@property (nonatomic, readonly) CAMetalLayer *metalLayer;

// Pictures of `size` x `size` pixels, scaled to the view.
- (instancetype)initWithDevice:(id<MTLDevice>)device size:(NSUInteger)size;

@end

NS_ASSUME_NONNULL_END
