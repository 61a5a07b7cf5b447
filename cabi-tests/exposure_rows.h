/* What exposures refuse. */
#ifndef EXPOSURE_ROWS_H
#define EXPOSURE_ROWS_H

#include "effect_rows.h"
#include "projection_rows.h"

static DrrStatus call_exposure_create(const Given *g) {
    return drr_exposure_create((const DrrProjector *)g->projector, (const ProjectionUniforms *)g->views, g->view_count,
                               NULL, NULL, (DrrExposure **)g->exposure);
}
static DrrStatus call_exposure_create_poses(const Given *g) {
    return drr_exposure_create_poses((const DrrProjector *)g->projector, (const DrrDetectorPose *)g->poses,
                                     g->view_count, NULL, NULL, (DrrExposure **)g->exposure);
}
static DrrStatus call_exposure_develop(const Given *g) {
    return drr_exposure_develop((const DrrExposure *)g->exposure, (const DrrScene *)g->scene,
                                (const DrrOutputs *)g->outputs);
}
static DrrStatus call_exposure_destroy(const Given *g) { return drr_exposure_destroy((DrrExposure *)g->exposure); }
static void exposure_place(Given *g) { g->exposure = &g->to.handle; }
static void destroy_made_exposure(const Given *g) { drr_exposure_destroy((DrrExposure *)g->to.handle); }
static void no_exposure(Given *g) { g->exposure = NULL; }
static void own_scene(Given *g) { g->scene = NULL; }
/* What the exposures of the rows of scenes have. */
static void without_bone_path(Given *g) { g->to.outputs.bone_path_mm = NULL; }

static const Function exposure_create = {"drr_exposure_create", exposure_place, call_exposure_create,
                                         destroy_made_exposure},
                      exposure_create_poses = {"drr_exposure_create_poses", exposure_place,
                                               call_exposure_create_poses, destroy_made_exposure},
                      exposure_develop = {"drr_exposure_develop", own_scene, call_exposure_develop, NULL},
                      exposure_develop_scene = {"drr_exposure_develop", without_bone_path, call_exposure_develop, NULL},
                      exposure_destroy = {"drr_exposure_destroy", no_exposure, call_exposure_destroy, NULL};

static void exposure_askew(Given *g) { g->exposure = (char *)live.exposure + 1; }
static void exposure_foreign(Given *g) { g->exposure = live.projector; }
static void exposure_destroyed(Given *g) {
    DrrExposure *exposure = NULL;
    drr_exposure_create_poses(live.projector, g->to.poses, VIEWS, NULL, NULL, &exposure);
    drr_exposure_destroy(exposure);
    g->exposure = exposure;
}
static void focused(Given *g) { g->projector = live.focused; }

/* Rays for a scene that has been changed in a way that developing does not undo. */
static DrrExposure *made_exposure;
static void expose_scene(Given *g) {
    DrrProjector *projector = NULL;
    if (drr_projector_create(live.volume, &g->to.scene, &projector) != DRR_STATUS_OK) return;
    if (drr_exposure_create_poses(projector, g->to.poses, VIEWS, NULL, NULL, &made_exposure) == DRR_STATUS_OK) {
        g->exposure = made_exposure;
    }
    drr_projector_destroy(projector);
}
static void destroy_exposed(void) {
    drr_exposure_destroy(made_exposure);
    made_exposure = NULL;
}

#define EXPOSURE_ROWS(f)                                                                                            \
    {f, "exposure", "misaligned", exposure_askew, NOTHING, INVALID, "exposure is 0x", "a DrrExposure"},             \
    {f, "exposure", "foreign", exposure_foreign, NOTHING, INVALID, "exposure is no such handle;",                   \
     "a DrrExposure that has not been destroyed"},                                                                  \
    {f, "exposure", "destroyed", exposure_destroyed, NOTHING, INVALID, "exposure is ", "a DrrExposure"}
#define ANOTHER_ROW(field, kind, setting, change, valid)                                                            \
    {&exposure_develop_scene, "scene." field, kind, setting, change, INVALID, "scene." field " is another;",        \
     valid ", as in the exposure"}

static const Row exposure_rows[] = {
    HANDLE_ROWS(&exposure_create),
    COUNT_ROWS(&exposure_create, "view_count", view_count, "65536", 65537),
    MATRIX_ROWS(&exposure_create),
    {&exposure_create, "views[1].spectrumLutAddress", "given", spectrum_lut, NOTHING, INVALID,
     "views[1].spectrumLutAddress or muLutAddress is given;", "0 in an exposure and in a scene with effects"},
    {&exposure_create, "views[0]", "without a detector", focused, NOTHING, INVALID,
     "views[0].scene.effects DRR_EFFECT_FOCAL_SPOT is asked for in a view given by a matrix;", "source and detector"},
    POINTER_ROWS(&exposure_create, exposure, handle, "8 bytes"),
    HANDLE_ROWS(&exposure_create_poses),
    COUNT_ROWS(&exposure_create_poses, "view_count", view_count, "65536", 65537),
    POINTER_ROWS(&exposure_create_poses, poses, poses, "8 bytes"),
    POSE_ROWS(&exposure_create_poses, "poses[1]"),
    POINTER_ROWS(&exposure_create_poses, exposure, handle, "8 bytes"),

    {&exposure_develop, "exposure", "NULL", NULL, POINT(exposure, NULL), INVALID, "exposure is NULL;", "a DrrExposure"},
    EXPOSURE_ROWS(&exposure_develop),
    OUTPUTS_ROWS(&exposure_develop, outputs, "56", "4 bytes"),
    {&exposure_develop_scene, "scene", "misaligned", NULL, ASKEW(scene, scene), INVALID, "scene is 0x", "aligned to 8 bytes"},
    ANOTHER_ROW("detector_width", "another", NULL, PUT(to.scene.detector_width, size_t, 2), "3"),
    ANOTHER_ROW("detector_height", "another", NULL, PUT(to.scene.detector_height, size_t, 1), "2"),
    ANOTHER_ROW("supersampling", "another", NULL, PUT(to.scene.supersampling, uint32_t, 2), "1"),
    ANOTHER_ROW("mass_attenuation", "another", own_materials, NOTHING, "air, lung, soft_tissue, bone_cortical"),
    ANOTHER_ROW("bone_material", "another", NULL, PUT(to.scene.bone_material, uint32_t, 2), "3"),
    ANOTHER_ROW("bone_material", "none", NULL, PUT(to.scene.effects, DrrEffects, DRR_EFFECT_POLYENERGETIC), "3"),
    ANOTHER_ROW("effects DRR_EFFECT_FOCAL_SPOT", "another", focal_spot, NOTHING, "a point"),
    ANOTHER_ROW("implants", "another", implanted, NOTHING, "the 0 implants"),

    EXPOSURE_ROWS(&exposure_destroy),
};

#endif
