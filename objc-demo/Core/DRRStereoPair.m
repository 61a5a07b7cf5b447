#import "DRRStereoPair.h"

#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRPlan.h"
#import "DRRScan.h"

@implementation DRRStereoPair

@synthesize castSeconds = _castSeconds, developSeconds = _developSeconds;

- (instancetype)initWithScan:(DRRScan *)scan {
    if ((self = [super init]) != nil) _scan = DRR_RETAIN(scan);
    return self;
}

- (void)dealloc {
    [self forget];
    DRR_RELEASE(_scan);
    DRR_SUPER_DEALLOC;
}

- (void)forget {
    drr_exposure_destroy(_exposure);
    _exposure = NULL;
    DRR_RELEASE(_cast);
    _cast = nil;
}

- (BOOL)cast:(DRRShot *)shot error:(NSError **)error {
    [self forget];
    double centre[3];
    DrrDetectorPose poses[DRRViews];
    [_scan getCentre:centre];
    if (![shot getPoses:poses around:centre error:error]) return NO;
    DRRPlan *const plan = [[DRRPlan alloc] initWithScan:_scan shot:shot error:error];
    if (plan == nil) return NO;
    const DrrStatus status = drr_exposure_create_poses(plan.projector, poses, DRRViews, NULL, NULL, &_exposure);
    const BOOL done = DRRSucceeds(status, error);
    DRR_RELEASE(plan); /* the exposure does not need it */
    if (done) _cast = DRR_RETAIN(shot);
    return done;
}

- (BOOL)take:(DRRShot *)shot into:(float *)intensity error:(NSError **)error {
    DrrScene scene;
    [shot getScene:&scene];
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = intensity;

    const NSTimeInterval start = [NSDate timeIntervalSinceReferenceDate];
    const BOOL known = [shot castsRaysOf:_cast];
    if (!known && ![self cast:shot error:error]) return NO;
    const NSTimeInterval cast = [NSDate timeIntervalSinceReferenceDate];
    if (!DRRSucceeds(drr_exposure_develop(_exposure, &scene, &outputs), error)) return NO;
    _developSeconds = [NSDate timeIntervalSinceReferenceDate] - cast;
    _castSeconds = known ? 0 : cast - start;
    return YES;
}

@end
