#import "DRRMetalCase.h"

#include <math.h>

#import "DRREngine.h"
#import "DRRPhantom.h"

@implementation DRRMetalCase

- (BOOL)setUpWithError:(NSError **)error {
    _device = MTLCreateSystemDefaultDevice();
    XCTSkipIf(_device == nil, @"this machine has no GPU that Metal can use");
    _queue = [_device newCommandQueue];
    _engine = [[DRREngine alloc] initWithMetalDevice:_device error:error];
    return _engine != nil;
}

- (DRRShot *)shotAt:(double)angle kvp:(NSUInteger)kvp effects:(NSArray<NSString *> *)effects size:(NSUInteger)size {
    NSError *error = nil;
    DRREffects *const on = [[DRREffects alloc] initWithNames:effects error:&error];
    XCTAssertNotNil(on, @"%@", error);
    DRRShot *const shot = [[DRRShot alloc] initWithAngle:angle kvp:kvp effects:on size:size error:&error];
    XCTAssertNotNil(shot, @"%@", error);
    return shot;
}

- (DRRScan *)scanOf:(DRRPhantom *)phantom engine:(DRREngine *)engine {
    NSError *error = nil;
    DRRScan *const scan = [[DRRScan alloc] initWithPhantom:phantom engine:engine error:&error];
    XCTAssertNotNil(scan, @"%@", error);
    return scan;
}

- (DRRMetalPair *)pairOf:(DRRScan *)scan size:(NSUInteger)size {
    NSError *error = nil;
    DRRMetalPair *const pair = [[DRRMetalPair alloc] initWithScan:scan device:_device size:size error:&error];
    XCTAssertNotNil(pair, @"%@", error);
    return pair;
}

- (void)run:(void (NS_NOESCAPE ^)(id<MTLCommandBuffer> commands))encode {
    const id<MTLCommandBuffer> commands = [_queue commandBuffer];
    XCTAssertNotNil(commands);
    encode(commands);
    [commands commit];
    [commands waitUntilCompleted];
    XCTAssertNil(commands.error);
}

@end

double DRRRelativeL2(const float *x, const float *truth, NSUInteger count) {
    double difference = 0, size = 0;
    for (NSUInteger i = 0; i < count; i++) {
        difference += pow((double)x[i] - truth[i], 2);
        size += pow(truth[i], 2);
    }
    const double distance = sqrt(difference / size);
    return isnan(distance) ? INFINITY : distance;
}
