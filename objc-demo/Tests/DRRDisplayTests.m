// What the GPU shows is what the command writes.
#include <math.h>
#include <stdlib.h>

#import "DRRDisplay.h"
#import "DRRMetalCase.h"
#import "DRRPhantom.h"
#import "DRRPicture.h"

enum { PIXELS = 128 };

@interface DRRDisplayTests : DRRMetalCase
@end

@implementation DRRDisplayTests

- (void)testWindowAndLevel {
    NSError *error = nil;
    DRRPhantom *const phantom = [[DRRPhantom alloc] initWithSpacing:4];
    DRRMetalPair *const pair = [self pairOf:[self scanOf:phantom engine:self.engine] size:PIXELS];
    DRRShot *const shot = [self shotAt:6 kvp:120 effects:@[ @"noise" ] size:PIXELS];
    XCTAssertTrue([pair develop:shot error:&error], @"%@", error);
    DRRPicture *const picture = [[DRRPicture alloc] initWithIntensity:pair.intensity.contents
                                                                views:DRRViews
                                                                width:PIXELS
                                                               height:PIXELS];
    const unsigned char *const written = picture.pixels.bytes; /* 16 bits, big-endian */

    MTLTextureDescriptor *const descriptor =
        [MTLTextureDescriptor texture2DDescriptorWithPixelFormat:MTLPixelFormatBGRA8Unorm
                                                           width:DRRViews * PIXELS
                                                          height:PIXELS
                                                       mipmapped:NO];
    descriptor.usage = MTLTextureUsageShaderWrite;
    descriptor.storageMode = MTLStorageModeShared;
    const id<MTLTexture> texture = [self.device newTextureWithDescriptor:descriptor];
    DRRDisplay *const display = [[DRRDisplay alloc] initWithDevice:self.device error:&error];
    XCTAssertNotNil(display, @"%@", error);
    [self run:^(id<MTLCommandBuffer> commands) {
        NSError *reason = nil;
        XCTAssertTrue([display show:pair.intensity
                               size:PIXELS
                             window:(float)picture.window
                              level:(float)picture.level
                                 on:texture
                           commands:commands
                              error:&reason],
                      @"%@", reason);
    }];
    NSMutableData *const shown = [NSMutableData dataWithLength:4 * DRRViews * PIXELS * PIXELS];
    [texture getBytes:shown.mutableBytes
          bytesPerRow:4 * DRRViews * PIXELS
           fromRegion:MTLRegionMake2D(0, 0, DRRViews * PIXELS, PIXELS)
          mipmapLevel:0];
    const unsigned char *const bytes = shown.bytes;
    int largest = 0;
    for (NSUInteger n = 0; n < DRRViews * PIXELS * PIXELS; n++) {
        const double grey = (256 * written[2 * n] + written[2 * n + 1]) / 257.0;
        for (int colour = 0; colour < 3; colour++) largest = MAX(largest, abs(bytes[4 * n + colour] - (int)lrint(grey)));
    }
    XCTAssertLessThanOrEqual(largest, 1); /* 8 bits, of float32 */
}

@end
