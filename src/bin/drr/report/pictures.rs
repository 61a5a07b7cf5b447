//! The pictures of a report, in it.

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use drr::formats::{ColourPicture, SixteenBits};
use drr::geometry::PatientOrientation;

use super::Report;
use super::html::Html;
use crate::certificate::short;
use crate::charts::mark_sides;
use crate::charts::thinned;

/// Columns or rows of a layer's picture, and columns of the large one, at most.
const SMALL: usize = 320;
const LARGE: usize = 2400;

/// A layer as a picture.
pub(crate) struct Layer {
    name: String,
    unit: &'static str,
    picture: ColourPicture,
    /// The values that are black and white.
    ends: [f64; 2],
}

impl Layer {
    /// Of values with the head up, `size` pixels of them: from the least, or 0, in black to the largest in white.
    pub(crate) fn new(
        name: String,
        unit: &'static str,
        values: &[f32],
        [width, height]: [usize; 2],
        sides: PatientOrientation,
    ) -> Result<Self> {
        let SixteenBits { offset, scale, samples } = SixteenBits::of(values);
        let pixels = samples.into_iter().map(|sample| [(sample >> 8) as u8; 3]).collect();
        let full = ColourPicture { width, height, pixels };
        let mut picture = thinned(&full, width.max(height).div_ceil(SMALL));
        let size = [picture.width, picture.height];
        mark_sides(&mut picture, [0, 0], size, sides)?;
        Ok(Self { name, unit, picture, ends: [offset, offset + scale * f64::from(u16::MAX)] })
    }

    fn figure(&self) -> Result<Html> {
        let [black, white] = self.ends.map(short);
        let bar = Html::element("div", &[("class", "bar")], []);
        let ends =
            Html::element("div", &[("class", "ends")], [black, white].map(|end| Html::of("span", end)));
        let unit = if self.unit == "1" { "no unit" } else { self.unit };
        let caption = Html::of("figcaption", format!("{}, {unit}", self.name));
        Ok(Html::element("figure", &[], [image(&self.picture, &self.name)?, bar, ends, caption]))
    }
}

impl Report<'_> {
    pub(super) fn pictures(&self) -> Result<Html> {
        let large = thinned(self.picture, self.picture.width.div_ceil(LARGE));
        let what =
            "Line integrals with the head up, bone bright, in one window. Letters: the patient's sides.";
        let figure = [image(&large, "radiographs of the first views")?, Html::of("figcaption", what)];
        let mut parts = vec![Html::element("figure", &[("class", "main")], figure)];
        for (view, layers) in self.layers.iter().enumerate() {
            let named = self.views.named(view);
            let shown = self.views.upright_orientation(view);
            parts.push(Html::of("h3", format!("{}, {shown}", named.name)));
            let figures = layers.iter().map(Layer::figure).collect::<Result<Vec<_>>>()?;
            parts.push(Html::element("div", &[("class", "layers")], figures));
        }
        let more = self.views.poses.len() - self.layers.len();
        if more > 0 {
            parts.push(Html::of("p", format!("{more} more view(s) are in files alone.")));
        }
        Ok(parts.into_iter().collect())
    }
}

fn image(picture: &ColourPicture, text: &str) -> Result<Html> {
    let source = format!("data:image/png;base64,{}", STANDARD.encode(picture.png()?));
    let [width, height] = [picture.width, picture.height].map(|side| side.to_string());
    let attributes = [("src", source.as_str()), ("alt", text), ("width", &width), ("height", &height)];
    Ok(Html::element("img", &attributes, []))
}

#[cfg(test)]
mod tests {
    use drr::geometry::DetectorPose;
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_bar_goes_from_what_is_black_to_what_is_white() {
        let sides = PatientOrientation::of(&DetectorPose::c_arm(DVec3::ZERO, 0.0, 1.0, 2.0, 1.0, [2, 2]));
        let layer = Layer::new("bone_path".into(), "mm", &[0.0, 1.0, 2.0, 4.0], [2, 2], sides).unwrap();
        assert_eq!(layer.picture.pixels, [[0; 3], [64; 3], [128; 3], [255; 3]]);
        let figure = format!("{:?}", layer.figure().unwrap());
        assert!(figure.contains("<span>0.000</span><span>4.000</span>"), "{figure}");
        assert!(figure.contains("bone_path, mm") && figure.contains("data:image/png;base64,"), "{figure}");
    }

    #[test]
    fn pictures_of_layers_are_small_whatever_the_detector() {
        let sides = PatientOrientation::of(&DetectorPose::c_arm(DVec3::ZERO, 0.0, 1.0, 2.0, 1.0, [2, 2]));
        let layer = Layer::new("p".into(), "1", &vec![1.0; 5000 * 7], [5000, 7], sides).unwrap();
        assert!(layer.picture.width <= SMALL && layer.picture.height == 1);
    }
}
