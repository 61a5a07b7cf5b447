// From a shot to the screen, as fast as the GPU goes: while one is being shown, only the newest request waits.
#import <Foundation/Foundation.h>
#import <QuartzCore/CAMetalLayer.h>

@class DRRMetalPair, DRRShot;

NS_ASSUME_NONNULL_BEGIN

// How long the GPU worked, and how long it all took, seconds; an error when it came to nothing.
typedef void (^DRRShown)(NSTimeInterval gpu, NSTimeInterval all, NSError *_Nullable error);

@interface DRRRenderer : NSObject

// Called on the main thread when something has been shown.
@property (nonatomic, copy, nullable) DRRShown shown;

// The layer's drawables have two views of the pair's size side by side, and are written by a kernel.
- (nullable instancetype)initWithPair:(DRRMetalPair *)pair layer:(CAMetalLayer *)layer error:(NSError **)error;

// Main thread only. A shot that is the last one's object is not projected again: only window and level are new.
- (void)show:(DRRShot *)shot window:(float)window level:(float)level;

@end

NS_ASSUME_NONNULL_END
