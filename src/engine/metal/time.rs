//! How long the GPU worked.

use std::ptr::NonNull;

use objc2::rc::Retained;
use objc2::runtime::ProtocolObject;
use objc2_foundation::NSRange;
use objc2_metal::{
    MTLCommandBuffer, MTLCommonCounterSetTimestamp, MTLComputePassDescriptor, MTLCounterSampleBuffer,
    MTLCounterSampleBufferDescriptor, MTLCounterSamplingPoint, MTLCounterSet, MTLDevice, MTLStorageMode,
};

/// Nanoseconds of the host and ticks of the GPU at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    host: u64,
    gpu: u64,
}

impl Moment {
    fn now(device: &ProtocolObject<dyn MTLDevice>) -> Self {
        let (mut host, mut gpu) = (0, 0);
        // SAFETY: places for one number each.
        unsafe { device.sampleTimestamps_gpuTimestamp(NonNull::from(&mut host), NonNull::from(&mut gpu)) };
        Self { host, gpu }
    }
}

/// Measures one pass of one command buffer: by the GPU's own counters at its start and end where it has them, by the
/// command buffer's times elsewhere.
pub(super) struct Stopwatch {
    counters: Option<(Retained<ProtocolObject<dyn MTLCounterSampleBuffer>>, Moment)>,
}

impl Stopwatch {
    /// To be attached before the pass is encoded.
    pub(super) fn new(device: &ProtocolObject<dyn MTLDevice>) -> Self {
        let counters = samples(device).map(|samples| (samples, Moment::now(device)));
        Self { counters }
    }

    /// Makes the pass leave its times.
    pub(super) fn attach(&self, pass: &MTLComputePassDescriptor) {
        if let Some((samples, _)) = &self.counters {
            // SAFETY: a pass has at least one attachment, and the buffer two samples.
            unsafe {
                let attachment = pass.sampleBufferAttachments().objectAtIndexedSubscript(0);
                attachment.setSampleBuffer(Some(samples));
                attachment.setStartOfEncoderSampleIndex(0);
                attachment.setEndOfEncoderSampleIndex(1);
            }
        }
    }

    /// Seconds that the pass took, once its command buffer has completed.
    pub(super) fn seconds(
        &self,
        device: &ProtocolObject<dyn MTLDevice>,
        commands: &ProtocolObject<dyn MTLCommandBuffer>,
    ) -> f64 {
        let counted = self.counters.as_ref().and_then(|(samples, before)| {
            let after = Moment::now(device);
            // SAFETY: there are two samples.
            let data = unsafe { samples.resolveCounterRange(NSRange::new(0, 2)) }?.to_vec();
            let ticks: Vec<_> =
                data.chunks_exact(8).map(|b| u64::from_ne_bytes(b.try_into().unwrap_or([0xff; 8]))).collect();
            seconds([*ticks.first()?, *ticks.get(1)?], *before, after)
        });
        counted.unwrap_or_else(|| commands.GPUEndTime() - commands.GPUStartTime())
    }
}

/// Room for two times, if the GPU can tell them.
fn samples(
    device: &ProtocolObject<dyn MTLDevice>,
) -> Option<Retained<ProtocolObject<dyn MTLCounterSampleBuffer>>> {
    if !device.supportsCounterSampling(MTLCounterSamplingPoint::AtStageBoundary) {
        return None;
    }
    // SAFETY: a constant string of the framework.
    let timestamps = unsafe { MTLCommonCounterSetTimestamp };
    let set = device.counterSets()?.iter().find(|set| &*set.name() == timestamps)?;
    let descriptor = MTLCounterSampleBufferDescriptor::new();
    descriptor.setCounterSet(Some(&set));
    descriptor.setStorageMode(MTLStorageMode::Shared);
    // SAFETY: every GPU with counters has room for two.
    unsafe { descriptor.setSampleCount(2) };
    device.newCounterSampleBufferWithDescriptor_error(&descriptor).ok()
}

/// Seconds from one tick to another, by what passed between two moments; none when a counter failed or stood still.
fn seconds([start, end]: [u64; 2], before: Moment, after: Moment) -> Option<f64> {
    const FAILED: u64 = u64::MAX;
    let (host, gpu) = (after.host.checked_sub(before.host)?, after.gpu.checked_sub(before.gpu)?);
    let ticks = end.checked_sub(start).filter(|_| start != FAILED && end != FAILED && gpu > 0)?;
    Some(ticks as f64 * (host as f64 / gpu as f64) * 1e-9)
}
