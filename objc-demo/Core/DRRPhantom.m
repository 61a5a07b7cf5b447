#import "DRRPhantom.h"

#include <math.h>
#include <stdlib.h>

#import "DRRMemory.h"

// An ellipsoid with semi-axes along x, y, z, mm.
typedef struct {
    double centre[3], semi_axes[3];
    int16_t hu;
} Ellipsoid;

// In painter's order. Those off the median plane come in pairs.
static const Ellipsoid organs[] = {
    {{0, 0, 0}, {165, 110, 400}, -90},      // fat
    {{0, 0, 0}, {150, 97, 400}, 45},        // muscle
    {{75, -2, 15}, {55, 72, 135}, -830},    // lungs
    {{-75, -2, 15}, {55, 72, 135}, -830},   //
    {{0, -28, -25}, {48, 42, 62}, 48},      // heart, in the middle
    {{0, 0, -165}, {138, 85, 55}, 60},      // what lies below the diaphragm
    {{0, -92, 20}, {18, 5, 90}, 380},       // sternum
};

enum { ORGANS = sizeof organs / sizeof *organs, RIBS = 11, BEADS = 36, VERTEBRAE = 12 };

@implementation DRRPhantom

- (const DrrVolumeDescriptor *)descriptor {
    return &_descriptor;
}

- (const int16_t *)hu {
    return _hu;
}

// Voxels take the value at their centre. Their places are symmetric about 0 to the bit, so that mirrored ellipsoids are mirrored
// to the voxel.
- (void)paint:(Ellipsoid)ellipsoid {
    size_t first[3], end[3];
    const size_t *const n = _descriptor.dimensions;
    const double spacing = _descriptor.index_to_world[0];
    for (int axis = 0; axis < 3; axis++) {
        const double middle = 0.5 * (double)(n[axis] - 1) + ellipsoid.centre[axis] / spacing;
        const double half = ellipsoid.semi_axes[axis] / spacing;
        first[axis] = (size_t)fmin(fmax(floor(middle - half), 0), (double)n[axis]);
        end[axis] = (size_t)fmin(fmax(ceil(middle + half) + 1, 0), (double)n[axis]);
    }
    for (size_t k = first[2]; k < end[2]; k++)
        for (size_t j = first[1]; j < end[1]; j++)
            for (size_t i = first[0]; i < end[0]; i++) {
                const size_t at[3] = {i, j, k};
                double sum = 0;
                for (int axis = 0; axis < 3; axis++) {
                    const double place = spacing * ((double)at[axis] - 0.5 * (double)(n[axis] - 1));
                    const double part = (place - ellipsoid.centre[axis]) / ellipsoid.semi_axes[axis];
                    sum += part * part;
                }
                if (sum < 1) _hu[(k * n[1] + j) * n[0] + i] = ellipsoid.hu;
            }
}

// Vertebrae with their canal, and ribs as beads on tilted half-ellipses, open at the front below the sternum.
- (void)paintBones {
    for (int n = 0; n < VERTEBRAE; n++) {
        const double z = 27.0 * (n - 5.5);
        [self paint:(Ellipsoid){{0, 70, z}, {19, 16, 12}, 320}];
        [self paint:(Ellipsoid){{0, 96, z - 5}, {5, 10, 9}, 420}];
    }
    for (int n = 0; n < RIBS * BEADS; n++) {
        const double rib = n / BEADS, angle = M_PI * ((n % BEADS + 0.5) / BEADS - 0.5);
        const double x = 141 * cos(angle), y = 90 * sin(angle), z = 135 - 27 * rib + 0.25 * y;
        if (y < -80 && rib > 6) continue;
        [self paint:(Ellipsoid){{x, y, z}, {7, 5, 6}, 620}];
        [self paint:(Ellipsoid){{-x, y, z}, {7, 5, 6}, 620}];
    }
}

- (instancetype)initWithDimensions:(const size_t *)dimensions spacing:(double)spacing {
    if ((self = [super init]) == nil) return nil;
    drr_volume_descriptor_init(&_descriptor);
    size_t count = 1;
    for (int axis = 0; axis < 3; axis++) {
        count *= dimensions[axis];
        _descriptor.dimensions[axis] = dimensions[axis];
        _descriptor.index_to_world[5 * axis] = spacing;
        _descriptor.index_to_world[12 + axis] = -0.5 * spacing * (double)(dimensions[axis] - 1);
    }
    _hu = malloc(count * sizeof *_hu);
    if (_hu == NULL) {
        DRR_RELEASE(self);
        return nil;
    }
    for (size_t i = 0; i < count; i++) _hu[i] = -1000;
    for (int n = 0; n < ORGANS; n++) [self paint:organs[n]];
    [self paintBones];
    return self;
}

- (instancetype)initWithSpacing:(double)spacing {
    const size_t dimensions[3] = {(size_t)lround(360 / spacing), (size_t)lround(240 / spacing), (size_t)lround(330 / spacing)};
    if (spacing >= 0.4 && spacing <= 10) return [self initWithDimensions:dimensions spacing:spacing];
    DRR_RELEASE(self);
    return nil;
}

- (instancetype)initOfTargetCase {
    const size_t dimensions[3] = {720, 720, 665};
    return [self initWithDimensions:dimensions spacing:0.5];
}

- (void)dealloc {
    free(_hu);
    DRR_SUPER_DEALLOC;
}

@end
