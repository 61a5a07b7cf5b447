// A window with the two views of one scan, and the controls of the shot.
#import <AppKit/AppKit.h>
#import <Metal/Metal.h>

@class DRRScan;

NS_ASSUME_NONNULL_BEGIN

@interface DRRViewer : NSObject

@property (nonatomic, readonly) NSWindow *window;

- (nullable instancetype)initWithScan:(DRRScan *)scan
                               device:(id<MTLDevice>)device
                                title:(NSString *)title
                                error:(NSError **)error;

@end

NS_ASSUME_NONNULL_END
