#import "DRRPlan.h"

#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRScan.h"
#import "DRRShot.h"

@implementation DRRPlan

- (const DrrProjector *)projector {
    return _projector;
}

- (instancetype)initWithScan:(DRRScan *)scan shot:(DRRShot *)shot error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    DrrScene scene;
    [shot getScene:&scene];
    if (DRRSucceeds(drr_projector_create(scan.volume, &scene, &_projector), error)) return self;
    DRR_RELEASE(self);
    return nil;
}

- (void)dealloc {
    drr_projector_destroy(_projector);
    DRR_SUPER_DEALLOC;
}

@end
