// What the tests on a GPU share: a device, a phantom on it, and command buffers that are waited for.
#import <Metal/Metal.h>
#import <XCTest/XCTest.h>

#import "DRRMetalPair.h"
#import "DRRScan.h"

NS_ASSUME_NONNULL_BEGIN

@interface DRRMetalCase : XCTestCase

@property (nonatomic, readonly) id<MTLDevice> device;
@property (nonatomic, readonly) id<MTLCommandQueue> queue;
@property (nonatomic, readonly) DRREngine *engine;

// Asserts that it can be made.
- (DRRShot *)shotAt:(double)angle kvp:(NSUInteger)kvp effects:(NSArray<NSString *> *)effects size:(NSUInteger)size;
- (DRRScan *)scanOf:(DRRPhantom *)phantom engine:(DRREngine *)engine;
- (DRRMetalPair *)pairOf:(DRRScan *)scan size:(NSUInteger)size;

// Encodes into a command buffer of the queue, and asserts that it completes.
- (void)run:(void (NS_NOESCAPE ^)(id<MTLCommandBuffer> commands))encode;

@end

// |x - truth| / |truth|, Euclidean norms over `count` numbers; infinite when one of them is no number.
double DRRRelativeL2(const float *x, const float *truth, NSUInteger count);

NS_ASSUME_NONNULL_END
