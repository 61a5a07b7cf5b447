// A CT: owns a DrrVolume.
#import <Foundation/Foundation.h>

#import "DRR_Shared.h"

@class DRREngine, DRRPhantom;

@interface DRRScan : NSObject {
  @private
    DrrVolume *_volume;
    DrrVolumeDescriptor _descriptor;
}

// Valid as long as the scan.
@property (nonatomic, readonly) const DrrVolume *volume;
// "232 x 160 x 220 voxels".
@property (nonatomic, readonly) NSString *size;

// Takes over `volume`, which the scan destroys. Of the descriptor dimensions and index_to_world are kept.
- (instancetype)initWithVolume:(DrrVolume *)volume descriptor:(const DrrVolumeDescriptor *)descriptor;
// Reads a CT as drr_volume_load does. nil with an error that names the file.
- (instancetype)initWithPath:(NSString *)path engine:(DRREngine *)engine error:(NSError **)error;
- (instancetype)initWithPhantom:(DRRPhantom *)phantom engine:(DRREngine *)engine error:(NSError **)error;

// The middle of the volume, world mm.
- (void)getCentre:(double *)centre;

@end
