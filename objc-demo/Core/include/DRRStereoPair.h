// The two views of a scan: casts rays when it must, develops what they met when that is enough.
#import <Foundation/Foundation.h>

#import "DRRShot.h"

@class DRRScan;

@interface DRRStereoPair : NSObject {
  @private
    DRRScan *_scan;
    DRRShot *_cast;
    DrrExposure *_exposure;
    NSTimeInterval _castSeconds, _developSeconds;
}

// Of the last shot: planning and casting its rays, 0 where an earlier shot's were used again; making images of them.
@property (nonatomic, readonly) NSTimeInterval castSeconds;
@property (nonatomic, readonly) NSTimeInterval developSeconds;

- (instancetype)initWithScan:(DRRScan *)scan;

// Writes the intensities: pixel (i, j), i = column, of view v is at (v x size + j) x size + i; the last row is the patient's
// head. A ray that meets nothing has intensity 1. A new angle, size or focal spot casts new rays; a new voltage and all other
// effects are developed from the old ones. On failure `intensity` is as before. One thread at a time.
- (BOOL)take:(DRRShot *)shot into:(float *)intensity error:(NSError **)error;
// The next shot casts its rays, whatever is known of them.
- (void)forget;

@end
