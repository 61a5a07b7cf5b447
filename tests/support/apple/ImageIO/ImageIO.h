// Stand-in, see ../README.md. With Core Graphics, which ImageIO includes.
#pragma once
#import <Foundation/Foundation.h>

typedef struct CGColorSpace *CGColorSpaceRef;
typedef struct CGDataProvider *CGDataProviderRef;
typedef struct CGImage *CGImageRef;
typedef struct CGImageDestination *CGImageDestinationRef;
typedef NS_ENUM(uint32_t, CGImageAlphaInfo) { kCGImageAlphaNone };
typedef NS_OPTIONS(uint32_t, CGBitmapInfo) { kCGBitmapByteOrder16Big = 3 << 12 };
typedef NS_ENUM(int32_t, CGColorRenderingIntent) { kCGRenderingIntentDefault };
extern const CFStringRef kCGColorSpaceGenericGrayGamma2_2;
CGColorSpaceRef CGColorSpaceCreateWithName(CFStringRef name);
void CGColorSpaceRelease(CGColorSpaceRef space);
CGDataProviderRef CGDataProviderCreateWithCFData(CFDataRef data);
void CGDataProviderRelease(CGDataProviderRef provider);
CGImageRef CGImageCreate(size_t width, size_t height, size_t bitsPerComponent, size_t bitsPerPixel, size_t bytesPerRow,
                         CGColorSpaceRef space, CGBitmapInfo bitmapInfo, CGDataProviderRef provider,
                         const CGFloat *decode, bool shouldInterpolate, CGColorRenderingIntent intent);
void CGImageRelease(CGImageRef image);
CGImageDestinationRef CGImageDestinationCreateWithData(CFMutableDataRef data, CFStringRef type, size_t count,
                                                       CFDictionaryRef options);
void CGImageDestinationAddImage(CGImageDestinationRef destination, CGImageRef image, CFDictionaryRef properties);
bool CGImageDestinationFinalize(CGImageDestinationRef destination);
