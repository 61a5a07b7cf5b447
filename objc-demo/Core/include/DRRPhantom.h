// A thorax of ellipsoids in HU, for machines without a CT. The median plane x = 0 mirrors it, so that the views at -a and +a
// are mirror images.
#import <Foundation/Foundation.h>

#import "DRR_Shared.h"

@interface DRRPhantom : NSObject {
  @private
    DrrVolumeDescriptor _descriptor;
    int16_t *_hu;
}

// Voxel (i, j, k) is at (k x dimensions[1] + j) x dimensions[0] + i of `hu`. Both are valid as long as the phantom.
@property (nonatomic, readonly) const DrrVolumeDescriptor *descriptor;
@property (nonatomic, readonly) const int16_t *hu;

// 360 x 240 x 330 mm in voxels of `spacing` mm, 0.4 to 10. nil for another spacing, or without memory.
- (instancetype)initWithSpacing:(double)spacing;
// The specification's volume: 720 x 720 x 665 voxels of 0.5 mm, 690 MB.
- (instancetype)initOfTargetCase;

@end
