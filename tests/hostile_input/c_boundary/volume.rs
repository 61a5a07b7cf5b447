//! Volumes.

use drr::capi::context::DrrContext;
use drr::capi::volume::{
    DrrVolume, DrrVolumeDescriptor, drr_volume_create, drr_volume_create_float32, drr_volume_descriptor_init,
};

use super::call::{made, succeeded};
use super::input::Input;
use super::memory::How;

/// Most voxels that are made; a larger volume is described, but its voxels are NULL.
const MOST_VOXELS: usize = 4096;

/// What is known of a volume that was accepted.
pub(super) struct Extent {
    /// The longest path inside, mm.
    pub(super) diagonal_mm: f64,
    /// Voxels along the longest axis.
    pub(super) longest: usize,
    /// The centre, mm.
    pub(super) centre: [f64; 3],
}

/// A volume of at most `MOST_VOXELS`, if the library takes it.
pub(super) fn make(input: &mut Input<'_>, context: *const DrrContext) -> Option<(*mut DrrVolume, Extent)> {
    let descriptor = descriptor(input);
    let voxels = descriptor.dimensions.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
    let present = voxels.filter(|&voxels| voxels <= MOST_VOXELS);
    let count = present.unwrap_or(0);
    let pointer = How::of(input);
    let place = if present.is_some() { How::of(input) } else { How::Null };
    let given = How::of(input).pass(&raw const descriptor);
    let labelled = input.seldom() && present.is_some();
    let labels: Vec<u8> = if labelled { (0..count).map(|_| label(input)).collect() } else { Vec::new() };
    let labels = if labelled { labels.as_ptr() } else { std::ptr::null() };
    let context = pointer.pass(context);
    // Ordinarily float32, whose tables are small: an input takes a tenth of the time.
    let volume = if input.seldom() {
        let hu: Vec<i16> = (0..count).map(|i| int16(input, i)).collect();
        // SAFETY: there are as many voxels as the descriptor says, or NULL; the rest is good, NULL or misaligned.
        made(|v| unsafe { drr_volume_create(context, given, place.pass(hu.as_ptr()), labels, v) })
    } else {
        let hu: Vec<f32> = (0..count).map(|i| input.float(ordinary(i).into())).collect();
        // SAFETY: as above.
        made(|v| unsafe { drr_volume_create_float32(context, given, place.pass(hu.as_ptr()), labels, v) })
    }?;
    Some((volume, extent(&descriptor)))
}

fn descriptor(input: &mut Input<'_>) -> DrrVolumeDescriptor {
    let mut descriptor = std::mem::MaybeUninit::uninit();
    // SAFETY: a place for one struct; it is filled on success.
    let mut descriptor = unsafe {
        assert!(succeeded(drr_volume_descriptor_init(descriptor.as_mut_ptr())));
        descriptor.assume_init()
    };
    descriptor.struct_size = input.count(descriptor.struct_size, 0..200);
    for (axis, ordinary) in [3, 4, 5].into_iter().enumerate() {
        descriptor.dimensions[axis] = input.count(ordinary, 1..12);
    }
    for entry in &mut descriptor.index_to_world {
        *entry = input.number(*entry);
    }
    descriptor.calibration = input.code(descriptor.calibration);
    descriptor.thresholds = input.code(descriptor.thresholds);
    descriptor
}

/// All classes in a few voxels.
fn ordinary(voxel: usize) -> i16 {
    [0, 40, -820, 700, -1000, 1200, -1024, 3071][voxel % 8]
}

fn int16(input: &mut Input<'_>, voxel: usize) -> i16 {
    match input.byte() {
        ..192 => ordinary(voxel),
        byte @ 192..240 => i16::from(byte - 192) * 100 - 1100,
        240.. => i16::from_le_bytes([input.byte(), input.byte()]),
    }
}

fn label(input: &mut Input<'_>) -> u8 {
    match input.byte() {
        byte @ ..250 => byte % 4,
        byte => byte - 246,
    }
}

fn extent(descriptor: &DrrVolumeDescriptor) -> Extent {
    let map = |axis: usize, row: usize| descriptor.index_to_world[4 * axis + row];
    let n = descriptor.dimensions;
    let edge = |axis: usize| (0..3).map(|row| map(axis, row).powi(2)).sum::<f64>().sqrt() * n[axis] as f64;
    Extent {
        diagonal_mm: (0..3).map(edge).sum(),
        longest: n.into_iter().max().unwrap_or(0),
        centre: [0, 1, 2].map(|row| {
            map(3, row) + (0..3).map(|axis| map(axis, row) * (n[axis] as f64 - 1.0) / 2.0).sum::<f64>()
        }),
    }
}
