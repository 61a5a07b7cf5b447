//! The pictures that the demo writes.

use std::path::Path;

use libtest_mimic::Failed;

/// 16 bits of grey per pixel, two square views side by side.
pub(super) struct Picture {
    width: usize,
    height: usize,
    greys: Vec<u16>,
}

impl Picture {
    /// A PGM file.
    pub(super) fn read(path: &Path) -> Result<Self, Failed> {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut parts = bytes.splitn(4, |&byte| byte == b'\n');
        let mut next = || parts.next().ok_or("the file is cut off");
        let (kind, size, largest, pixels) = (next()?, next()?, next()?, next()?);
        let size = std::str::from_utf8(size)?.split_once(' ').ok_or("no size")?;
        let (width, height) = (size.0.parse()?, size.1.parse()?);
        if kind != b"P5" || largest != b"65535" || pixels.len() != 2 * width * height {
            return Err(format!("{}: not {width} x {height} pixels of 16 bits", path.display()).into());
        }
        let greys = pixels.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
        Ok(Self { width, height, greys })
    }

    /// Pixel (i, j) of a view, the first row above.
    fn at(&self, view: usize, i: usize, j: usize) -> f64 {
        f64::from(self.greys[j * self.width + view * self.height + i])
    }

    /// Mean of a view's pixels around a place given in parts of its side.
    fn around(&self, view: usize, x: f64, y: f64) -> f64 {
        let (side, half) = (self.height as f64, self.height / 50);
        let (i, j) = ((x * side) as usize, (y * side) as usize);
        let places = (i - half..=i + half).flat_map(|i| (j - half..=j + half).map(move |j| (i, j)));
        let greys: Vec<_> = places.map(|(i, j)| self.at(view, i, j)).collect();
        greys.iter().sum::<f64>() / greys.len() as f64
    }

    /// Two views of a chest: beside it black, its middle whiter than its lungs, and not twice the same view.
    fn is_a_chest(&self, side: usize, lungs: [f64; 2], height: f64) -> Result<(), Failed> {
        if [self.width, self.height] != [2 * side, side] {
            return Err(format!("{} x {} pixels", self.width, self.height).into());
        }
        for view in 0..2 {
            let beside = self.around(view, 0.03, 0.03);
            let lung = lungs.map(|x| self.around(view, x, height));
            let middle = self.around(view, 0.5, height);
            if !(beside < 1000.0 && lung.iter().all(|&lung| beside + 5000.0 < lung && lung + 5000.0 < middle))
            {
                return Err(format!("view {view}: beside {beside}, lungs {lung:?}, middle {middle}").into());
            }
        }
        let all = || (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
        let differ = all().filter(|&(i, j)| (self.at(0, i, j) - self.at(1, i, j)).abs() > 655.0).count();
        // A ninth of all is a third of the body.
        if differ < side * side / 9 {
            Err(format!("the views differ in {differ} pixels").into())
        } else {
            Ok(())
        }
    }

    /// The phantom: mirrored by its median plane, so are its two views.
    pub(super) fn is_a_symmetric_chest(&self, side: usize) -> Result<(), Failed> {
        self.is_a_chest(side, [0.33, 0.67], 0.4)?;
        let pixels = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
        let difference = pixels.map(|(i, j)| (self.at(0, i, j) - self.at(1, side - 1 - i, j)).abs());
        let largest = difference.fold(0.0, f64::max);
        // Rounded to a level each, from float32.
        if largest > 2.0 { Err(format!("mirrored, the views differ by {largest}").into()) } else { Ok(()) }
    }

    /// The CT: seen from the front with the head up, the heart is to the right, in both views.
    pub(super) fn is_a_real_chest(&self, side: usize) -> Result<(), Failed> {
        self.is_a_chest(side, [0.3, 0.65], 0.35)?;
        let heart = |view| self.around(view, 0.62, 0.48) - self.around(view, 0.38, 0.48);
        if heart(0) > 8000.0 && heart(1) > 8000.0 {
            return Ok(());
        }
        Err(format!("heart against its mirror image: {}, {}", heart(0), heart(1)).into())
    }
}
