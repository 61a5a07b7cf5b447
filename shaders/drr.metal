// The entry points for Metal. Texture and buffer indices 0 to 2 are the specification's.
#include "DRR_Shared.h"
#include "pixel.h"
#include "tables.h"

// Where the intensity is written to as well, chosen by DRR_IMAGE_TEXTURE:
#define DRR_IMAGE_OF_ONE_VIEW 1
#define DRR_IMAGE_OF_ALL_VIEWS 2
#if defined(DRR_IMAGE_TEXTURE) && DRR_IMAGE_TEXTURE == DRR_IMAGE_OF_ONE_VIEW
typedef metal::texture2d<float, metal::access::write> DrrDetectorImage;
#elif defined(DRR_IMAGE_TEXTURE)
typedef metal::texture2d_array<float, metal::access::write> DrrDetectorImage;
#endif

// One thread for every pixel (x, y) of every view (z).
kernel void projectPolyenergeticDRR(
#if DRR_VOXELS == DRR_VOXELS_TEXTURE
    metal::texture3d<short, metal::access::read> ctVolume [[texture(0)]], const device ushort *codeOfHu [[buffer(5)]],
#elif DRR_VOXELS == DRR_VOXELS_DENSE
    const device float *density [[buffer(5)]], const device uchar *label [[buffer(6)]],
#else
    const device ushort *code [[buffer(5)]],
#endif
#if DRR_VOXELS != DRR_VOXELS_TEXTURE
    const device uchar *occupied [[buffer(12)]],
#endif
#if DRR_DENSITY == DRR_DENSITY_TABLE
    const device float *densityOfValue [[buffer(7)]],
#endif
#if defined(DRR_IMAGE_TEXTURE)
    DrrDetectorImage detectorImage [[texture(1)]],
#endif
#if defined(DRR_INTENSITY)
    device float *intensity [[buffer(8)]],
#endif
#if defined(DRR_LINE_INTEGRAL)
    device float *lineIntegral [[buffer(9)]],
#endif
#if defined(DRR_AREAL_DENSITY)
    device float *arealDensity [[buffer(10)]],
#endif
#if defined(DRR_BONE_PATH)
    device float *bonePath [[buffer(11)]],
#endif
#if defined(DRR_SIGNALS)
    constant DrrChannels &channels [[buffer(13)]], device float *passing [[buffer(15)]],
#endif
#if DRR_BEFORE != 0
    const device float *before [[buffer(14)]],
#endif
#if defined(DRR_OPEN)
    device float *open [[buffer(16)]],
#endif
    const device float *spectrumLut [[buffer(1)]], const device float *muLut [[buffer(2)]],
    constant DrrLaunch &launch [[buffer(3)]], constant DrrBeam *beams [[buffer(4)]],
    uint3 at [[thread_position_in_grid]]) {
    const DrrVoxels voxels = {
#if DRR_VOXELS == DRR_VOXELS_TEXTURE
        ctVolume, codeOfHu,
#elif DRR_VOXELS == DRR_VOXELS_DENSE
        density, label, occupied,
#else
        code, occupied,
#endif
#if DRR_DENSITY == DRR_DENSITY_TABLE
        densityOfValue,
#endif
    };
    const DrrSpectra spectra = {spectrumLut, muLut};
    DrrImages images = {};
#if defined(DRR_INTENSITY)
    images.intensity = intensity;
#endif
#if defined(DRR_LINE_INTEGRAL)
    images.line_integral = lineIntegral;
#endif
#if defined(DRR_AREAL_DENSITY)
    images.areal_density = arealDensity;
#endif
#if defined(DRR_BONE_PATH)
    images.bone_path = bonePath;
#endif
#if defined(DRR_SIGNALS)
    DrrSignals signals = {};
    signals.passing = passing;
#if DRR_BEFORE != 0
    signals.before = before;
#endif
#if defined(DRR_OPEN)
    signals.open = open;
#endif
    drr_pixel(launch, beams[at.z], voxels, spectra, channels, signals, images, at.x, at.y, at.z);
#else
    drr_pixel(launch, beams[at.z], voxels, spectra, images, at.x, at.y, at.z);
#endif
#if defined(DRR_IMAGE_TEXTURE)
    const float4 value = float4(intensity[(at.z * launch.height + at.y) * launch.width + at.x]);
#if DRR_IMAGE_TEXTURE == DRR_IMAGE_OF_ONE_VIEW
    detectorImage.write(value, uint2(at.x, at.y));
#else
    detectorImage.write(value, uint2(at.x, at.y), at.z);
#endif
#endif
}

// ProjectionUniforms, byte for byte, as the argument buffer that it is: GPU virtual addresses are pointers.
struct DrrViewTables {
    DrrFloat4x4 modelViewProjectionMatrix;
    DrrFloat3 sourcePosition;
    const device float *spectrumLut;
    const device float *muLut;
    bool enableEarlyExit;
    float _padding;
};
static_assert(sizeof(DrrViewTables) == sizeof(ProjectionUniforms), "the same bytes");
static_assert(__builtin_offsetof(DrrViewTables, spectrumLut) == 80, "spectrumLutAddress");
static_assert(__builtin_offsetof(DrrViewTables, muLut) == 88, "muLutAddress");

// One thread for every view. Runs before projectPolyenergeticDRR when some view has LUT addresses, so that the projection
// itself need not ask.
kernel void prepareViewTables(constant DrrViewTables *uniforms [[buffer(0)]], device float *spectrumLut [[buffer(1)]],
                              device float *muLut [[buffer(2)]], device DrrBeam *beams [[buffer(4)]],
                              uint view [[thread_position_in_grid]]) {
    const device float *const weight = uniforms[view].spectrumLut;
    const device float *const attenuation = uniforms[view].muLut;
    if (!weight && !attenuation) return;
    drr_prepare_tables(beams[view], spectrumLut, muLut, weight, attenuation, DRR_MATERIALS);
}
