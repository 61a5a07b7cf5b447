#import "DRRPicture.h"

#if __has_include(<ImageIO/ImageIO.h>)
#import <ImageIO/ImageIO.h>
#define DRR_IMAGE_IO 1
#endif

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#import "DRRFailure.h"
#import "DRRMemory.h"

static int by_value(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

@implementation DRRPicture

@synthesize window = _window, level = _level;

- (instancetype)initWithIntensity:(const float *)intensity
                            views:(NSUInteger)views
                            width:(NSUInteger)width
                           height:(NSUInteger)height {
    if ((self = [super init]) == nil) return nil;
    _views = views;
    _width = width;
    _height = height;
    const size_t count = views * width * height;
    _values = malloc(count * sizeof *_values);
    float *sorted = malloc(count * sizeof *sorted);
    if (count == 0 || _values == NULL || sorted == NULL) {
        free(sorted);
        DRR_RELEASE(self);
        return nil;
    }
    /* Noise may leave nothing, or less: as dark as can be. */
    for (size_t i = 0; i < count; i++) _values[i] = -logf(fmaxf(intensity[i], FLT_MIN));
    memcpy(sorted, _values, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, by_value);
    const double low = sorted[count / 100], high = sorted[count - 1 - count / 100];
    free(sorted);
    _window = fmax(high - low, 1e-3);
    _level = 0.5 * (low + high);
    return self;
}

- (void)dealloc {
    free(_values);
    DRR_SUPER_DEALLOC;
}

+ (NSString *)extension {
#if defined(DRR_IMAGE_IO)
    return @"png";
#else
    return @"pgm";
#endif
}

- (NSData *)pixels {
    NSMutableData *const data = [NSMutableData dataWithLength:2 * _views * _width * _height];
    unsigned char *to = [data mutableBytes];
    for (NSUInteger j = _height; j-- > 0;)
        for (NSUInteger view = 0; view < _views; view++)
            for (NSUInteger i = 0; i < _width; i++) {
                const double value = _values[(view * _height + j) * _width + i];
                const double grey = fmin(fmax((value - _level) / _window + 0.5, 0), 1);
                const unsigned level = (unsigned)lrint(65535 * grey);
                *to++ = (unsigned char)(level >> 8);
                *to++ = (unsigned char)(level & 255);
            }
    return data;
}

#if defined(DRR_IMAGE_IO)
- (NSData *)file {
    NSMutableData *const file = [NSMutableData data];
    const size_t columns = _views * _width;
    CGColorSpaceRef space = CGColorSpaceCreateWithName(kCGColorSpaceGenericGrayGamma2_2);
#if defined(DRR_ARC)
    CGDataProviderRef provider = CGDataProviderCreateWithCFData((__bridge CFDataRef)[self pixels]);
    CFMutableDataRef const target = (__bridge CFMutableDataRef)file;
#else
    CGDataProviderRef provider = CGDataProviderCreateWithCFData((CFDataRef)[self pixels]);
    CFMutableDataRef const target = (CFMutableDataRef)file;
#endif
    CGImageRef image = CGImageCreate(columns, _height, 16, 16, 2 * columns, space,
                                     (CGBitmapInfo)kCGImageAlphaNone | kCGBitmapByteOrder16Big, provider, NULL, false,
                                     kCGRenderingIntentDefault);
    CGImageDestinationRef destination = CGImageDestinationCreateWithData(target, CFSTR("public.png"), 1, NULL);
    BOOL done = NO;
    if (image != NULL && destination != NULL) {
        CGImageDestinationAddImage(destination, image, NULL);
        done = CGImageDestinationFinalize(destination);
    }
    if (destination != NULL) CFRelease(destination);
    CGImageRelease(image);
    CGDataProviderRelease(provider);
    CGColorSpaceRelease(space);
    return done ? file : nil;
}
#else
- (NSData *)file {
    NSString *const header = [NSString stringWithFormat:@"P5\n%lu %lu\n65535\n", (unsigned long)(_views * _width),
                                                        (unsigned long)_height];
    NSMutableData *const file = [NSMutableData dataWithData:[header dataUsingEncoding:NSASCIIStringEncoding]];
    [file appendData:[self pixels]];
    return file;
}
#endif

- (BOOL)writeTo:(NSString *)path error:(NSError **)error {
    NSData *const file = [self file];
    NSError *reason = nil;
    if (file != nil && [file writeToFile:path options:NSDataWritingAtomic error:&reason]) return YES;
    NSString *const why = reason == nil ? @"no picture could be made" : [reason localizedDescription];
    return DRRFail(DRRErrorFile, [NSString stringWithFormat:@"%@: %@", path, why], error);
}

@end
