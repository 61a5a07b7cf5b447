// What is to be taken: the angle between the views, the tube's voltage, the effects, the detector. Immutable.
#import <Foundation/Foundation.h>

#import "DRREffects.h"
#import "DRR_Shared.h"

enum { DRRViews = 2, DRREnergies = 136 };

@interface DRRShot : NSObject {
  @private
    double _angle;
    NSUInteger _kvp, _size;
    DRREffects *_effects;
    float _spectrum[DRREnergies];
}

@property (nonatomic, readonly) double angle;
@property (nonatomic, readonly) NSUInteger kvp;
@property (nonatomic, readonly) NSUInteger size;
@property (nonatomic, readonly) DRREffects *effects;

// Voltages that there are spectra for, kV, as NSNumber: tungsten behind 2.5 mm of aluminium.
+ (NSArray *)voltages;

// Views at -angle and +angle degrees, above 0 to 45; `kvp` one of the voltages; `size` x `size` pixels, 16 to 4096, on a
// detector 648 mm wide, 1500 mm from the source and 500 mm behind the volume's centre. nil with an error.
- (instancetype)initWithAngle:(double)angle
                          kvp:(NSUInteger)kvp
                      effects:(DRREffects *)effects
                         size:(NSUInteger)size
                        error:(NSError **)error;

// The scene, which points into the shot and needs it as long as it is used.
- (void)getScene:(DrrScene *)scene;
// The views of a volume around `centre`: DRRViews of them, -angle first.
- (BOOL)getPoses:(DrrDetectorPose *)poses around:(const double *)centre error:(NSError **)error;
// Whether both cast the same rays, so that one's exposure can be developed as the other.
- (BOOL)castsRaysOf:(DRRShot *)other;

@end
