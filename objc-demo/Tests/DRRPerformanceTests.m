// The specification's section 7.2: two views of 720 x 720 pixels of 720 x 720 x 665 voxels, 100 times, GPU time by
// MTLCounterSampleBuffer. Times are reported, not judged: the specification allows 70 ms on an M4 Max.
#include <math.h>

#import "DRRMetalCase.h"
#import "DRRPhantom.h"
#import "DRRStopwatch.h"

enum { PIXELS = 720, RUNS = 100 };

@interface DRRPerformanceTests : DRRMetalCase
@end

@implementation DRRPerformanceTests

// "average 4.1 ms, 5 % 4.0, median 4.1, 95 % 4.3, largest 4.9".
- (NSString *)summary:(NSArray<NSNumber *> *)seconds {
    NSArray<NSNumber *> *const sorted = [seconds sortedArrayUsingSelector:@selector(compare:)];
    double sum = 0;
    for (NSNumber *time in sorted) sum += time.doubleValue;
    const NSUInteger last = sorted.count - 1;
    const double milliseconds[] = {sum / (double)sorted.count, sorted[last * 5 / 100].doubleValue,
                                   sorted[last / 2].doubleValue, sorted[last * 95 / 100].doubleValue,
                                   sorted[last].doubleValue};
    return [NSString stringWithFormat:@"average %.2f ms, 5 %% %.2f, median %.2f, 95 %% %.2f, largest %.2f",
                                      1e3 * milliseconds[0], 1e3 * milliseconds[1], 1e3 * milliseconds[2],
                                      1e3 * milliseconds[3], 1e3 * milliseconds[4]];
}

- (void)report:(NSString *)text {
    NSLog(@"%@", text);
    XCTAttachment *const attachment = [XCTAttachment attachmentWithString:text];
    attachment.lifetime = XCTAttachmentLifetimeKeepAlways;
    [self addAttachment:attachment];
}

- (void)testDualView {
    NSError *error = nil;
    DRRStopwatch *const watch = [[DRRStopwatch alloc] initWithDevice:self.device error:&error];
    XCTSkipIf(watch == nil, @"%@", error.localizedDescription);
    DRRPhantom *const phantom = [[DRRPhantom alloc] initOfTargetCase];
    XCTAssertNotNil(phantom);
    DRRMetalPair *const pair = [self pairOf:[self scanOf:phantom engine:self.engine] size:PIXELS];
    DRRShot *const shot = [self shotAt:6 kvp:120 effects:@[] size:PIXELS];

    NSMutableArray<NSNumber *> *const counted = [NSMutableArray array], *const all = [NSMutableArray array];
    for (int run = 0; run <= RUNS; run++) {
        @autoreleasepool {
            __block id<MTLCommandBuffer> buffer = nil;
            [self run:^(id<MTLCommandBuffer> commands) {
                NSError *reason = nil;
                buffer = commands;
                [watch startIn:commands before:pair.intensity];
                XCTAssertTrue([pair encode:shot into:commands error:&reason], @"%@", reason);
                [watch stopIn:commands after:pair.intensity];
            }];
            if (run == 0) continue; /* compiles the kernel */
            const NSTimeInterval seconds = [watch seconds];
            XCTAssertTrue(seconds > 0, @"a counter failed in run %d", run);
            [counted addObject:@(seconds)];
            [all addObject:@(buffer.GPUEndTime - buffer.GPUStartTime)];
        }
    }
    [self report:[NSString stringWithFormat:@"%@, %d runs, two views\nby counters: %@\nwhole command buffers: %@",
                                            self.device.name, RUNS, [self summary:counted], [self summary:all]]];
}

@end
