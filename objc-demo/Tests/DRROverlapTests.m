// Two command buffers, encoded on two threads, give what they give one after the other. Whether the GPU ran them at once is
// reported.
#include <string.h>

#import "DRRMetalCase.h"
#import "DRROverlap.h"
#import "DRRPhantom.h"

enum { PIXELS = 256 };

@interface DRROverlapTests : DRRMetalCase
@end

@implementation DRROverlapTests

- (void)testTwoCommandBuffers {
    DRRPhantom *const phantom = [[DRRPhantom alloc] initWithSpacing:2];
    DRRMetalPair *const pair = [self pairOf:[self scanOf:phantom engine:self.engine] size:PIXELS];
    DRRShot *const first = [self shotAt:4 kvp:120 effects:@[] size:PIXELS];
    DRRShot *const second = [self shotAt:6 kvp:120 effects:@[] size:PIXELS];
    const NSUInteger bytes = pair.intensity.length;
    const id<MTLBuffer> before = [self.device newBufferWithLength:bytes options:MTLResourceStorageModeShared];
    const id<MTLBuffer> filtered = [self.device newBufferWithLength:bytes options:MTLResourceStorageModeShared];

    NSMutableArray<NSData *> *const alone = [NSMutableArray array];
    for (DRRShot *shot in @[ second, first ]) {
        [self run:^(id<MTLCommandBuffer> commands) {
            NSError *error = nil;
            XCTAssertTrue([pair encode:shot into:commands error:&error], @"%@", error);
        }];
        [alone addObject:[NSData dataWithBytes:pair.intensity.contents length:bytes]];
    }
    memcpy(before.contents, pair.intensity.contents, bytes); /* of the first shot */

    NSError *error = nil;
    DRROverlap *const overlap = [[DRROverlap alloc] initWithPair:pair error:&error];
    XCTAssertNotNil(overlap, @"%@", error);
    XCTAssertTrue([overlap project:second filter:before into:filtered queue:self.queue error:&error], @"%@", error);
    XCTAssertEqual(memcmp(pair.intensity.contents, alone[0].bytes, bytes), 0);
    XCTAssertEqual(memcmp(before.contents, alone[1].bytes, bytes), 0);

    /* A median is one of its nine pixels. */
    const float *const from = before.contents, *const to = filtered.contents;
    const NSUInteger middle = (PIXELS / 2) * PIXELS + PIXELS / 2;
    NSUInteger found = 0;
    for (NSUInteger n = 0; n < 9; n++) found += from[middle + (n / 3) * PIXELS + n % 3 - PIXELS - 1] == to[middle];
    XCTAssertGreaterThan(found, 0u);
    NSLog(@"projection %.3f ms, filter %.3f ms, both %.3f ms", 1e3 * overlap.projectionSeconds,
          1e3 * overlap.filterSeconds, 1e3 * overlap.bothSeconds);
}

@end
