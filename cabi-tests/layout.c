/* The structs are, byte for byte, what the library's side of the boundary reads. Where each field is: abi.txt. */
#include <string.h>

#include "check.h"

int main(void) {
    /* The stride of an array is what the library assumes: 16-byte alignment in every element. */
    ProjectionUniforms views[2];
    CHECK((uintptr_t)&views[1] - (uintptr_t)&views[0] == 112 && (uintptr_t)&views[1] % 16 == 0);

    /* The library refuses a struct of another size than its own: that these are accepted says that they agree. */
    DrrContextOptions options;
    DrrVolumeDescriptor descriptor;
    DrrScene scene;
    DrrOutputs outputs;
    DrrReferenceOutputs reference;
    DrrParallelGeometry geometry;
    OK(drr_context_options_init(&options));
    OK(drr_volume_descriptor_init(&descriptor));
    OK(drr_scene_init(&scene));
    OK(drr_outputs_init(&outputs));
    OK(drr_reference_outputs_init(&reference));
    OK(drr_parallel_geometry_init(&geometry));
    CHECK(options.struct_size == sizeof options && scene.struct_size == sizeof scene);

    /* Fields at the end of each struct carry their defaults: nothing is shifted. */
    CHECK(options.backend == DRR_BACKEND_AUTO && options.thread_count == 0);
    CHECK(descriptor.index_to_world[0] == 1.0 && descriptor.index_to_world[15] == 1.0);
    CHECK(descriptor.thresholds == DRR_THRESHOLDS_FOUR_CLASS);
    CHECK(scene.detector_width == 0 && scene.spectrum == NULL && scene.mass_attenuation == NULL);
    CHECK(scene.material_count == 4 && scene.energy_count == 136);
    CHECK(scene.first_energy_kev == 15.0 && scene.energy_step_kev == 1.0 && scene.mono_energy_kev == 70.0);
    CHECK(scene.step_voxels == 0.5 && scene.effects == DRR_EFFECT_POLYENERGETIC);
    CHECK(scene.algorithm == DRR_ALGORITHM_JOSEPH && scene.supersampling == 1 && scene.bone_material == 3);
    CHECK(scene.expected_pose_count == 0 && scene.detector_efficiency == NULL);
    CHECK(scene.second_detector_response == NULL && scene.second_detector_efficiency == NULL);
    CHECK(scene.filters == NULL && scene.filter_count == 0 && scene.implants == NULL && scene.implant_count == 0);
    CHECK(scene.blur == NULL && scene.blur_count == 0 && scene.mtf == NULL && scene.mtf_count == 0);
    CHECK(scene.mtf_frequencies_per_mm == NULL && scene.heel_target_angle_degrees == 12.0);
    CHECK(scene.heel_depth_mm == 0.005 && scene.heel_cathode_degrees == 0.0);
    CHECK(scene.focal_spot_width_mm == 0.0 && scene.focal_spot_height_mm == 0.0 && scene.fill_factor == 1.0);
    CHECK(scene.photons_per_pixel == 0.0 && scene.electronic_noise_photons == 0.0 && scene.noise_seed == 0);
    CHECK(scene.scatter_photons == 40000 && scene.scatter_seed == 0);
    CHECK(geometry.struct_size == sizeof geometry && geometry.spacing[2] == 1.0 && geometry.centre[2] == 0.0);
    CHECK(geometry.pixel[1] == 1.0 && geometry.detector_centre[1] == 0.0 && geometry.step == 0.0);
    CHECK(geometry.steps == 0 && geometry.quadrature == DRR_PARALLEL_STEPS);
    CHECK(outputs.bone_path_mm == NULL && reference.bone_path_mm == NULL);

    /* Column-major: the translation is the last column. The source goes to (0, 0, *, 0). */
    const double centre[3] = {10.0, 20.0, 30.0};
    DrrDetectorPose pose;
    ProjectionUniforms view;
    OK(drr_pose_c_arm(centre, 0.0, 1000.0, 1500.0, 0.5, 7, 5, &pose));
    OK(drr_uniforms_cone(&pose, 7, 5, &view));
    CHECK(view.sourcePosition.x == 10.0f && view.sourcePosition.y == -980.0f && view.sourcePosition.z == 30.0f);
    float matrix[4][4];
    memcpy(matrix, &view.modelViewProjectionMatrix, sizeof matrix);
    const double w = 10.0 * matrix[0][3] - 980.0 * matrix[1][3] + 30.0 * matrix[2][3] + matrix[3][3];
    CHECK(w > -1e-5 && w < 1e-5 && matrix[1][3] > 0.0f);
    CHECK(view.spectrumLutAddress == 0 && view.muLutAddress == 0 && !view.enableEarlyExit);
    printf("PASS\n");
    return 0;
}
