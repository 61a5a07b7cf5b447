// Everything of the demo's core, used and given up, errors included: no object of its classes is left, which GNUstep counts, and no
// handle of the library, which the leak sanitizer sees. With "object" or "handle" one is left on purpose.
#import <Foundation/Foundation.h>
#import <Foundation/NSDebug.h>

#include <stdio.h>
#include <string.h>

#import "DRREffectCosts.h"
#import "DRREngine.h"
#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRPhantom.h"
#import "DRRPicture.h"
#import "DRRPlan.h"
#import "DRRScan.h"
#import "DRRStereoPair.h"

static DRRShot *shot(NSArray *names, NSUInteger kvp, NSError **error) {
    DRREffects *const effects = [[[DRREffects alloc] initWithNames:names error:error] autorelease];
    return [[[DRRShot alloc] initWithAngle:6 kvp:kvp effects:effects size:32 error:error] autorelease];
}

static BOOL failures(DRREngine *engine) {
    NSError *error = nil;
    return [[DRREngine alloc] initWithBackend:99 error:&error] == nil && [[DRRPhantom alloc] initWithSpacing:0] == nil &&
           [[DRREffects alloc] initWithNames:[NSArray arrayWithObject:@"fog"] error:&error] == nil &&
           shot([NSArray array], 90, &error) == nil &&
           [[DRRScan alloc] initWithPath:@"/none" engine:engine error:&error] == nil;
}

static BOOL pictures(DRREngine *engine, NSError **error) {
    DRRPhantom *const phantom = [[[DRRPhantom alloc] initWithSpacing:8] autorelease];
    DRRScan *const scan = [[[DRRScan alloc] initWithPhantom:phantom engine:engine error:error] autorelease];
    DRRStereoPair *const pair = [[[DRRStereoPair alloc] initWithScan:scan] autorelease];
    static float image[DRRViews * 32 * 32];
    for (NSString *name in [DRREffects allNames])
        if (![pair take:shot([NSArray arrayWithObject:name], 80, error) into:image error:error]) return NO;
    DRRPicture *const picture = [[[DRRPicture alloc] initWithIntensity:image views:2 width:32 height:32] autorelease];
    NSArray *const costly = [NSArray arrayWithObjects:@"focal-spot", @"blur", nil];
    return [[picture pixels] length] == sizeof image / 2 &&
           DRREffectCosts(pair, shot([NSArray array], 120, error), costly, 1, error) != nil &&
           ![picture writeTo:@"/none/picture" error:error];
}

static int left(void) {
    int left = 0;
    for (NSString *name in [@"DRREngine DRRPhantom DRRScan DRREffects DRRShot DRRPlan DRRStereoPair DRRPicture"
             componentsSeparatedByString:@" "]) {
        const int count = GSDebugAllocationCount(NSClassFromString(name));
        const int ever = GSDebugAllocationTotal(NSClassFromString(name));
        if (count != 0 || ever == 0) printf("%s: %d of %d left\n", [name UTF8String], count, ever);
        left += count != 0 || ever == 0;
    }
    return left;
}

int main(int argc, char **argv) {
    GSDebugAllocationActive(YES);
    int result = 0;
    DRR_POOL {
        NSError *error = nil;
        DRREngine *const engine = [[[DRREngine alloc] initWithBackend:DRR_BACKEND_CPU error:&error] autorelease];
        if (engine == nil || !failures(engine) || !pictures(engine, &error)) {
            printf("%s\n", [[error localizedDescription] UTF8String]);
            result = 1;
        }
    }
    DRR_POOL {
        if (argc > 1 && strcmp(argv[1], "object") == 0) [[DRREffects alloc] initWithNames:[NSArray array] error:NULL];
        DrrContext *context = NULL;
        if (argc > 1 && strcmp(argv[1], "handle") == 0) drr_context_create(NULL, &context);
        result += left();
    }
    if (result == 0) printf("PASS\n");
    return result;
}
