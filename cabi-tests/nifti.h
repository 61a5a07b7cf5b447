/* A CT as a file, for programs that load one: NIfTI-1, int16 HU, whose affine map is a volume descriptor's. */
#ifndef NIFTI_H
#define NIFTI_H

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "check.h"

enum { NIFTI_HEADER = 348, NIFTI_VOXELS = 352 };

/* A path of this process's own. */
static inline const char *nifti_path(void) {
    static char path[512];
    const char *folder = getenv("TMPDIR");
    snprintf(path, sizeof path, "%s/drr-%ld.nii", folder == NULL ? "/tmp" : folder, (long)getpid());
    return path;
}

/* 0 when all of it was written. `bytes` of the voxels are: fewer than there are make a damaged file. */
static inline int write_nifti(const char *path, const DrrVolumeDescriptor *descriptor, const int16_t *hu, size_t bytes) {
    static unsigned char header[NIFTI_VOXELS];
    const int32_t size = NIFTI_HEADER;
    int16_t dimensions[8] = {3, 1, 1, 1, 1, 1, 1, 1};
    const int16_t type[2] = {4, 16}, affine_is_stated = 1;
    const float spacing[8] = {1.0f, 1.0f, 1.0f, 1.0f}, first_voxel = NIFTI_VOXELS;
    memset(header, 0, sizeof header);
    for (int axis = 0; axis < 3; axis++) dimensions[1 + axis] = (int16_t)descriptor->dimensions[axis];
    memcpy(header, &size, sizeof size);
    memcpy(header + 40, dimensions, sizeof dimensions);
    memcpy(header + 70, type, sizeof type);
    memcpy(header + 76, spacing, sizeof spacing);
    memcpy(header + 108, &first_voxel, sizeof first_voxel);
    memcpy(header + 254, &affine_is_stated, sizeof affine_is_stated);
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 4; column++) {
            /* The world of NIfTI is RAS: x and y point the other way. */
            const float sign = row < 2 ? -1.0f : 1.0f;
            const float entry = sign * (float)descriptor->index_to_world[4 * column + row];
            memcpy(header + 280 + 16 * row + 4 * column, &entry, sizeof entry);
        }
    }
    memcpy(header + 344, "n+1", 4);
    FILE *file = fopen(path, "wb");
    if (file == NULL) return 1;
    const int written = fwrite(header, sizeof header, 1, file) == 1 && fwrite(hu, 1, bytes, file) == bytes;
    return !(fclose(file) == 0 && written);
}

#endif
