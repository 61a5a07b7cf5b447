//! `include/DRR_Shared.h` is what the sources say. `DRR_UPDATE_HEADER=1` rewrites it.
#![allow(missing_docs, reason = "a test program")]

use std::path::{Path, PathBuf};

use cbindgen::{Builder, Config, DocumentationStyle, Language, Style};

const WIRE: &str = "shared.rs";
/// In the order in which a reader of the header meets them. Each is read on its own, so that constants, structs and
/// functions of one noun stay together.
const HOST: [&str; 28] = [
    "capi/status.rs",
    "capi/version.rs",
    "capi/context.rs",
    "capi/volume.rs",
    "capi/volume_file.rs",
    "capi/metal.rs",
    "capi/geometry.rs",
    "capi/effects.rs",
    "capi/filter.rs",
    "capi/implant.rs",
    "capi/blur.rs",
    "capi/scene.rs",
    "capi/outputs.rs",
    "capi/projector.rs",
    "capi/exposure.rs",
    "capi/certificate.rs",
    "capi/encode.rs",
    "capi/reference.rs",
    "capi/parallel_geometry.rs",
    "capi/parallel.rs",
    "capi/parallel_f64.rs",
    "capi/ray_transform.rs",
    "capi/ray_transform_f64.rs",
    "capi/pose_gradient.rs",
    "capi/pose_gradient_f64.rs",
    "capi/raycast.rs",
    "capi/raycast_view.rs",
    "capi/physics.rs",
];
/// Structs that no function of their source file takes.
const NO_ARGUMENTS: [&str; 5] =
    ["ProjectionUniforms", "DrrFilter", "DrrImplant", "DrrScrewSection", "DrrBlurComponent"];
/// What the frame spells differently for each reader.
const IN_THE_FRAME: [&str; 4] = ["DrrAddress", "DrrBool", "DrrFloat3", "DrrFloat4x4"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The C declarations of a source file.
fn declarations(file: &str) -> String {
    let mut config = Config {
        language: Language::C,
        style: Style::Both,
        no_includes: true,
        usize_is_size_t: true,
        documentation_style: DocumentationStyle::Cxx,
        line_length: 110,
        tab_width: 4,
        ..Config::default()
    };
    config.export.include = NO_ARGUMENTS.map(Into::into).to_vec();
    config.export.exclude = IN_THE_FRAME.iter().map(ToString::to_string).collect();
    config.export.rename = [("DrrBool".into(), "bool".into())].into();
    let source = root().join("src").join(file);
    let bindings = Builder::new().with_src(source).with_config(config).generate().expect("the source parses");
    let mut text = Vec::new();
    bindings.write(&mut text);
    String::from_utf8(text).expect("UTF-8").trim().to_owned()
}

fn header() -> String {
    let text = include_str!("../src/capi/header.h.in")
        .replace("@MAJOR@", env!("CARGO_PKG_VERSION_MAJOR"))
        .replace("@MINOR@", env!("CARGO_PKG_VERSION_MINOR"))
        .replace("@PATCH@", env!("CARGO_PKG_VERSION_PATCH"))
        .replace("@WIRE@", &declarations(WIRE))
        .replace("@HOST@", &HOST.map(declarations).join("\n\n"));
    // Compilers of GPU code and older C compilers read ASCII with certainty.
    let ascii = [("×", "x"), ("²", "^2"), ("³", "^3")];
    ascii.iter().fold(text, |text, (from, to)| text.replace(from, to))
}

fn committed() -> PathBuf {
    root().join("include/DRR_Shared.h")
}

#[test]
fn the_committed_header_is_current() {
    let generated = header();
    if std::env::var_os("DRR_UPDATE_HEADER").is_some_and(|value| value == "1") {
        std::fs::write(committed(), &generated).expect("include/ can be written");
    }
    let committed = std::fs::read_to_string(committed()).unwrap_or_default();
    let differs = committed.lines().zip(generated.lines()).position(|(old, new)| old != new);
    let line = differs.unwrap_or(committed.lines().count().min(generated.lines().count())) + 1;
    assert!(
        committed == generated,
        "include/DRR_Shared.h is stale from line {line}; DRR_UPDATE_HEADER=1 cargo test --test header rewrites it"
    );
}

#[test]
fn every_source_file_of_the_abi_is_in_the_header() {
    let folder = std::fs::read_dir(root().join("src/capi")).expect("src/capi is there");
    for path in folder.map(|entry| entry.expect("readable").path()) {
        let text = std::fs::read_to_string(&path).expect("readable");
        let name = format!("capi/{}", path.file_name().expect("a file").to_string_lossy());
        let is_abi =
            ["no_mangle", "pub const DRR_", "\npub struct Drr"].iter().any(|part| text.contains(part));
        assert_eq!(is_abi, HOST.contains(&name.as_str()), "{name}");
    }
}

#[test]
fn the_header_is_ascii() {
    for (n, line) in header().lines().enumerate() {
        assert!(line.is_ascii(), "line {}: {line}", n + 1);
    }
}
