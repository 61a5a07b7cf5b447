#import "DRREffectCosts.h"

#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRStereoPair.h"

// Median seconds of a shot, rays included if `cast`; -1 with an error.
static NSTimeInterval median(DRRStereoPair *pair, DRRShot *shot, NSUInteger runs, BOOL cast, NSError **error) {
    NSMutableData *const image = [NSMutableData dataWithLength:DRRViews * shot.size * shot.size * sizeof(float)];
    NSMutableArray *const times = [NSMutableArray arrayWithCapacity:runs];
    /* The first one makes what later ones find made, such as the scatter's kernels. */
    for (NSUInteger run = 0; run <= runs; run++) {
        if (cast) [pair forget];
        if (![pair take:shot into:[image mutableBytes] error:error]) return -1;
        if (run > 0) [times addObject:[NSNumber numberWithDouble:pair.castSeconds + pair.developSeconds]];
    }
    [times sortUsingSelector:@selector(compare:)];
    return [[times objectAtIndex:runs / 2] doubleValue];
}

static DRRShot *with(DRRShot *shot, NSArray *names, NSError **error) {
    DRREffects *const effects = DRR_AUTORELEASE([[DRREffects alloc] initWithNames:names error:error]);
    if (effects == nil) return nil;
    return DRR_AUTORELEASE(
        [[DRRShot alloc] initWithAngle:shot.angle kvp:shot.kvp effects:effects size:shot.size error:error]);
}

NSDictionary *DRREffectCosts(DRRStereoPair *pair, DRRShot *shot, NSArray *names, NSUInteger runs, NSError **error) {
    NSMutableDictionary *const costs = [NSMutableDictionary dictionary];
    DRRShot *const plain = with(shot, [NSArray array], error);
    if (plain == nil) return nil;
    NSTimeInterval without[2] = {-1, -1}; /* its development, and with its rays: measured when needed */
    for (NSString *name in names) {
        DRRShot *const effective = with(shot, [NSArray arrayWithObject:name], error);
        if (effective == nil) return nil;
        const BOOL cast = effective.effects.moveRays;
        if (without[cast] < 0) without[cast] = median(pair, plain, runs, cast, error);
        const NSTimeInterval seconds = without[cast] < 0 ? -1 : median(pair, effective, runs, cast, error);
        if (seconds < 0) return nil;
        [costs setObject:[NSNumber numberWithDouble:seconds - without[cast]] forKey:name];
    }
    return costs;
}
