// One source for ARC and for manual reference counting: with ARC the macros are nothing, without it they are the messages.
#import <Foundation/Foundation.h>

#if defined(__has_feature)
#if __has_feature(objc_arc)
#define DRR_ARC 1
#endif
#endif

#if defined(DRR_ARC)
#define DRR_RETAIN(object) (object)
#define DRR_RELEASE(object) ((void)0)
#define DRR_AUTORELEASE(object) (object)
#define DRR_SUPER_DEALLOC ((void)0)
#else
#define DRR_RETAIN(object) [(object) retain]
#define DRR_RELEASE(object) [(object) release]
#define DRR_AUTORELEASE(object) [(object) autorelease]
#define DRR_SUPER_DEALLOC [super dealloc]
#endif

// A block with a pool of its own, which must not be left by return, break or goto: GCC has no @autoreleasepool.
#if defined(__clang__)
#define DRR_POOL @autoreleasepool
#else
#define DRR_POOL \
    for (NSAutoreleasePool *drr_pool = [NSAutoreleasePool new]; drr_pool != nil; [drr_pool drain], drr_pool = nil)
#endif
