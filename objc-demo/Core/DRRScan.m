#import "DRRScan.h"

#import "DRREngine.h"
#import "DRRFailure.h"
#import "DRRMemory.h"
#import "DRRPhantom.h"

@implementation DRRScan

- (const DrrVolume *)volume {
    return _volume;
}

- (instancetype)initWithVolume:(DrrVolume *)volume descriptor:(const DrrVolumeDescriptor *)descriptor {
    if ((self = [super init]) != nil) {
        _volume = volume;
        _descriptor = *descriptor;
    }
    return self;
}

- (instancetype)initWithPath:(NSString *)path engine:(DRREngine *)engine error:(NSError **)error {
    DrrVolumeDescriptor descriptor;
    drr_volume_descriptor_init(&descriptor);
    DrrVolume *volume = NULL;
    if (DRRSucceeds(drr_volume_load(engine.context, [path fileSystemRepresentation], &descriptor, &volume), error))
        return [self initWithVolume:volume descriptor:&descriptor];
    DRR_RELEASE(self);
    return nil;
}

- (instancetype)initWithPhantom:(DRRPhantom *)phantom engine:(DRREngine *)engine error:(NSError **)error {
    DrrVolume *volume = NULL;
    const DrrStatus status = drr_volume_create(engine.context, phantom.descriptor, phantom.hu, NULL, &volume);
    if (DRRSucceeds(status, error)) return [self initWithVolume:volume descriptor:phantom.descriptor];
    DRR_RELEASE(self);
    return nil;
}

- (void)dealloc {
    drr_volume_destroy(_volume);
    DRR_SUPER_DEALLOC;
}

- (NSString *)size {
    const size_t *const n = _descriptor.dimensions;
    return [NSString stringWithFormat:@"%zu x %zu x %zu voxels", n[0], n[1], n[2]];
}

- (void)getCentre:(double *)centre {
    const double *const map = _descriptor.index_to_world;
    for (int row = 0; row < 3; row++) {
        centre[row] = map[12 + row];
        for (int axis = 0; axis < 3; axis++)
            centre[row] += 0.5 * (double)(_descriptor.dimensions[axis] - 1) * map[4 * axis + row];
    }
}

@end
