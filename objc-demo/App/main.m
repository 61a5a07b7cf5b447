// The window on a Mac.
#import <AppKit/AppKit.h>

#import "DRRApp.h"

int main(void) {
    @autoreleasepool {
        NSApplication *const application = NSApplication.sharedApplication;
        DRRApp *const delegate = [DRRApp new]; /* which the application does not keep */
        application.delegate = delegate;
        [application setActivationPolicy:NSApplicationActivationPolicyRegular];
        [application run];
    }
    return 0;
}
