// How a shot of a scan is computed: owns a DrrProjector.
#import <Foundation/Foundation.h>

#import "DRR_Shared.h"

@class DRRScan, DRRShot;

@interface DRRPlan : NSObject {
  @private
    DrrProjector *_projector;
}

// Valid as long as the plan: keep that until a queue has run what was encoded with it.
@property (nonatomic, readonly) const DrrProjector *projector;

// nil with an error.
- (instancetype)initWithScan:(DRRScan *)scan shot:(DRRShot *)shot error:(NSError **)error;

@end
