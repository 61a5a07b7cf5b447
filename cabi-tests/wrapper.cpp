// drr.hpp: the same bytes as the calls of C; owners move, and outlive one another in any order; failures are exceptions.
//
//   c++ -std=c++17 -Iinclude wrapper.cpp -ldrr
#include "drr.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "nifti.h"
#include "water.h"

namespace {

void expect(bool condition, const char *what, int line) {
    if (condition) return;
    std::printf("FAIL line %d: %s\n", line, what);
    std::exit(1);
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)

template <class T>
bool same(const std::vector<T> &a, const std::vector<T> &b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// What the call threw: its status, and a message with that text.
template <class Call>
bool refused(Call call, DrrStatus status, const char *text) {
    try {
        call();
    } catch (const drr::Error &error) {
        if (error.status() == status && std::strstr(error.what(), text) != nullptr) return true;
        std::printf("%s: %s\n", drr::status_name(error.status()), error.what());
    }
    return false;
}

template <class T>
constexpr bool is_an_owner = std::is_nothrow_move_constructible_v<T> && std::is_nothrow_move_assignable_v<T> &&
                             !std::is_copy_constructible_v<T> && !std::is_copy_assignable_v<T>;
static_assert(is_an_owner<drr::Context> && is_an_owner<drr::Volume> && is_an_owner<drr::Projector>);
static_assert(is_an_owner<drr::Exposure> && is_an_owner<drr::Raycast> && is_an_owner<drr::Parallel>);
static_assert(is_an_owner<drr::ParallelF64> && is_an_owner<drr::RayTransform> && is_an_owner<drr::RayTransformF64>);
static_assert(is_an_owner<drr::PoseGradient> && is_an_owner<drr::PoseGradientF64>);
static_assert(sizeof(drr::Projector) == sizeof(DrrProjector *), "an owner is a pointer");

drr::Context cpu() {
    auto options = drr::defaults<DrrContextOptions>();
    options.backend = DRR_BACKEND_CPU;
    return drr::Context(options);
}

drr::Volume water(const drr::Context &context) {
    return {context, water_descriptor(), drr::Span<const std::int16_t>(water_ball(), N * N * N)};
}

const std::vector<DrrDetectorPose> poses = {water_pose(-6.0), water_pose(6.0)};

/// The water's line integrals by calls of C.
std::vector<float> by_c() {
    std::vector<float> image(2 * PIXELS);
    DrrContext *context = nullptr;
    DrrVolume *volume = nullptr;
    DrrProjector *projector = nullptr;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    const DrrScene scene = water_scene();
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = image.data();
    EXPECT(create_cpu_context(&context) == DRR_STATUS_OK);
    EXPECT(drr_volume_create(context, &descriptor, water_ball(), nullptr, &volume) == DRR_STATUS_OK);
    EXPECT(drr_projector_create(volume, &scene, &projector) == DRR_STATUS_OK);
    EXPECT(drr_projector_project_poses(projector, poses.data(), 2, &outputs) == DRR_STATUS_OK);
    drr_projector_destroy(projector);
    drr_volume_destroy(volume);
    drr_context_destroy(context);
    return image;
}

std::vector<float> line_integrals(const drr::Projector &projector) {
    std::vector<float> image(2 * PIXELS);
    auto outputs = drr::defaults<DrrOutputs>();
    outputs.line_integral = image.data();
    projector.project_poses(poses, outputs);
    return image;
}

void projections() {
    const auto expected = by_c();
    EXPECT(expected[PIXELS / 2 + WIDTH / 2] > 0.1f);

    // Parents end before their children, and a child before its parent.
    std::optional<drr::Context> context(cpu());
    EXPECT(context->backend() == DRR_BACKEND_CPU && std::strcmp(context->device_name(), "") == 0);
    std::optional<drr::Volume> volume(water(*context));
    context.reset();
    drr::Projector projector(*volume, water_scene());
    volume.reset();
    EXPECT(same(line_integrals(projector), expected));
    EXPECT(std::strstr(projector.describe(), "joseph") != nullptr);

    // Moved, to a new owner and to one that has a handle, which is destroyed.
    const DrrProjector *handle = projector.get();
    drr::Projector moved(std::move(projector));
    EXPECT(moved.get() == handle && projector.get() == nullptr);
    drr::Projector other(water(cpu()), water_scene());
    other = std::move(moved);
    EXPECT(other.get() == handle && moved.get() == nullptr && same(line_integrals(other), expected));

    // Views by matrices, float64, exposures.
    const std::array<ProjectionUniforms, 2> views = {drr::uniforms_cone(poses[0], WIDTH, HEIGHT),
                                                     drr::uniforms_cone(poses[1], WIDTH, HEIGHT)};
    std::vector<float> image(2 * PIXELS), developed(2 * PIXELS), hard(2 * PIXELS);
    std::vector<double> exact(2 * PIXELS);
    auto outputs = drr::defaults<DrrOutputs>();
    outputs.line_integral = image.data();
    other.project(views, outputs);
    auto reference = drr::defaults<DrrReferenceOutputs>();
    reference.line_integral = exact.data();
    other.reference_project(DRR_ALGORITHM_JOSEPH, poses, reference);
    double furthest = 0.0;
    for (std::size_t i = 0; i < image.size(); i++) furthest = std::fmax(furthest, std::fabs(image[i] - exact[i]));
    EXPECT(furthest > 0.0 && furthest < 1e-5);
    EXPECT(other.certify(poses).rounding_rmse_hu < 0.1);

    DrrExposure *kept = nullptr;
    outputs.line_integral = image.data();
    EXPECT(drr_exposure_create_poses(other.get(), poses.data(), 2, nullptr, nullptr, &kept) == DRR_STATUS_OK);
    EXPECT(drr_exposure_develop(kept, nullptr, &outputs) == DRR_STATUS_OK);
    drr_exposure_destroy(kept);
    const drr::Exposure exposure(other, poses);
    outputs.line_integral = developed.data();
    exposure.develop(outputs);
    EXPECT(same(developed, image));
    std::vector<float> spectrum(136);
    drr::physics_spectrum("W60_2p5Al", spectrum);
    auto soft = water_scene();
    soft.spectrum = spectrum.data();
    outputs.line_integral = hard.data();
    exposure.develop(soft, outputs);
    EXPECT(hard[PIXELS / 2 + WIDTH / 2] > expected[PIXELS / 2 + WIDTH / 2]);
    outputs.line_integral = developed.data();
    drr::Exposure(other, views).develop(outputs);
    EXPECT(!same(developed, hard) && std::fabs(developed[PIXELS / 2] - image[PIXELS / 2]) < 1e-4f);
}

/// A CT that is a file is where the file says. Builds without readers of files refuse it.
void files() {
    const auto context = cpu();
    const char *path = nifti_path();
    const auto water_is = water_descriptor();
    EXPECT(write_nifti(path, &water_is, water_ball(), sizeof(std::int16_t) * N * N * N) == 0);
    auto descriptor = drr::defaults<DrrVolumeDescriptor>();
    try {
        const drr::Projector projector(drr::Volume::load(context, path, descriptor), water_scene());
        EXPECT(std::memcmp(&descriptor, &water_is, sizeof descriptor) == 0);
        EXPECT(same(line_integrals(projector), by_c()));
    } catch (const drr::Error &error) {
        EXPECT(error.status() == DRR_STATUS_UNSUPPORTED && descriptor.dimensions[0] == 0);
    }
    std::remove(path);
}

void errors() {
    const auto context = cpu();
    auto descriptor = water_descriptor();
    const std::vector<std::int16_t> few(7);
    EXPECT(refused([&] { drr::Volume(context, descriptor, few); }, DRR_STATUS_INVALID_ARGUMENT, "hu has 7 elements"));
    const drr::Span<const std::int16_t> hu(water_ball(), N * N * N);
    EXPECT(refused([&] { drr::Volume(context, descriptor, hu, std::vector<std::uint8_t>(3)); },
                   DRR_STATUS_INVALID_ARGUMENT, "labels has 3"));
    descriptor.thresholds = 77;
    EXPECT(refused([&] { drr::Volume(context, descriptor, hu); }, DRR_STATUS_INVALID_ARGUMENT, "descriptor.thresholds"));
    EXPECT(refused([&] { drr::Volume::of_metal_texture(context, water_descriptor(), &descriptor); },
                   DRR_STATUS_UNSUPPORTED, ""));
    EXPECT(refused([] { drr::pose_c_arm({0.0, 0.0, 0.0}, std::nan(""), 1.0, 2.0, 1.0, 1, 1); },
                   DRR_STATUS_INVALID_ARGUMENT, "angle_degrees"));
    auto scene = water_scene();
    EXPECT(refused([&] { drr::scene_set_preset(scene, "best"); }, DRR_STATUS_INVALID_ARGUMENT, "best"));
    drr::scene_set_preset(scene, "draft");
    EXPECT(scene.tolerance_hu == 10.0);

    const auto volume = water(context);
    const drr::Projector projector(volume, water_scene());
    EXPECT(refused([&] { projector.project_poses({}, drr::defaults<DrrOutputs>()); }, DRR_STATUS_INVALID_ARGUMENT, ""));
    auto there = drr::defaults<DrrDeviceOutputs>();
    there.intensity = &there;
    EXPECT(refused([&] { projector.encode_poses(poses, nullptr, there); }, DRR_STATUS_UNSUPPORTED, "queues"));
    // A moved-from owner has no handle.
    auto gone = water(context);
    const auto kept = std::move(gone);
    EXPECT(refused([&] { drr::Projector(gone, water_scene()); }, DRR_STATUS_INVALID_ARGUMENT, "volume is NULL"));
    EXPECT(kept.get() != nullptr);
    EXPECT(drr::version_number() == 10000 * DRR_VERSION_MAJOR + 100 * DRR_VERSION_MINOR + DRR_VERSION_PATCH);
}

/// `Handle` is the type of C, `create` and `call` are its functions.
template <class Real, class Handle, class Create, class Call>
void parallel(Create create, Call call, DrrStatus (*destroy)(Handle *)) {
    const auto context = cpu();
    auto geometry = drr::defaults<DrrParallelGeometry>();
    for (auto &dimension : geometry.dimensions) dimension = 8;
    geometry.detector_columns = 12;
    geometry.detector_rows = 10;
    std::vector<Real> volume(512), image(120), expected(120), back(512), jacobian(600);
    for (std::size_t i = 0; i < volume.size(); i++) volume[i] = static_cast<Real>(i % 7);
    const std::array<double, 5> still = {0.1, 0.05, -0.02, 0.5, -0.25};
    Handle *handle = nullptr;
    EXPECT(create(context.get(), &geometry, volume.data(), &handle) == DRR_STATUS_OK);
    EXPECT(call(handle, still.data(), nullptr, nullptr, expected.data()) == DRR_STATUS_OK);
    destroy(handle);

    const drr::BasicParallel<Real> projector(context, geometry, volume);
    projector.forward_project_view(still, image);
    EXPECT(same(image, expected) && expected[65] > Real(1));
    projector.batch_forward_project(drr::Span<const std::array<double, 5>>(&still, 1), image);
    EXPECT(same(image, expected));
    const auto loss = projector.view_loss_value_and_grad(still, std::vector<Real>(120));
    EXPECT(loss.value > 0.0 && loss.hessian[1] == loss.hessian[5]);
    projector.view_jacobian(still, jacobian, image);
    EXPECT(same(image, expected));
    projector.adjoint(drr::Span<const std::array<double, 5>>(&still, 1), image, back);
    double forward = 0.0, adjoint = 0.0;
    for (std::size_t i = 0; i < image.size(); i++) forward += double(image[i]) * double(image[i]);
    for (std::size_t i = 0; i < volume.size(); i++) adjoint += double(volume[i]) * double(back[i]);
    EXPECT(std::fabs(forward - adjoint) < 1e-5 * forward);
    std::vector<Real> small(119);
    EXPECT(refused([&] { projector.forward_project_view(still, small); }, DRR_STATUS_INVALID_ARGUMENT, "image has 119"));
    EXPECT(refused([&] { projector.forward_project_view(still, image, std::vector<std::uint8_t>(2)); },
                   DRR_STATUS_INVALID_ARGUMENT, "mask has 2"));
}

template <class Real>
void rays_and_poses() {
    const auto context = cpu();
    const drr::BasicRayTransform<Real> transform(context, water_descriptor(), poses, WIDTH, HEIGHT, DRR_ALGORITHM_SIDDON);
    std::vector<Real> ones(N * N * N, Real(1)), images(2 * PIXELS), back(N * N * N);
    transform.forward(ones, images);
    transform.adjoint(images, back);
    EXPECT(std::fabs(double(images[HEIGHT / 2 * WIDTH + WIDTH / 2]) - 32.0) < 0.3);
    EXPECT(refused([&] { transform.forward(images, images); }, DRR_STATUS_INVALID_ARGUMENT, "volume has 960"));

    auto scene = water_scene();
    scene.effects = DRR_EFFECT_POLYENERGETIC;
    const drr::BasicPoseGradient<Real> gradient(water(context), scene);
    const std::array<double, 6> still = {}, moved = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
    std::vector<Real> image(PIXELS), there(PIXELS), jacobian(6 * PIXELS);
    gradient.project(poses[0], moved, DRR_SIGNAL_LINE_INTEGRAL, there);
    gradient.jacobian(poses[0], still, DRR_SIGNAL_LINE_INTEGRAL, jacobian, image);
    EXPECT(!same(image, there));
    EXPECT(gradient.loss_value_and_grad(poses[0], still, DRR_SIGNAL_LINE_INTEGRAL, image).value < 1e-9);
    const auto loss = gradient.loss_value_and_grad(poses[0], still, DRR_SIGNAL_LINE_INTEGRAL, there);
    EXPECT(loss.value > 0.0 && loss.gradient[3] < 0.0);
    drr::BasicPoseGradient<Real>(water(context), scene, {1.0, 2.0, 3.0}).project(poses[0], still, DRR_SIGNAL_INTENSITY, there);
}

void rays_in_the_box() {
    const auto context = cpu();
    drr::Raycast raycast(water(context));
    auto camera = drr::defaults<DrrCamera>();
    camera.position[2] = 100.0;
    const auto samples = raycast.cast_camera(camera);
    EXPECT(samples[0].hit && samples[0].entry_mm == 84.0 && samples[0].exit_mm == 116.0);
    const DrrWorldRay rays[] = {{{0.0, 0.0, 100.0}, {0.0, 0.0, -1.0}}};
    std::vector<DrrRaySample> sample(1);
    raycast.cast(rays, sample);
    EXPECT(sample[0].exit_mm == 116.0);
    std::vector<DrrRaySpan> spans(PIXELS), again(PIXELS);
    raycast.update_pose(poses[0], WIDTH, HEIGHT, drr::defaults<DrrMatter>(), spans);
    raycast.update(drr::uniforms_cone(poses[0], WIDTH, HEIGHT), WIDTH, HEIGHT, drr::defaults<DrrMatter>(), again);
    EXPECT(raycast.statistics().views_computed == 2 && raycast.statistics().hits > 0);
    raycast.set_volume(water(context));
    EXPECT(raycast.statistics().rays == 0);
}

}  // namespace

int main() {
    projections();
    files();
    errors();
    parallel<float>(drr_parallel_create, drr_parallel_forward_project_view, drr_parallel_destroy);
    parallel<double>(drr_parallel_create_f64, drr_parallel_forward_project_view_f64, drr_parallel_destroy_f64);
    rays_and_poses<float>();
    rays_and_poses<double>();
    rays_in_the_box();
    std::puts("PASS");
    return 0;
}
