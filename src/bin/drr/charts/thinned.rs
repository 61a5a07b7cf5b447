//! Pictures with fewer pixels.

use drr::formats::ColourPicture;

/// Means of blocks of `stride`×`stride` pixels; those at the right and lower edge may be smaller.
pub(crate) fn thinned(picture: &ColourPicture, stride: usize) -> ColourPicture {
    let stride = stride.max(1);
    let [width, height] = [picture.width, picture.height].map(|side| side.div_ceil(stride));
    let block = |n: usize| {
        let [left, top] = [n % width * stride, n / width * stride];
        let (right, bottom) = ((left + stride).min(picture.width), (top + stride).min(picture.height));
        let rows = (top..bottom).map(|row| &picture.pixels[row * picture.width..][left..right]);
        let sums = rows.flatten().fold([0; 3], |sums: [usize; 3], pixel| {
            std::array::from_fn(|channel| sums[channel] + usize::from(pixel[channel]))
        });
        let count = (right - left) * (bottom - top);
        sums.map(|sum| ((sum + count / 2) / count) as u8)
    };
    ColourPicture { width, height, pixels: (0..width * height).map(block).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_become_their_means_also_at_the_edges() {
        let pixels = (0..5 * 3).map(|n| [n, 2 * n, 10]).collect();
        let picture = ColourPicture { width: 5, height: 3, pixels };
        assert_eq!(thinned(&picture, 1), picture);
        assert_eq!(thinned(&picture, 0), picture);
        let thin = thinned(&picture, 2);
        assert_eq!((thin.width, thin.height), (3, 2));
        // Of 0, 1, 5 and 6; of 4 and 9; of 14 alone.
        assert_eq!(
            [thin.pixel(0, 0), thin.pixel(2, 0), thin.pixel(2, 1)],
            [[3, 6, 10], [7, 13, 10], [14, 28, 10]]
        );
    }
}
