//! Whether the tables of refused calls (`cabi-tests/errors.c`) have a row for every way in which every argument of
//! every function of the header, and every field of what an argument points to, can be wrong.

use std::collections::BTreeSet;

use libtest_mimic::Failed;

use crate::header::{Declared, Header};

/// Functions that cannot fail, whatever they are given.
const INFALLIBLE: [&str; 4] =
    ["drr_status_name", "drr_last_error_message", "drr_version", "drr_version_number"];
/// How many functions return a string instead of a status.
const TELLING: usize = 2;
/// Pointers that may be NULL, by function and parameter.
const NULLABLE: &[[&str; 2]] = &[
    ["drr_context_create", "options"],
    ["drr_volume_create", "labels"],
    ["drr_volume_create_float32", "labels"],
    ["drr_context_destroy", "context"],
    ["drr_volume_destroy", "volume"],
    ["drr_projector_destroy", "projector"],
    ["drr_raycast_destroy", "raycast"],
    ["drr_exposure_develop", "scene"],
    ["drr_exposure_destroy", "exposure"],
    ["drr_parallel_destroy", "parallel"],
    ["drr_parallel_forward_project_view", "lengths"],
    ["drr_parallel_view_loss_value_and_grad", "lengths"],
    ["drr_parallel_view_loss_value_and_grad", "hessian"],
    ["drr_parallel_view_jacobian", "lengths"],
    ["drr_parallel_view_jacobian", "image"],
    ["drr_ray_transform_destroy", "transform"],
    ["drr_pose_gradient_create", "pivot"],
    ["drr_pose_gradient_destroy", "pose_gradient"],
    ["drr_pose_gradient_loss_value_and_grad", "hessian"],
    ["drr_pose_gradient_jacobian", "image"],
];
/// Parameters and fields that hold nothing wrong, whatever their bytes are.
const ANYTHING_GOES: [&str; 6] =
    ["enableEarlyExit", "_padding", "progress", "progress_data", "noise_seed", "scatter_seed"];
/// What ends the name of a function that is another's twin in float64.
const TWIN: &str = "_f64";
/// Functions that look at no tables of a view: the rows run on an engine without queues, exposures refuse any, and where a ray
/// meets anything is no matter of energies.
const WITHOUT_TABLES: [&str; 3] = ["drr_projector_encode", "drr_exposure_create", "drr_raycast_update"];

impl Declared {
    /// What is pointed to, if the pointer is only read through.
    fn input(&self) -> Option<&str> {
        self.ctype.strip_prefix("const ")?.strip_suffix(" *")
    }

    /// How a parameter can be wrong by its type.
    fn kinds_of_parameter(&self, handles: &BTreeSet<String>) -> Vec<&'static str> {
        let not_a_number = ["NaN", "+Inf", "-Inf"];
        match self.ctype.as_str() {
            "size_t" => vec!["zero", "huge"],
            // The queue of an encoded projection, which engines of the CPU do not look at.
            "void *" if self.name == "queue" => Vec::new(),
            _ if ANYTHING_GOES.contains(&self.name.as_str()) => Vec::new(),
            "double" => not_a_number.to_vec(),
            "DrrAlgorithm" | "DrrPoseSignal" => vec!["unknown"],
            "const uint8_t *" if self.name == "mask" => vec!["empty"],
            "const char *" => vec!["NULL", "unknown", "not UTF-8"],
            "const uint8_t *" => vec!["NULL", "label"],
            "const float *" | "const double *" => [&["NULL", "misaligned"], &not_a_number[..]].concat(),
            handle if handles.contains(handle.trim_start_matches("const ").trim_end_matches(" *")) => {
                vec!["NULL", "misaligned", "foreign", "destroyed"]
            }
            pointer if pointer.ends_with('*') => vec!["NULL", "misaligned"],
            other => panic!("a parameter of a type that this test does not know: {other}"),
        }
    }

    /// How a field can be wrong by its type.
    fn kinds_of_field(&self) -> &'static [&'static str] {
        match self.ctype.as_str() {
            "size_t" if self.name == "struct_size" => &["zero", "small", "big", "SIZE_MAX"],
            "size_t" if ["device_index", "point_count"].contains(&self.name.as_str()) => &["huge"],
            "size_t" | "uint64_t" => &["zero", "huge"],
            "void *" if self.name == "metal_device" => &["not NULL"],
            "const char *" => &["unknown", "not UTF-8"],
            "uint32_t" => &["huge"],
            "double" | "DrrFloat3" => &["NaN", "+Inf", "-Inf", "huge"],
            "DrrFloat4x4" => &["NaN", "+Inf", "-Inf", "singular", "nearly singular"],
            "const float *" | "DrrAddress" => &["misaligned", "negative", "NaN", "+Inf", "-Inf"],
            "const double *" => &["misaligned", "NaN", "+Inf", "-Inf"],
            "void *" | "float *" | "double *" => &["misaligned"],
            "DrrBackend"
            | "DrrCalibration"
            | "DrrThresholds"
            | "DrrEffects"
            | "DrrAlgorithm"
            | "DrrImplantShape"
            | "DrrParallelQuadrature" => &["unknown"],
            array if array.starts_with("const Drr") && array.ends_with('*') => &["misaligned"],
            other => panic!("a field of a type that this test does not know: {other} {}", self.name),
        }
    }
}

impl Header {
    /// The fields of what a parameter or field called `name` points to, and of what these point to, with their names. Poses
    /// in a scene have rows of their own function.
    fn fields<'a>(&'a self, pointer: &Declared, name: &str) -> Vec<(String, &'a Declared)> {
        let fields = pointer.input().and_then(|pointee| self.structs.get(pointee));
        let nested = |field: &'a Declared| {
            let name = format!("{name}.{}", field.name);
            let within = if name == "scene.expected_poses" { Vec::new() } else { self.fields(field, &name) };
            std::iter::once((name, field)).chain(within)
        };
        fields.into_iter().flatten().flat_map(nested).collect()
    }

    /// Every function, argument and kind that needs a row.
    fn demanded(&self) -> BTreeSet<[String; 3]> {
        let mut demanded = BTreeSet::new();
        for (function, declared) in &self.functions {
            let mut demand = |argument: &str, kind: &str| {
                demanded.insert([function.as_str(), argument, kind].map(str::to_owned));
            };
            if INFALLIBLE.contains(&function.as_str()) {
                continue;
            }
            for parameter in &declared.parameters {
                let of = function.strip_suffix(TWIN).unwrap_or(function);
                let nullable = NULLABLE.contains(&[of, &parameter.name]);
                let kinds = parameter.kinds_of_parameter(&self.handles);
                let kinds = kinds.into_iter().filter(|&kind| kind != "NULL" || !nullable);
                kinds.for_each(|kind| demand(&parameter.name, kind));
                for (argument, field) in self.fields(parameter, &parameter.name) {
                    let unseen = WITHOUT_TABLES.contains(&function.as_str()) && field.ctype == "DrrAddress";
                    let fallible = !unseen && !ANYTHING_GOES.contains(&field.name.as_str());
                    let kinds = if fallible { field.kinds_of_field() } else { &[] };
                    for kind in kinds {
                        demand(&argument, kind);
                    }
                }
            }
        }
        demanded
    }
}

/// The row that a line `function argument kind` speaks of; an argument's indices say which of many was wrong.
fn row(line: &str) -> Option<[String; 3]> {
    let mut words = line.splitn(3, ' ');
    let [function, argument, kind] = [words.next()?, words.next()?, words.next()?];
    let parts = argument.split('.').map(|part| part.split('[').next().unwrap_or_default());
    Some([function.to_owned(), parts.collect::<Vec<_>>().join("."), kind.to_owned()])
}

/// Compares the rows that the program ran with what the header needs.
pub(super) fn complete(output: &str) -> Result<(), Failed> {
    let header = Header::read();
    let demanded = header.demanded();
    // What the parser does not find, it does not demand.
    let exports = include_str!("../../include/DRR_Shared.h").matches("\nDrrStatus drr_").count();
    if header.functions.len() != exports + INFALLIBLE.len() + TELLING || demanded.len() < 300 {
        return Err(format!("{} functions, {} rows", header.functions.len(), demanded.len()).into());
    }
    let there: BTreeSet<_> = output.lines().filter_map(row).collect();
    let missing: Vec<_> = demanded.difference(&there).map(|row| row.join(" ")).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!("cabi-tests/errors.c has no row for\n{}", missing.join("\n")).into())
}
