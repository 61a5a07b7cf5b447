#import "DRRMetalPair.h"

#import "DRRFailure.h"
#import "DRRPlan.h"
#import "DRRScan.h"
#import "DRRStereoPair.h"

@implementation DRRMetalPair {
    DRRScan *_scan;
    DRRStereoPair *_developed;
    NSMutableDictionary<NSNumber *, DRRPlan *> *_plans; // of shots without effects, by voltage
}

- (nullable instancetype)initWithScan:(DRRScan *)scan
                               device:(id<MTLDevice>)device
                                 size:(NSUInteger)size
                                error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _scan = scan;
    _device = device;
    _size = size;
    _developed = [[DRRStereoPair alloc] initWithScan:scan];
    _plans = [NSMutableDictionary dictionary];
    _intensity = [device newBufferWithLength:DRRViews * size * size * sizeof(float)
                                     options:MTLResourceStorageModeShared];
    if (_intensity != nil) return self;
    DRRFail((NSInteger)DRR_STATUS_OUT_OF_MEMORY, @"the GPU has no memory for the images", error);
    return nil;
}

- (nullable DRRPlan *)planOf:(DRRShot *)shot error:(NSError **)error {
    DRRPlan *plan = _plans[@(shot.kvp)];
    if (plan == nil) {
        plan = [[DRRPlan alloc] initWithScan:_scan shot:shot error:error];
        _plans[@(shot.kvp)] = plan;
    }
    return plan;
}

// The buffer has room for shots of one size.
- (BOOL)takes:(DRRShot *)shot error:(NSError **)error {
    if (shot.size == _size) return YES;
    NSString *const message = [NSString stringWithFormat:@"size is %lu; valid: %lu", shot.size, _size];
    return DRRFail(DRRErrorArgument, message, error);
}

- (BOOL)encode:(DRRShot *)shot into:(id<MTLCommandBuffer>)commands error:(NSError **)error {
    if (shot.effects.names.count != 0)
        return DRRFail(DRRErrorArgument, @"effects are finished on the CPU; valid: a shot without", error);
    double centre[3];
    DrrDetectorPose poses[DRRViews];
    [_scan getCentre:centre];
    if (![self takes:shot error:error] || ![shot getPoses:poses around:centre error:error]) return NO;
    DRRPlan *const plan = [self planOf:shot error:error];
    if (plan == nil) return NO;
    DrrDeviceOutputs outputs;
    drr_device_outputs_init(&outputs);
    outputs.intensity = (__bridge void *)_intensity;
    const DrrStatus status =
        drr_projector_encode_poses(plan.projector, poses, DRRViews, (__bridge void *)commands, &outputs);
    if (!DRRSucceeds(status, error)) return NO;
    /* The block keeps the plan, which must outlive what the GPU does with it. */
    [commands addCompletedHandler:^(id<MTLCommandBuffer> completed) {
        (void)completed;
        (void)plan;
    }];
    return YES;
}

- (BOOL)develop:(DRRShot *)shot error:(NSError **)error {
    return [self takes:shot error:error] && [_developed take:shot into:_intensity.contents error:error];
}

@end
