// Metal against the float64 engine on the CPU.
#include <math.h>

#import "DRREngine.h"
#import "DRRFailure.h"
#import "DRRMetalCase.h"
#import "DRRPhantom.h"
#import "DRRPlan.h"
#import "DRRScan+Texture.h"
#import "DRRStereoPair.h"

enum { PIXELS = 256, COUNT = DRRViews * PIXELS * PIXELS };

// What tests/conformance holds GPUs to, relative L2.
static const double gpu_tolerance = 2e-6;

@interface DRRAccuracyTests : DRRMetalCase
@end

@implementation DRRAccuracyTests {
    DRRPhantom *_phantom;
    DRRScan *_truth; // on the reference engine
}

- (BOOL)setUpWithError:(NSError **)error {
    if (![super setUpWithError:error]) return NO;
    _phantom = [[DRRPhantom alloc] initWithSpacing:2];
    DRREngine *const reference = [[DRREngine alloc] initWithBackend:DRR_BACKEND_REFERENCE error:error];
    if (_phantom == nil || reference == nil) return NO;
    _truth = [self scanOf:_phantom engine:reference];
    return YES;
}

- (NSData *)takeOf:(DRRScan *)scan shot:(DRRShot *)shot {
    NSMutableData *const image = [NSMutableData dataWithLength:COUNT * sizeof(float)];
    NSError *error = nil;
    DRRStereoPair *const pair = [[DRRStereoPair alloc] initWithScan:scan];
    XCTAssertTrue([pair take:shot into:image.mutableBytes error:&error], @"%@", error);
    return image;
}

// Encoded into a command buffer, the images of every voltage are the reference's.
- (void)testEncodedImages {
    DRRMetalPair *const pair = [self pairOf:[self scanOf:_phantom engine:self.engine] size:PIXELS];
    for (NSNumber *kvp in DRRShot.voltages) {
        DRRShot *const shot = [self shotAt:6 kvp:kvp.unsignedIntegerValue effects:@[] size:PIXELS];
        [self run:^(id<MTLCommandBuffer> commands) {
            NSError *error = nil;
            XCTAssertTrue([pair encode:shot into:commands error:&error], @"%@", error);
        }];
        NSData *const truth = [self takeOf:_truth shot:shot];
        XCTAssertLessThanOrEqual(DRRRelativeL2(pair.intensity.contents, truth.bytes, COUNT), gpu_tolerance);
    }
}

// Voxels that stay in a texture of the program's own are the voxels that the library would upload.
- (void)testTexture {
    NSError *error = nil;
    const id<MTLTexture> texture = [DRRScan textureOf:_phantom device:self.device];
    XCTAssertNotNil(texture);
    DRRScan *const scan = [[DRRScan alloc] initWithTexture:texture
                                                descriptor:_phantom.descriptor
                                                    engine:self.engine
                                                     error:&error];
    XCTAssertNotNil(scan, @"%@", error);
    DRRShot *const shot = [self shotAt:10 kvp:100 effects:@[] size:PIXELS];
    NSData *const image = [self takeOf:scan shot:shot], *const truth = [self takeOf:_truth shot:shot];
    XCTAssertLessThanOrEqual(DRRRelativeL2(image.bytes, truth.bytes, COUNT), gpu_tolerance);
}

// What effects need on the CPU starts from what the GPU has cast.
- (void)testEffects {
    DRRScan *const scan = [self scanOf:_phantom engine:self.engine];
    for (NSString *effect in @[ @"fall-off", @"heel", @"filter", @"blur" ]) {
        DRRShot *const shot = [self shotAt:6 kvp:120 effects:@[ effect ] size:PIXELS];
        NSData *const image = [self takeOf:scan shot:shot], *const truth = [self takeOf:_truth shot:shot];
        XCTAssertLessThanOrEqual(DRRRelativeL2(image.bytes, truth.bytes, COUNT), gpu_tolerance, @"%@", effect);
    }
}

// The specification's 2 HU: against the exact integral of the interpolated voxels, over rays with a twentieth of the largest p.
- (void)testHounsfieldUnits {
    DRRShot *const shot = [self shotAt:6 kvp:120 effects:@[] size:PIXELS];
    NSData *const image = [self takeOf:[self scanOf:_phantom engine:self.engine] shot:shot];
    const float *const intensity = image.bytes;

    NSError *error = nil;
    DRRPlan *const plan = [[DRRPlan alloc] initWithScan:_truth shot:shot error:&error];
    XCTAssertNotNil(plan, @"%@", error);
    double centre[3];
    DrrDetectorPose poses[DRRViews];
    [_truth getCentre:centre];
    XCTAssertTrue([shot getPoses:poses around:centre error:&error], @"%@", error);
    NSMutableData *const exact = [NSMutableData dataWithLength:COUNT * sizeof(double)];
    double *const p = exact.mutableBytes;
    DrrReferenceOutputs outputs;
    drr_reference_outputs_init(&outputs);
    outputs.line_integral = p;
    const DrrStatus status =
        drr_reference_project(plan.projector, DRR_ALGORITHM_EXACT, poses, DRRViews, &outputs);
    XCTAssertTrue(DRRSucceeds(status, &error), @"%@", error);

    double largest = 0, squares = 0;
    NSUInteger rays = 0;
    for (NSUInteger i = 0; i < COUNT; i++) largest = fmax(largest, p[i]);
    for (NSUInteger i = 0; i < COUNT; i++) {
        if (p[i] < largest / 20) continue;
        squares += pow(1000 * (-log(intensity[i]) - p[i]) / p[i], 2); /* the spectrum sums to 1 */
        rays++;
    }
    XCTAssertGreaterThan(rays, COUNT / 10);
    XCTAssertLessThanOrEqual(sqrt(squares / (double)rays), 2.0);
}

@end
