//! OpenEXR files by the tools of OpenEXR (Debian: openexr).

use std::path::Path;

use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use libtest_mimic::{Failed, Trial};

use crate::needing::needing;
use crate::{drr, expect, program, project, succeed};

pub(super) fn tests() -> Vec<Trial> {
    vec![
        needing("exr::channels_and_attributes", program("exrheader"), |tool| channels_and_attributes(&tool)),
        needing("exr::decoded_by_the_library_itself", program("exrmaketiled"), |tool| {
            decoded_by_the_library_itself(&tool)
        }),
    ]
}

/// Channels are float32, grouped as LAYER.CHANNEL; what a file says about itself is there as text.
fn channels_and_attributes(exrheader: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    project(folder.path(), &[])?;
    let header = succeed(exrheader, &["out/view0.exr"], folder.path())?;
    let materials = ["air", "bone_cortical", "lung", "soft_tissue"].map(|m| format!("areal_density.{m}"));
    for channel in materials.iter().map(String::as_str).chain(["bone_path", "intensity", "line_integral"]) {
        let line = format!("{channel}, 32-bit floating-point, sampling 1 1");
        expect(header.contains(&line), || format!("{line}: {header}"))?;
    }
    for attribute in
        ["drr.patient_orientation (type string): \"LP\\H\"", "drr.layers (type string): \"intensity, "]
    {
        expect(header.contains(attribute), || format!("{attribute}: {header}"))?;
    }
    // Two layers of a detector are a group, too.
    drr(
        &["project", "--detector", "top_energy,bottom_energy", "--size", "20x20", "--output", "two"],
        folder.path(),
    )?;
    let header = succeed(exrheader, &["two/view0.exr"], folder.path())?;
    for channel in ["intensity.top_energy,", "intensity.bottom_energy,", "line_integral.top_energy,"] {
        expect(header.contains(channel), || format!("{channel}: {header}"))?;
    }
    Ok(())
}

/// Every pixel of every channel comes through OpenEXR's own decoder to the last bit.
fn decoded_by_the_library_itself(exrmaketiled: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    project(folder.path(), &[])?;
    succeed(exrmaketiled, &["out/view0.exr", "tiled.exr"], folder.path())?;
    let [own, tiled] = ["out/view0.exr", "tiled.exr"]
        .map(|name| read_all_flat_layers_from_file(folder.path().join(name)).expect("OpenEXR"));
    let [own, tiled] = [own, tiled].map(|image| image.layer_data[0].channel_data.list.clone());
    expect(own.len() == 7 && tiled.len() == 7, || format!("{} and {} channels", own.len(), tiled.len()))?;
    for (own, tiled) in own.iter().zip(&tiled) {
        let (FlatSamples::F32(a), FlatSamples::F32(b)) = (&own.sample_data, &tiled.sample_data) else {
            return Err("float32 was written".into());
        };
        let same = own.name == tiled.name && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
        expect(same && a.len() == 160 * 140, || format!("{}", own.name))?;
    }
    Ok(())
}
