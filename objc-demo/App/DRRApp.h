// The application: a phantom at first, and any CT that is opened.
#import <AppKit/AppKit.h>

@interface DRRApp : NSObject <NSApplicationDelegate>
@end
