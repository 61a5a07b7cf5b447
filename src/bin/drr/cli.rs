//! The command line.

use clap::{Parser, Subcommand};

const ABOUT: &str = "\
X-ray projections (digitally reconstructed radiographs) of CT volumes: cone beam, poly-energetic, with the error measured.

Without a subcommand, `drr` projects the CT that it carries (a chest, LIDC-IDRI-0001 at low resolution) into two views
of 720x720 pixels at -6 and +6 degrees, 120 kVp, and writes images, picture and plan to ./drr-output.

World: LPS (x to the patient's left, y to the back, z to the head), mm. Energies: keV. Angles: degrees.";

const EXAMPLES: &str = "\
Examples:
  drr                                                     the main job on the built-in CT
  drr project --ct chest.nii.gz --output out              two views of a CT of your own
  drr project --ct scans/chest --report                   a folder of DICOM; a page about the run
  drr project --ct chest.raw --dims 512,512,300 --spacing 0.7,0.7,1 --angles -6,0,6 --raw --output out
  drr project --ct chest.nii.gz --engine reference --algorithm exact --size 90x90 --output truth
  drr project --ct chest.nii.gz --formats tiff,png16 --report
                                                          images for other programs; the run on one page, report.html
  drr plan --ct chest.nii.gz                              what would run, and why
  drr tradeoff --ct chest.nii.gz                          what accuracy costs in time: a table, a chart, error maps
  drr project --ct chest.nii.gz --tolerance-hu 2          the cheapest method that keeps an error
  drr project --ct chest.nii.gz --views views.csv --shard 1/2  the views of a table, by two processes: project --help
  drr project --fall-off --scatter --blur 0.2 --photons 5000 --detector top_energy,bottom_energy
                                                          effects, each asked for; both layers of a panel
  drr plan --focal-spot 0.6 --scatter --measure           what they cost on this machine, stage by stage
  drr effects                                             what every effect costs: a table, a chart, a contact sheet
  drr rounding                                            how rounding grows along a ray, and what it costs to stop it
  drr align --ct chest.nii.gz                             misaligned views of a parallel beam find where they are
  drr reconstruct                                         a volume from 60 views: slices, convergence
  drr reconstruct --joint                                 ... which are misaligned
  drr register --capture-range                            where a CT is, from its stereo pair; from how far off
  drr align --check                                       its derivatives against differences
  drr bench --json                                        how long each stage takes
  drr phantom thorax --noise --size 720,720,665 --output thorax.nii
  drr validate                                            the measured error against closed forms
  drr check                                               the hard cases on this machine, against exact arithmetic
  drr manual --output ~/.local/share/man/man1             manual pages: man drr-project
  drr completions bash > ~/.local/share/bash-completion/completions/drr

Exit codes: 0 done; 1 a validation or a check failed, or memory ran out; 2 an argument or an input is not valid.";

/// The arguments of the command.
#[derive(Debug, Parser)]
#[command(name = "drr", version, about = "X-ray projections (DRRs) of CT volumes", long_about = ABOUT)]
#[command(after_help = EXAMPLES, max_term_width = 110)]
pub(crate) struct Cli {
    /// Print nothing but errors and what was asked for (--json, --list); no progress bars.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Project a CT: images (OpenEXR, PNG, TIFF, DICOM), a picture, the plan and, with --report, a page about it all.
    Project(crate::project::Arguments),
    /// Print what `project` would run with the same inputs, and why; what it may run depends on --layers.
    Plan(crate::plan::Arguments),
    /// Measure what accuracy costs in time: every method, timed and held to exact integrals.
    Tradeoff(crate::tradeoff::Arguments),
    /// Measure what each effect costs in time beside the plain projection.
    Effects(crate::effects::Arguments),
    /// Reconstruct a volume from its views, simulated or measured; with --joint, views that are misaligned.
    Reconstruct(crate::reconstruct::Arguments),
    /// Find where an object is from cone-beam images of it and its CT: 2D/3D registration of six parameters.
    Register(crate::register::Arguments),
    /// Measure how the rounding of sums grows with the length of a ray.
    Rounding(crate::rounding::Arguments),
    /// Align views of a parallel beam to a volume, or check the derivatives that this needs.
    Align(crate::align::Arguments),
    /// Time every stage of a projection, with a pass over the memory for comparison.
    Bench(crate::bench::Arguments),
    /// Write a phantom with known line integrals as a NIfTI volume.
    Phantom(crate::phantom::Arguments),
    /// Measure the errors of rods, a water cylinder and spheres against their closed forms.
    Validate(crate::validate::Arguments),
    /// Run the hard cases on the engines of this machine, against exact arithmetic.
    Check(crate::check::Arguments),
    /// Write the manual pages of the command and its subcommands, for man.
    Manual(crate::manual::Arguments),
    /// Print what a shell completes arguments by.
    Completions(crate::completions::Arguments),
}
