#import "DRRShot.h"

#import "DRRFailure.h"
#import "DRRMemory.h"

@implementation DRRShot

@synthesize angle = _angle, kvp = _kvp, size = _size, effects = _effects;

+ (NSArray *)voltages {
    NSMutableArray *voltages = [NSMutableArray array];
    for (unsigned kvp = 60; kvp <= 140; kvp += 20) [voltages addObject:[NSNumber numberWithUnsignedInt:kvp]];
    return voltages;
}

// What is wrong with the numbers, or nil.
static NSString *wrong(double angle, NSUInteger kvp, NSUInteger size) {
    if (!(angle > 0 && angle <= 45)) return [NSString stringWithFormat:@"angle is %g; valid: above 0 to 45 degrees", angle];
    if (![[DRRShot voltages] containsObject:[NSNumber numberWithUnsignedInteger:kvp]])
        return [NSString stringWithFormat:@"kvp is %lu; valid: %@", (unsigned long)kvp,
                                          [[DRRShot voltages] componentsJoinedByString:@", "]];
    if (size < 16 || size > 4096) return [NSString stringWithFormat:@"size is %lu; valid: 16 to 4096", (unsigned long)size];
    return nil;
}

- (instancetype)initWithAngle:(double)angle
                          kvp:(NSUInteger)kvp
                      effects:(DRREffects *)effects
                         size:(NSUInteger)size
                        error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _angle = angle;
    _kvp = kvp;
    _size = size;
    _effects = DRR_RETAIN(effects);
    NSString *const message = wrong(angle, kvp, size);
    const char *const tube = [[NSString stringWithFormat:@"W%lu_2p5Al", (unsigned long)kvp] UTF8String];
    if (message == nil ? DRRSucceeds(drr_physics_spectrum(tube, 15, 1, DRREnergies, _spectrum), error)
                       : DRRFail(DRRErrorArgument, message, error))
        return self;
    DRR_RELEASE(self);
    return nil;
}

- (void)dealloc {
    DRR_RELEASE(_effects);
    DRR_SUPER_DEALLOC;
}

- (void)getScene:(DrrScene *)scene {
    drr_scene_init(scene);
    scene->detector_width = scene->detector_height = _size;
    scene->spectrum = _spectrum;
    [_effects addTo:scene];
}

- (BOOL)getPoses:(DrrDetectorPose *)poses around:(const double *)centre error:(NSError **)error {
    const double pixel = 648.0 / (double)_size;
    for (int view = 0; view < DRRViews; view++) {
        const double angle = view == 0 ? -_angle : _angle;
        if (!DRRSucceeds(drr_pose_c_arm(centre, angle, 1000, 1500, pixel, _size, _size, &poses[view]), error)) return NO;
    }
    return YES;
}

- (BOOL)castsRaysOf:(DRRShot *)other {
    return other != nil && _angle == other->_angle && _size == other->_size &&
           _effects.moveRays == other->_effects.moveRays;
}

@end
