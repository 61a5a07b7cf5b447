// Intensities as a picture: grey by window and level of -ln(intensity), bone white, the views side by side, heads up.
#import <Foundation/Foundation.h>

@interface DRRPicture : NSObject {
  @private
    float *_values;
    NSUInteger _views, _width, _height;
    double _window, _level;
}

// Of -ln(intensity), which is dimensionless: `level` is middle grey, `level` -+ `window` / 2 are black and white. They show what
// lies between the lowest and the highest hundredth.
@property (nonatomic, readonly) double window;
@property (nonatomic, readonly) double level;

// PNG by ImageIO where that is there, else PGM; 16 bits per pixel in either.
+ (NSString *)extension;

// Copies the intensities: pixel (i, j) of view v is at (v x height + j) x width + i. nil without memory.
- (instancetype)initWithIntensity:(const float *)intensity views:(NSUInteger)views width:(NSUInteger)width height:(NSUInteger)height;

// 16 bits per pixel, big-endian, views x width columns.
- (NSData *)pixels;
- (BOOL)writeTo:(NSString *)path error:(NSError **)error;

@end
