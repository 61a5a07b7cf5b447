// drr-demo: two X-ray views of a CT into one picture, with what they took.
#include <stdio.h>
#include <sysexits.h>

#import "DRRArguments.h"
#import "DRREffectCosts.h"
#import "DRREngine.h"
#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRPhantom.h"
#import "DRRPicture.h"
#import "DRRScan.h"
#import "DRRShot.h"
#import "DRRStereoPair.h"

static void say(NSString *what, NSString *text) {
    printf("%-12s %s\n", [what UTF8String], [text UTF8String]);
}

static void say_seconds(NSString *what, NSTimeInterval seconds, NSString *text) {
    say(what, [NSString stringWithFormat:@"%9.2f ms  %@", 1e3 * seconds, text]);
}

static DRRScan *scan(DRRArguments *arguments, DRREngine *engine, NSError **error) {
    const NSTimeInterval start = [NSDate timeIntervalSinceReferenceDate];
    DRRScan *scan = nil;
    if (arguments.ct != nil) {
        scan = DRR_AUTORELEASE([[DRRScan alloc] initWithPath:arguments.ct engine:engine error:error]);
    } else {
        DRRPhantom *const phantom = DRR_AUTORELEASE([[DRRPhantom alloc] initWithSpacing:1.5]);
        if (phantom == nil) DRRFail((NSInteger)DRR_STATUS_OUT_OF_MEMORY, @"no memory for the phantom", error);
        else scan = DRR_AUTORELEASE([[DRRScan alloc] initWithPhantom:phantom engine:engine error:error]);
    }
    NSString *const name = arguments.ct == nil ? @"phantom" : arguments.ct;
    if (scan != nil)
        say_seconds(@"load", [NSDate timeIntervalSinceReferenceDate] - start,
                    [NSString stringWithFormat:@"%@, %@", name, scan.size]);
    return scan;
}

static BOOL write_picture(DRRArguments *arguments, const float *intensity, NSError **error) {
    const NSTimeInterval start = [NSDate timeIntervalSinceReferenceDate];
    NSString *const folder = arguments.output;
    NSString *const path =
        [folder stringByAppendingPathComponent:[@"stereo-pair." stringByAppendingString:[DRRPicture extension]]];
    const NSUInteger size = arguments.shot.size;
    DRRPicture *const picture = DRR_AUTORELEASE(
        [[DRRPicture alloc] initWithIntensity:intensity views:DRRViews width:size height:size]);
    if (picture == nil) return DRRFail((NSInteger)DRR_STATUS_OUT_OF_MEMORY, @"no memory for the picture", error);
    NSError *reason = nil;
    if (![[NSFileManager defaultManager] createDirectoryAtPath:folder
                                   withIntermediateDirectories:YES
                                                    attributes:nil
                                                         error:&reason])
        return DRRFail(DRRErrorFile, [NSString stringWithFormat:@"%@: %@", folder, [reason localizedDescription]], error);
    if (![picture writeTo:path error:error]) return NO;
    say_seconds(@"write", [NSDate timeIntervalSinceReferenceDate] - start, path);
    return YES;
}

static BOOL take(DRRArguments *arguments, DRRScan *scan, NSError **error) {
    DRRShot *const shot = arguments.shot;
    DRRStereoPair *const pair = DRR_AUTORELEASE([[DRRStereoPair alloc] initWithScan:scan]);
    NSMutableData *const image = [NSMutableData dataWithLength:DRRViews * shot.size * shot.size * sizeof(float)];
    if (![pair take:shot into:[image mutableBytes] error:error]) return NO;
    const unsigned long size = (unsigned long)shot.size;
    say_seconds(@"rays", pair.castSeconds,
                [NSString stringWithFormat:@"-%g and +%g degrees, %lu x %lu pixels each, planning included", shot.angle,
                                           shot.angle, size, size]);
    say_seconds(@"develop", pair.developSeconds,
                [NSString stringWithFormat:@"%lu kVp, %lu effects", (unsigned long)shot.kvp,
                                           (unsigned long)[shot.effects.names count]]);
    if (!write_picture(arguments, [image bytes], error)) return NO;
    NSDictionary *const costs = DRREffectCosts(pair, shot, shot.effects.names, 3, error);
    for (NSString *name in shot.effects.names)
        if (costs != nil) say_seconds(name, [[costs objectForKey:name] doubleValue], @"more than without it, median of 3");
    return costs != nil;
}

static BOOL run(DRRArguments *arguments, NSError **error) {
    DRREngine *const engine = DRR_AUTORELEASE([[DRREngine alloc] initWithBackend:DRR_BACKEND_AUTO error:error]);
    if (engine == nil) return NO;
    say(@"engine", engine.name);
    DRRScan *const ct = scan(arguments, engine, error);
    return ct != nil && take(arguments, ct, error);
}

// The exit status of an error: <sysexits.h>.
static int status(NSError *error) {
    switch ([error code]) {
    case DRRErrorArgument: return EX_USAGE;
    case DRRErrorFile: return EX_CANTCREAT;
    case DRR_STATUS_FILE: return EX_NOINPUT;
    default: return EX_SOFTWARE;
    }
}

int main(void) {
    int result = EX_OK;
    DRR_POOL {
        NSArray *const words = [[NSProcessInfo processInfo] arguments];
        NSError *error = nil;
        DRRArguments *const arguments = DRR_AUTORELEASE([[DRRArguments alloc]
            initWithArguments:[words subarrayWithRange:NSMakeRange(1, [words count] - 1)] error:&error]);
        if (arguments.help) {
            printf("%s", [[DRRArguments usage] UTF8String]);
        } else if (arguments == nil || !run(arguments, &error)) {
            fprintf(stderr, "drr-demo: %s\n", [[error localizedDescription] UTF8String]);
            result = status(error);
        }
    }
    return result;
}
