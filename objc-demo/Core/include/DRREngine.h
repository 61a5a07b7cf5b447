// What computes: owns a DrrContext.
#import <Foundation/Foundation.h>

#import "DRR_Shared.h"

@interface DRREngine : NSObject {
  @private
    DrrContext *_context;
}

// Valid as long as the engine.
@property (nonatomic, readonly) const DrrContext *context;
// "cpu", "metal Apple M4 Max", …
@property (nonatomic, readonly) NSString *name;

// The fastest engine of this machine (DRR_BACKEND_AUTO), or another one. nil with an error when it is not there.
- (instancetype)initWithBackend:(DrrBackend)backend error:(NSError **)error;
// Metal on a GPU of the caller's, an id<MTLDevice>: what is encoded for it must be of that GPU.
- (instancetype)initWithMetalDevice:(id)device error:(NSError **)error;

@end
