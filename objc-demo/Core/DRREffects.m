#import "DRREffects.h"

#import "DRRFailure.h"
#import "DRRMemory.h"

static void fall_off(DrrScene *scene) {
    scene->effects |= DRR_EFFECT_FALL_OFF;
}

static void heel(DrrScene *scene) {
    scene->effects |= DRR_EFFECT_HEEL;
    scene->heel_target_angle_degrees = 16; /* the detector ends at 12.2, where an anode of 12 would leave nothing */
    scene->heel_cathode_degrees = -90;     /* the stronger side over the feet */
}

static void copper(DrrScene *scene) {
    static const DrrFilter filter = {.material = "copper", .thickness_mm = 0.1};
    scene->filters = &filter;
    scene->filter_count = 1;
}

static void focal_spot(DrrScene *scene) {
    scene->effects |= DRR_EFFECT_FOCAL_SPOT;
    scene->focal_spot_width_mm = scene->focal_spot_height_mm = 0.6; /* IEC 60336's nominal 0.6 */
}

static void scatter(DrrScene *scene) {
    scene->effects |= DRR_EFFECT_SCATTER;
}

static void blur(DrrScene *scene) {
    static const DrrBlurComponent spread[] = {{0.85, 0.25}, {0.15, 2.0}};
    scene->blur = spread;
    scene->blur_count = 2;
}

static void noise(DrrScene *scene) {
    scene->effects |= DRR_EFFECT_QUANTUM_NOISE;
    scene->photons_per_pixel = 2e4;
}

static const struct {
    const char *name, *title;
    void (*add)(DrrScene *);
} all[] = {
    {"fall-off", "inverse square and obliquity", fall_off}, {"heel", "the anode filters itself", heel},
    {"filter", "0.1 mm of copper", copper},                 {"focal-spot", "a source of 0.6 mm", focal_spot},
    {"scatter", "photons that the patient scatters", scatter}, {"blur", "the detector's own spread", blur},
    {"noise", "20000 photons per pixel", noise},
};

enum { COUNT = sizeof all / sizeof *all };

@implementation DRREffects

+ (NSArray *)allNames {
    NSMutableArray *names = [NSMutableArray arrayWithCapacity:COUNT];
    for (int n = 0; n < COUNT; n++) [names addObject:[NSString stringWithUTF8String:all[n].name]];
    return names;
}

+ (NSString *)titleOf:(NSString *)name {
    const NSUInteger n = [[self allNames] indexOfObject:name];
    return n == NSNotFound ? nil : [NSString stringWithUTF8String:all[n].title];
}

- (instancetype)initWithNames:(NSArray *)names error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    NSArray *known = [DRREffects allNames];
    for (NSString *name in names) {
        if ([known containsObject:name]) continue;
        DRRFail(DRRErrorArgument,
                [NSString stringWithFormat:@"effect is \"%@\"; valid: %@", name, [known componentsJoinedByString:@", "]],
                error);
        DRR_RELEASE(self);
        return nil;
    }
    _names = [[NSSet alloc] initWithArray:names];
    return self;
}

- (void)dealloc {
    DRR_RELEASE(_names);
    DRR_SUPER_DEALLOC;
}

- (NSArray *)names {
    NSMutableArray *names = [NSMutableArray array];
    for (NSString *name in [DRREffects allNames])
        if ([_names containsObject:name]) [names addObject:name];
    return names;
}

- (BOOL)moveRays {
    return [_names containsObject:@"focal-spot"];
}

- (void)addTo:(DrrScene *)scene {
    for (int n = 0; n < COUNT; n++)
        if ([_names containsObject:[NSString stringWithUTF8String:all[n].name]]) all[n].add(scene);
}

@end
