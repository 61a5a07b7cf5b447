#import "DRRArguments.h"

#include <stdlib.h>

#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRPicture.h"
#import "DRRShot.h"

@implementation DRRArguments

@synthesize ct = _ct, output = _output, shot = _shot, help = _help;

+ (NSString *)usage {
    NSMutableString *const text = [NSMutableString
        stringWithFormat:@"usage: drr-demo [options]\n\n"
                          "Two X-ray views of a CT, side by side in one picture, with what they took.\n\n"
                          "  --ct FILE         NIfTI, MetaImage, NRRD, a folder of DICOM [default: a phantom]\n"
                          "  --angle DEGREES   views at -DEGREES and +DEGREES, above 0 to 45 [default: 6]\n"
                          "  --kvp KILOVOLTS   %@ [default: 120]\n"
                          "  --size PIXELS     of a view, 16 to 4096 [default: 720]\n"
                          "  --effects NAMES   with commas between them [default: none]; each one's cost is measured\n"
                          "  --output FOLDER   gets stereo-pair.%@ [default: drr-output]\n\neffects:\n",
                         [[DRRShot voltages] componentsJoinedByString:@", "], [DRRPicture extension]];
    for (NSString *name in [DRREffects allNames])
        [text appendFormat:@"  %-16s  %@\n", [name UTF8String], [DRREffects titleOf:name]];
    return text;
}

// A number that is all of the text; NO with an error.
static BOOL parse(NSString *option, NSString *text, double *number, NSError **error) {
    char *end = NULL;
    const char *const start = [text UTF8String];
    *number = strtod(start, &end);
    if (*start != '\0' && *end == '\0') return YES;
    NSString *const message = [NSString stringWithFormat:@"%@ is \"%@\"; valid: a number", option, text];
    return DRRFail(DRRErrorArgument, message, error);
}

// As parse, of a whole number.
static BOOL parse_whole(NSString *option, NSString *text, NSUInteger *number, NSError **error) {
    double value = 0;
    if (!parse(option, text, &value, error)) return NO;
    *number = (NSUInteger)(value >= 0 && value <= 1e6 ? value : 0);
    if ((double)*number == value) return YES;
    NSString *const message = [NSString stringWithFormat:@"%@ is \"%@\"; valid: a whole number", option, text];
    return DRRFail(DRRErrorArgument, message, error);
}

// The options' values by name, the defaults where none is given; nil with an error.
static NSDictionary *values(NSArray *arguments, NSError **error) {
    NSMutableDictionary *const values = [NSMutableDictionary
        dictionaryWithObjectsAndKeys:@"", @"--ct", @"6", @"--angle", @"120", @"--kvp", @"720", @"--size", @"",
                                     @"--effects", @"drr-output", @"--output", nil];
    for (NSUInteger n = 0; n < [arguments count]; n += 2) {
        NSString *const option = [arguments objectAtIndex:n];
        NSString *message = nil;
        if ([values objectForKey:option] == nil)
            message = [NSString stringWithFormat:@"there is no option \"%@\"; --help lists them", option];
        else if (n + 1 == [arguments count] || [[arguments objectAtIndex:n + 1] length] == 0)
            message = [NSString stringWithFormat:@"%@ needs a value", option];
        if (message != nil) {
            DRRFail(DRRErrorArgument, message, error);
            return nil;
        }
        [values setObject:[arguments objectAtIndex:n + 1] forKey:option];
    }
    return values;
}

- (BOOL)read:(NSDictionary *)values error:(NSError **)error {
    double angle = 0;
    NSUInteger kvp = 0, size = 0;
    if (!parse(@"--angle", [values objectForKey:@"--angle"], &angle, error)) return NO;
    if (!parse_whole(@"--kvp", [values objectForKey:@"--kvp"], &kvp, error)) return NO;
    if (!parse_whole(@"--size", [values objectForKey:@"--size"], &size, error)) return NO;
    NSString *const list = [values objectForKey:@"--effects"];
    NSArray *const names = [list length] == 0 ? [NSArray array] : [list componentsSeparatedByString:@","];
    DRREffects *const effects = DRR_AUTORELEASE([[DRREffects alloc] initWithNames:names error:error]);
    if (effects == nil) return NO;
    _shot = [[DRRShot alloc] initWithAngle:angle kvp:kvp effects:effects size:size error:error];
    NSString *const ct = [values objectForKey:@"--ct"];
    _ct = [ct length] == 0 ? nil : [ct copy];
    _output = [[values objectForKey:@"--output"] copy];
    return _shot != nil;
}

- (instancetype)initWithArguments:(NSArray *)arguments error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _help = [arguments containsObject:@"--help"];
    if (_help) return self;
    NSDictionary *const given = values(arguments, error);
    if (given != nil && [self read:given error:error]) return self;
    DRR_RELEASE(self);
    return nil;
}

- (void)dealloc {
    DRR_RELEASE(_ct);
    DRR_RELEASE(_output);
    DRR_RELEASE(_shot);
    DRR_SUPER_DEALLOC;
}

@end
