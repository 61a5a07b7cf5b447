// drr for C++17 and later: DRR_Shared.h with owners, exceptions and sizes that are checked.
//
// Structs and constants are those of C, and so are units, shapes and what a call does: each function here is named after the
// one it calls. What is added:
//   - Every handle has an owner that can be moved and not copied, and destroys it. Owners are independent of each other, as
//     handles are. A moved-from owner may only be destroyed or assigned to.
//   - A call that fails throws drr::Error. What cannot fail is noexcept: moves, destructors, get().
//   - Arrays are views of the caller's memory, drr::Span; one with the wrong number of elements is refused before the call.
//     Nothing is copied. Pointers within structs of C are believed, as in C.
//   - drr::defaults<T>() is a struct as its _init function fills it.
#ifndef DRR_HPP
#define DRR_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "DRR_Shared.h"

namespace drr {

/// A call that failed. what() says which argument was wrong, and what is valid.
class Error : public std::runtime_error {
public:
    Error(DrrStatus status, const std::string &message) : std::runtime_error(message), status_(status) {}
    /// One of the DRR_STATUS constants.
    DrrStatus status() const noexcept { return status_; }

private:
    DrrStatus status_;
};

/// Elements in a row that belong to the caller: of anything with data() and size(), of an array, or of a pointer and a number.
/// An empty one is NULL.
template <class T>
class Span {
public:
    constexpr Span() noexcept = default;
    constexpr Span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    template <std::size_t Size>
    constexpr Span(T (&array)[Size]) noexcept : data_(array), size_(Size) {}
    template <class Range, class = std::enable_if_t<std::is_convertible_v<decltype(std::declval<Range &>().data()), T *>>>
    constexpr Span(Range &&range) : data_(range.size() == 0 ? nullptr : range.data()), size_(range.size()) {}

    constexpr T *data() const noexcept { return data_; }
    constexpr std::size_t size() const noexcept { return size_; }

private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};

namespace detail {

inline void check(DrrStatus status) {
    if (status != DRR_STATUS_OK) throw Error(status, drr_last_error_message());
}

inline const char *checked(const char *text) {
    if (text == nullptr) throw Error(DRR_STATUS_INVALID_ARGUMENT, drr_last_error_message());
    return text;
}

/// Refuses a span of another size; one that may be absent may be empty.
template <class T>
T *sized(const char *name, Span<T> span, std::size_t size, bool optional = false) {
    if (span.size() == size || (optional && span.data() == nullptr)) return span.data();
    throw Error(DRR_STATUS_INVALID_ARGUMENT, std::string(name) + " has " + std::to_string(span.size()) +
                                                 " elements; valid are " + std::to_string(size));
}

template <class Handle, DrrStatus (*Destroy)(Handle *)>
struct Destroyer {
    void operator()(Handle *handle) const noexcept { Destroy(handle); }
};

/// A handle that is owned.
template <class Handle, DrrStatus (*Destroy)(Handle *)>
class Owner {
public:
    /// The handle, for calls of C; it stays owned. NULL after a move.
    Handle *get() const noexcept { return handle_.get(); }

protected:
    /// Calls a function of C whose last parameter is where the new handle goes.
    template <class Create, class... Arguments>
    explicit Owner(Create create, Arguments... arguments) {
        Handle *handle = nullptr;
        check(create(arguments..., &handle));
        handle_.reset(handle);
    }

private:
    std::unique_ptr<Handle, Destroyer<Handle, Destroy>> handle_;
};

inline DrrStatus init(DrrContextOptions *value) { return drr_context_options_init(value); }
inline DrrStatus init(DrrVolumeDescriptor *value) { return drr_volume_descriptor_init(value); }
inline DrrStatus init(DrrScene *value) { return drr_scene_init(value); }
inline DrrStatus init(DrrOutputs *value) { return drr_outputs_init(value); }
inline DrrStatus init(DrrReferenceOutputs *value) { return drr_reference_outputs_init(value); }
inline DrrStatus init(DrrDeviceOutputs *value) { return drr_device_outputs_init(value); }
inline DrrStatus init(DrrCertificate *value) { return drr_certificate_init(value); }
inline DrrStatus init(DrrParallelGeometry *value) { return drr_parallel_geometry_init(value); }
inline DrrStatus init(DrrCamera *value) { return drr_camera_init(value); }
inline DrrStatus init(DrrMatter *value) { return drr_matter_init(value); }
inline DrrStatus init(DrrRaycastStatistics *value) { return drr_raycast_statistics_init(value); }

/// The function for Real: that of float32 or its twin of float64.
template <class Real, class Function, class Twin>
constexpr auto pick(Function function, Twin twin) {
    static_assert(std::is_same_v<Real, float> || std::is_same_v<Real, double>);
    if constexpr (std::is_same_v<Real, float>) return function;
    else return twin;
}

template <class Real, class Float, class Double>
using Pick = std::conditional_t<std::is_same_v<Real, float>, Float, Double>;

inline std::size_t voxels(const std::size_t (&dimensions)[3]) { return dimensions[0] * dimensions[1] * dimensions[2]; }

}  // namespace detail

/// A struct of C as its _init function fills it.
template <class T>
T defaults() {
    T value;
    detail::check(detail::init(&value));
    return value;
}

inline const char *version() noexcept { return drr_version(); }
inline std::uint32_t version_number() noexcept { return drr_version_number(); }
inline const char *status_name(DrrStatus status) noexcept { return drr_status_name(status); }

/// An engine and its threads.
class Context : public detail::Owner<DrrContext, drr_context_destroy> {
public:
    Context() : Owner(drr_context_create, static_cast<const DrrContextOptions *>(nullptr)) {}
    explicit Context(const DrrContextOptions &options) : Owner(drr_context_create, &options) {}

    DrrBackend backend() const {
        DrrBackend backend;
        detail::check(drr_context_backend(get(), &backend));
        return backend;
    }
    const char *device_name() const { return detail::checked(drr_context_device_name(get())); }
};

/// A CT volume.
class Volume : public detail::Owner<DrrVolume, drr_volume_destroy> {
public:
    /// `labels` may be empty: then the descriptor's thresholds decide.
    Volume(const Context &context, const DrrVolumeDescriptor &descriptor, Span<const std::int16_t> hu,
           Span<const std::uint8_t> labels = {})
        : Owner(drr_volume_create, context.get(), &descriptor, voxels("hu", hu, descriptor),
                voxels("labels", labels, descriptor, true)) {}
    Volume(const Context &context, const DrrVolumeDescriptor &descriptor, Span<const float> hu,
           Span<const std::uint8_t> labels = {})
        : Owner(drr_volume_create_float32, context.get(), &descriptor, voxels("hu", hu, descriptor),
                voxels("labels", labels, descriptor, true)) {}
    /// Of a file, or a folder; the descriptor gets its dimensions and its index_to_world.
    static Volume load(const Context &context, const char *path, DrrVolumeDescriptor &descriptor) {
        return {context, path, &descriptor};
    }
    /// Of an id<MTLTexture>.
    static Volume of_metal_texture(const Context &context, const DrrVolumeDescriptor &descriptor, void *texture) {
        return {context, descriptor, texture};
    }

private:
    Volume(const Context &context, const char *path, DrrVolumeDescriptor *descriptor)
        : Owner(drr_volume_load, context.get(), path, descriptor) {}
    Volume(const Context &context, const DrrVolumeDescriptor &descriptor, void *texture)
        : Owner(drr_volume_create_metal_texture, context.get(), &descriptor, texture) {}

    template <class T>
    static T *voxels(const char *name, Span<T> span, const DrrVolumeDescriptor &descriptor, bool optional = false) {
        return detail::sized(name, span, detail::voxels(descriptor.dimensions), optional);
    }
};

inline DrrDetectorPose pose_c_arm(const std::array<double, 3> &centre, double angle_degrees, double source_axis_mm,
                                  double source_detector_mm, double pixel_mm, std::size_t width, std::size_t height) {
    DrrDetectorPose pose;
    detail::check(drr_pose_c_arm(centre.data(), angle_degrees, source_axis_mm, source_detector_mm, pixel_mm, width,
                                 height, &pose));
    return pose;
}

inline ProjectionUniforms uniforms_cone(const DrrDetectorPose &pose, std::size_t width, std::size_t height) {
    ProjectionUniforms uniforms;
    detail::check(drr_uniforms_cone(&pose, width, height, &uniforms));
    return uniforms;
}

inline void scene_set_preset(DrrScene &scene, const char *name) { detail::check(drr_scene_set_preset(&scene, name)); }

/// One volume, one scene, and the plan made for them.
class Projector : public detail::Owner<DrrProjector, drr_projector_destroy> {
public:
    Projector(const Volume &volume, const DrrScene &scene) : Owner(drr_projector_create, volume.get(), &scene) {}

    /// The plan in JSON; lives as long as the projector's handle.
    const char *describe() const { return detail::checked(drr_projector_describe(get())); }
    void project(Span<const ProjectionUniforms> views, const DrrOutputs &outputs) const {
        detail::check(drr_projector_project(get(), views.data(), views.size(), &outputs));
    }
    void project_poses(Span<const DrrDetectorPose> poses, const DrrOutputs &outputs) const {
        detail::check(drr_projector_project_poses(get(), poses.data(), poses.size(), &outputs));
    }
    void encode(Span<const ProjectionUniforms> views, void *queue, const DrrDeviceOutputs &outputs) const {
        detail::check(drr_projector_encode(get(), views.data(), views.size(), queue, &outputs));
    }
    void encode_poses(Span<const DrrDetectorPose> poses, void *queue, const DrrDeviceOutputs &outputs) const {
        detail::check(drr_projector_encode_poses(get(), poses.data(), poses.size(), queue, &outputs));
    }
    void reference_project(DrrAlgorithm algorithm, Span<const DrrDetectorPose> poses,
                           const DrrReferenceOutputs &outputs) const {
        detail::check(drr_reference_project(get(), algorithm, poses.data(), poses.size(), &outputs));
    }
    DrrCertificate certify(Span<const DrrDetectorPose> poses) const {
        auto certificate = defaults<DrrCertificate>();
        detail::check(drr_projector_certify(get(), poses.data(), poses.size(), &certificate));
        return certificate;
    }
};

/// What the rays of some views met.
class Exposure : public detail::Owner<DrrExposure, drr_exposure_destroy> {
public:
    Exposure(const Projector &projector, Span<const ProjectionUniforms> views, DrrProgress progress = nullptr,
             void *progress_data = nullptr)
        : Owner(drr_exposure_create, projector.get(), views.data(), views.size(), progress, progress_data) {}
    Exposure(const Projector &projector, Span<const DrrDetectorPose> poses, DrrProgress progress = nullptr,
             void *progress_data = nullptr)
        : Owner(drr_exposure_create_poses, projector.get(), poses.data(), poses.size(), progress, progress_data) {}

    /// As the scene that it was made with.
    void develop(const DrrOutputs &outputs) const { detail::check(drr_exposure_develop(get(), nullptr, &outputs)); }
    void develop(const DrrScene &scene, const DrrOutputs &outputs) const {
        detail::check(drr_exposure_develop(get(), &scene, &outputs));
    }
};

/// What a step of Gauss and Newton needs, of `N` parameters.
template <std::size_t N>
struct Loss {
    double value;
    std::array<double, N> gradient;
    /// Entry (m, n) is at N x m + n.
    std::array<double, N * N> hessian;
};

/// One volume before a parallel beam. An empty mask, or empty lengths, are all rays, or all of them.
template <class Real>
class BasicParallel
    : public detail::Pick<Real, detail::Owner<DrrParallel, drr_parallel_destroy>,
                          detail::Owner<DrrParallelF64, drr_parallel_destroy_f64>> {
    using Base = detail::Pick<Real, detail::Owner<DrrParallel, drr_parallel_destroy>,
                              detail::Owner<DrrParallelF64, drr_parallel_destroy_f64>>;

public:
    using Parameters = std::array<double, 5>;

    BasicParallel(const Context &context, const DrrParallelGeometry &geometry, Span<const Real> volume)
        : Base(detail::pick<Real>(drr_parallel_create, drr_parallel_create_f64), context.get(), &geometry,
               detail::sized("volume", volume, detail::voxels(geometry.dimensions))),
          voxels_(volume.size()), pixels_(geometry.detector_columns * geometry.detector_rows) {}

    void forward_project_view(const Parameters &parameters, Span<Real> image, Span<const std::uint8_t> mask = {},
                              Span<const double> lengths = {}) const {
        const auto call = detail::pick<Real>(drr_parallel_forward_project_view, drr_parallel_forward_project_view_f64);
        detail::check(call(this->get(), parameters.data(), mask_of(mask), lengths_of(lengths),
                           detail::sized("image", image, pixels_)));
    }
    void batch_forward_project(Span<const Parameters> views, Span<Real> images) const {
        const auto call = detail::pick<Real>(drr_parallel_batch_forward_project, drr_parallel_batch_forward_project_f64);
        detail::check(call(this->get(), first_of(views), views.size(),
                           detail::sized("images", images, views.size() * pixels_)));
    }
    void adjoint(Span<const Parameters> views, Span<const Real> images, Span<Real> volume) const {
        const auto call = detail::pick<Real>(drr_parallel_adjoint, drr_parallel_adjoint_f64);
        detail::check(call(this->get(), first_of(views), views.size(),
                           detail::sized("images", images, views.size() * pixels_),
                           detail::sized("volume", volume, voxels_)));
    }
    Loss<5> view_loss_value_and_grad(const Parameters &parameters, Span<const Real> measured,
                                     Span<const std::uint8_t> mask = {}, Span<const double> lengths = {}) const {
        const auto call =
            detail::pick<Real>(drr_parallel_view_loss_value_and_grad, drr_parallel_view_loss_value_and_grad_f64);
        Loss<5> loss;
        detail::check(call(this->get(), parameters.data(), detail::sized("measured", measured, pixels_), mask_of(mask),
                           lengths_of(lengths), &loss.value, loss.gradient.data(), loss.hessian.data()));
        return loss;
    }
    /// `image` may be empty.
    void view_jacobian(const Parameters &parameters, Span<Real> jacobian, Span<Real> image = {},
                       Span<const std::uint8_t> mask = {}, Span<const double> lengths = {}) const {
        const auto call = detail::pick<Real>(drr_parallel_view_jacobian, drr_parallel_view_jacobian_f64);
        detail::check(call(this->get(), parameters.data(), mask_of(mask), lengths_of(lengths),
                           detail::sized("image", image, pixels_, true),
                           detail::sized("jacobian", jacobian, parameters.size() * pixels_)));
    }

private:
    static_assert(sizeof(Parameters) == 5 * sizeof(double));

    static const double *first_of(Span<const Parameters> views) {
        return views.data() == nullptr ? nullptr : views.data()->data();
    }
    const std::uint8_t *mask_of(Span<const std::uint8_t> mask) const {
        return detail::sized("mask", mask, pixels_, true);
    }
    const double *lengths_of(Span<const double> lengths) const {
        return detail::sized("lengths", lengths, 2 * pixels_, true);
    }

    std::size_t voxels_, pixels_;
};
using Parallel = BasicParallel<float>;
using ParallelF64 = BasicParallel<double>;

/// The matrix of the lengths with which voxels count along rays, and its transpose.
template <class Real>
class BasicRayTransform
    : public detail::Pick<Real, detail::Owner<DrrRayTransform, drr_ray_transform_destroy>,
                          detail::Owner<DrrRayTransformF64, drr_ray_transform_destroy_f64>> {
    using Base = detail::Pick<Real, detail::Owner<DrrRayTransform, drr_ray_transform_destroy>,
                              detail::Owner<DrrRayTransformF64, drr_ray_transform_destroy_f64>>;

public:
    BasicRayTransform(const Context &context, const DrrVolumeDescriptor &descriptor, Span<const DrrDetectorPose> poses,
                      std::size_t width, std::size_t height, DrrAlgorithm algorithm, double step_voxels = 0.5)
        : Base(detail::pick<Real>(drr_ray_transform_create, drr_ray_transform_create_f64), context.get(), &descriptor,
               poses.data(), poses.size(), width, height, algorithm, step_voxels),
          voxels_(detail::voxels(descriptor.dimensions)), pixels_(poses.size() * width * height) {}

    void forward(Span<const Real> volume, Span<Real> images) const {
        const auto call = detail::pick<Real>(drr_ray_transform_forward, drr_ray_transform_forward_f64);
        detail::check(call(this->get(), detail::sized("volume", volume, voxels_), detail::sized("images", images, pixels_)));
    }
    void adjoint(Span<const Real> images, Span<Real> volume) const {
        const auto call = detail::pick<Real>(drr_ray_transform_adjoint, drr_ray_transform_adjoint_f64);
        detail::check(call(this->get(), detail::sized("images", images, pixels_), detail::sized("volume", volume, voxels_)));
    }

private:
    std::size_t voxels_, pixels_;
};
using RayTransform = BasicRayTransform<float>;
using RayTransformF64 = BasicRayTransform<double>;

/// Images in a cone beam and their derivatives by the object's six rigid parameters.
template <class Real>
class BasicPoseGradient
    : public detail::Pick<Real, detail::Owner<DrrPoseGradient, drr_pose_gradient_destroy>,
                          detail::Owner<DrrPoseGradientF64, drr_pose_gradient_destroy_f64>> {
    using Base = detail::Pick<Real, detail::Owner<DrrPoseGradient, drr_pose_gradient_destroy>,
                              detail::Owner<DrrPoseGradientF64, drr_pose_gradient_destroy_f64>>;

public:
    using Parameters = std::array<double, 6>;

    /// Turns about the volume's centre.
    BasicPoseGradient(const Volume &volume, const DrrScene &scene) : BasicPoseGradient(volume, scene, nullptr) {}
    BasicPoseGradient(const Volume &volume, const DrrScene &scene, const std::array<double, 3> &pivot)
        : BasicPoseGradient(volume, scene, pivot.data()) {}

    void project(const DrrDetectorPose &pose, const Parameters &parameters, DrrPoseSignal signal,
                 Span<Real> image) const {
        const auto call = detail::pick<Real>(drr_pose_gradient_project, drr_pose_gradient_project_f64);
        detail::check(call(this->get(), &pose, parameters.data(), signal, detail::sized("image", image, pixels_)));
    }
    /// An empty mask is all pixels.
    Loss<6> loss_value_and_grad(const DrrDetectorPose &pose, const Parameters &parameters, DrrPoseSignal signal,
                                Span<const Real> measured, Span<const std::uint8_t> mask = {}) const {
        const auto call =
            detail::pick<Real>(drr_pose_gradient_loss_value_and_grad, drr_pose_gradient_loss_value_and_grad_f64);
        Loss<6> loss;
        detail::check(call(this->get(), &pose, parameters.data(), signal, detail::sized("measured", measured, pixels_),
                           detail::sized("mask", mask, pixels_, true), &loss.value, loss.gradient.data(),
                           loss.hessian.data()));
        return loss;
    }
    /// `image` may be empty.
    void jacobian(const DrrDetectorPose &pose, const Parameters &parameters, DrrPoseSignal signal, Span<Real> jacobian,
                  Span<Real> image = {}) const {
        const auto call = detail::pick<Real>(drr_pose_gradient_jacobian, drr_pose_gradient_jacobian_f64);
        detail::check(call(this->get(), &pose, parameters.data(), signal, detail::sized("image", image, pixels_, true),
                           detail::sized("jacobian", jacobian, parameters.size() * pixels_)));
    }

private:
    BasicPoseGradient(const Volume &volume, const DrrScene &scene, const double *pivot)
        : Base(detail::pick<Real>(drr_pose_gradient_create, drr_pose_gradient_create_f64), volume.get(), &scene, pivot),
          pixels_(scene.detector_width * scene.detector_height) {}

    std::size_t pixels_;
};
using PoseGradient = BasicPoseGradient<float>;
using PoseGradientF64 = BasicPoseGradient<double>;

/// What rays meet in a volume.
class Raycast : public detail::Owner<DrrRaycast, drr_raycast_destroy> {
public:
    explicit Raycast(const Volume &volume) : Owner(drr_raycast_create, volume.get()) {}

    void set_volume(const Volume &volume) { detail::check(drr_raycast_set_volume(get(), volume.get())); }
    std::array<DrrRaySample, DRR_CAMERA_RAYS> cast_camera(const DrrCamera &camera) {
        std::array<DrrRaySample, DRR_CAMERA_RAYS> samples;
        detail::check(drr_raycast_cast_camera(get(), &camera, samples.data()));
        return samples;
    }
    void cast(Span<const DrrWorldRay> rays, Span<DrrRaySample> samples) {
        detail::check(drr_raycast_cast(get(), rays.data(), rays.size(), detail::sized("samples", samples, rays.size())));
    }
    void update(const ProjectionUniforms &uniforms, std::size_t width, std::size_t height, const DrrMatter &matter,
                Span<DrrRaySpan> spans) {
        detail::check(drr_raycast_update(get(), &uniforms, width, height, &matter,
                                         detail::sized("spans", spans, width * height)));
    }
    void update_pose(const DrrDetectorPose &pose, std::size_t width, std::size_t height, const DrrMatter &matter,
                     Span<DrrRaySpan> spans) {
        detail::check(drr_raycast_update_pose(get(), &pose, width, height, &matter,
                                              detail::sized("spans", spans, width * height)));
    }
    DrrRaycastStatistics statistics() {
        auto statistics = defaults<DrrRaycastStatistics>();
        detail::check(drr_raycast_statistics(get(), &statistics));
        return statistics;
    }
};

/// One value per energy first_energy_kev + k x energy_step_kev.
inline void physics_spectrum(const char *name, Span<float> weights, double first_energy_kev = 15.0,
                             double energy_step_kev = 1.0) {
    detail::check(drr_physics_spectrum(name, first_energy_kev, energy_step_kev, weights.size(), weights.data()));
}
inline void physics_mass_attenuation(const char *name, Span<float> coefficients, double first_energy_kev = 15.0,
                                     double energy_step_kev = 1.0) {
    detail::check(drr_physics_mass_attenuation(name, first_energy_kev, energy_step_kev, coefficients.size(),
                                               coefficients.data()));
}
inline void physics_detector(const char *name, Span<float> factors, double first_energy_kev = 15.0,
                             double energy_step_kev = 1.0) {
    detail::check(drr_physics_detector(name, first_energy_kev, energy_step_kev, factors.size(), factors.data()));
}

}  // namespace drr

#endif
