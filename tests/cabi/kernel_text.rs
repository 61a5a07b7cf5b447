//! The kernel text as Metal Shading Language, by Clang and stand-ins for Metal's headers: not Apple's compiler, but one that
//! knows address spaces and Metal's keywords.

use std::collections::{BTreeMap, BTreeSet};

use libtest_mimic::{Failed, Trial};

use crate::toolchain::{Compiler, Library, scratch};
use crate::{beside_this_file, needing, passes};

/// As `build.rs` flattens it for `newLibraryWithSource`.
const TEXT: &str = include_str!(concat!(env!("OUT_DIR"), "/drr.metal"));

/// Of parallel beams.
const PARALLEL: &str = include_str!(concat!(env!("OUT_DIR"), "/parallel.metal"));

/// What their kernels have or have not, in every combination.
const OF_PARALLEL: [&str; 4] = ["DRR_DERIVATIVES", "DRR_RESIDUAL", "DRR_MASK", "DRR_LENGTHS"];

type Definitions = BTreeMap<&'static str, u32>;

/// What every kernel has, whatever its value.
const ALWAYS: [(&str, &[u32]); 6] = [
    ("DRR_ALGORITHM", &[0, 1, 2]),
    ("DRR_LABELS", &[0b1110, 0, 0b100]),
    ("DRR_MATERIALS", &[4, 8]),
    ("DRR_SUPERSAMPLING", &[1, 3]),
    ("DRR_VOXELS", &[0, 1, 2]),
    ("DRR_DENSITY", &[0, 1, 2]),
];

/// What a kernel has or has not.
const SOMETIMES: [(&str, &[u32]); 13] = [
    ("DRR_ONE_LABEL", &[1]),
    ("DRR_INTENSITY", &[1]),
    ("DRR_LINE_INTEGRAL", &[1]),
    ("DRR_AREAL_DENSITY", &[1]),
    ("DRR_EARLY_EXIT", &[1]),
    ("DRR_FEW_ENERGIES", &[1]),
    ("DRR_BONE_PATH", &[3]),
    ("DRR_AXIS", &[0, 1, 2]),
    ("DRR_IMAGE_TEXTURE", &[1, 2]),
    ("DRR_SPECIFICATION_LOOP", &[1]),
    ("DRR_SIGNALS", &[2, 1, 8]),
    ("DRR_BEFORE", &[1, 8]),
    ("DRR_OPEN", &[1]),
];

/// The same kernel with one definition more, or another value of it.
fn with(kernel: &Definitions, name: &'static str, value: u32) -> Definitions {
    let mut kernel = kernel.clone();
    kernel.insert(name, value);
    // The texture gets what the layer has.
    if name == "DRR_IMAGE_TEXTURE" {
        kernel.insert("DRR_INTENSITY", 1);
    }
    kernel
}

fn without(kernel: &Definitions, name: &str) -> Definitions {
    let gone = |other: &str| other == name || name == "DRR_INTENSITY" && other == "DRR_IMAGE_TEXTURE";
    kernel.iter().filter(|(other, _)| !gone(other)).map(|(&name, &value)| (name, value)).collect()
}

/// Each definition with each of its values, and off where it can be: beside as few others as there can be, and beside all;
/// and every algorithm with every storage of voxels.
fn kernels() -> BTreeSet<Definitions> {
    let first = |definitions: &[(&'static str, &[u32])]| -> Definitions {
        definitions.iter().map(|&(name, values)| (name, values[0])).collect()
    };
    let least = first(&ALWAYS);
    let most = least.clone().into_iter().chain(first(&SOMETIMES)).collect();
    let mut kernels = BTreeSet::new();
    for base in [&least, &most] {
        for &(name, values) in ALWAYS.iter().chain(&SOMETIMES) {
            kernels.extend(values.iter().map(|&value| with(base, name, value)));
        }
        kernels.extend(SOMETIMES.map(|(name, _)| without(base, name)));
        for algorithm in 0..3 {
            let base = with(base, "DRR_ALGORITHM", algorithm);
            kernels.extend((0..3).map(|voxels| with(&base, "DRR_VOXELS", voxels)));
        }
    }
    kernels
}

/// Clang copies no struct from one address space to another; Metal does. These are the ones that the text copies from the
/// launch and the beams.
fn copied_between_spaces(text: &str) -> String {
    let members =
        [("DrrTwofold", &["high", "low"][..]), ("DrrStandIn", &["origin", "kink", "scale", "offset"])];
    members.into_iter().fold(text.to_owned(), |text, (name, members)| {
        let list = |item: &dyn Fn(&&str) -> String| members.iter().map(item).collect::<Vec<_>>().join(", ");
        let (arguments, given) = (list(&|m| format!("float {m}")), list(&|m| format!("{m}({m})")));
        let copied = list(&|m| format!("{m}(a.{m})"));
        let constructors = format!(
            "{name}() = default; {name}(const {name} &) = default; {name} &operator=(const {name} &) = default; \
             {name}({arguments}) : {given} {{}} {name}(const constant {name} &a) : {copied} {{}} \
             {name} &operator=(const constant {name} &a) {{ return *this = {name}(a); }}"
        );
        text.replacen(&format!("struct {name} {{"), &format!("struct {name} {{ {constructors}"), 1)
    })
}

/// What Clang says of a kernel.
fn check(compiler: &Compiler, name: &str, kernel: &Definitions, text: &str) -> Result<(), Failed> {
    let definitions = kernel.iter().map(|(name, value)| format!("#define {name} {value}\n"));
    let source = definitions.collect::<String>() + &copied_between_spaces(text);
    let path = scratch().join(format!("kernel_{name}.metal.cpp"));
    std::fs::write(&path, source)?;
    compiler.check(&path)
}

fn every_kernel_compiles(compiler: &Compiler) -> Result<(), Failed> {
    for (number, kernel) in kernels().iter().enumerate() {
        let result = check(compiler, &number.to_string(), kernel, TEXT);
        result.map_err(|failed| format!("{kernel:?}: {}", failed.message().unwrap_or_default()))?;
    }
    Ok(())
}

fn every_parallel_kernel_compiles(compiler: &Compiler) -> Result<(), Failed> {
    for n in 0..1 << OF_PARALLEL.len() {
        let on = OF_PARALLEL.iter().enumerate().filter(|(bit, _)| n >> bit & 1 == 1);
        let kernel: Definitions = on.map(|(_, &name)| (name, 1)).collect();
        let result = check(compiler, &format!("parallel_{n}"), &kernel, PARALLEL);
        result.map_err(|failed| format!("{kernel:?}: {}", failed.message().unwrap_or_default()))?;
    }
    Ok(())
}

/// A compiler that does not tell address spaces apart passes everything: this one finds an error that is there on purpose.
fn finds(compiler: &Compiler, name: &str, wrong: &str, complaint: &str) -> Result<(), Failed> {
    let kernel = kernels().pop_first().ok_or("there are kernels")?;
    match check(compiler, name, &kernel, &format!("{TEXT}\n{wrong}\n")) {
        Ok(()) => Err(format!("{wrong} was not found").into()),
        Err(failed) if failed.message().is_some_and(|message| message.contains(complaint)) => Ok(()),
        Err(failed) => Err(failed),
    }
}

/// The names that the engine defines are those of the lists above.
fn every_definition_is_listed() -> Result<(), Failed> {
    let engine = [
        include_str!("../../src/engine/gpu/definitions.rs"),
        include_str!("../../src/engine/metal/program.rs"),
    ];
    let strings = engine.iter().flat_map(|source| source.split('"'));
    let defined: BTreeSet<_> = strings.filter(|string| string.starts_with("DRR_")).collect();
    let listed: BTreeSet<_> = ALWAYS.iter().chain(&SOMETIMES).map(|(name, _)| *name).collect();
    let parallel = include_str!("../../src/engine/gpu/parallel/mod.rs").split('"');
    let parallel: BTreeSet<_> = parallel.filter(|string| string.starts_with("DRR_")).collect();
    let pairs = [(defined, listed), (parallel, OF_PARALLEL.into_iter().collect())];
    match pairs.iter().find(|(defined, listed)| defined != listed) {
        None => Ok(()),
        Some((defined, listed)) => Err(format!("{:?}", defined.symmetric_difference(listed)).into()),
    }
}

/// The tables that views bring, prepared by the kernel's own lines as host code.
fn tables_are_prepared(compiler: &Compiler) -> Result<(), Failed> {
    passes(compiler, &Library::none(), &beside_this_file("tables.cpp")).map(drop)
}

pub(super) fn trials() -> Vec<Trial> {
    let metal = Compiler::metal_stand_in();
    let finding = |name: &'static str, wrong: &'static str, complaint: &'static str| {
        needing(format!("kernel_text::finds_{name}"), metal.clone(), move |compiler| {
            finds(&compiler, name, wrong, complaint)
        })
    };
    vec![
        Trial::test("kernel_text::every_definition_is_listed", every_definition_is_listed),
        needing("kernel_text::metal_stand_in", metal.clone(), |compiler| every_kernel_compiles(&compiler)),
        needing("kernel_text::parallel_metal_stand_in", metal.clone(), |compiler| {
            every_parallel_kernel_compiles(&compiler)
        }),
        finding(
            "a_wrong_address_space",
            "static float first(constant float *table) { return *table; } \
             float wrong(device float *image) { return first(image); }",
            "address space",
        ),
        finding(
            "a_missing_address_space",
            "float wrong(device DrrBeam *beams) { const float *i0 = &beams->i0; return *i0; }",
            "address_space",
        ),
        finding("a_keyword", "float wrong(float half) { return half; }", "cannot combine"),
        needing("kernel_text::tables_are_prepared", Compiler::cpp("c++17"), |compiler| {
            tables_are_prepared(&compiler)
        }),
    ]
}
