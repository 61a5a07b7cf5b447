//! The quantile of the normal distribution.

/// |u − 1/2| up to which the central approximation holds.
const CENTRE: f64 = 0.425;
/// √(−ln of the tail's probability) from which the far approximation holds.
const FAR: f64 = 5.0;

// Numerators and denominators of Wichura's PPND16, lowest power first.
#[expect(clippy::excessive_precision, reason = "the digits are those printed")]
const CENTRAL: [[f64; 8]; 2] = [
    [
        3.387_132_872_796_366_608,
        1.331_416_678_917_843_774_5e2,
        1.971_590_950_306_551_442_7e3,
        1.373_169_376_550_946_112_5e4,
        4.592_195_393_154_987_145_7e4,
        6.726_577_092_700_870_085_3e4,
        3.343_057_558_358_812_810_5e4,
        2.509_080_928_730_122_672_7e3,
    ],
    [
        1.0,
        4.231_333_070_160_091_125_2e1,
        6.871_870_074_920_579_083e2,
        5.394_196_021_424_751_107_7e3,
        2.121_379_430_158_659_586_7e4,
        3.930_789_580_009_271_061e4,
        2.872_908_573_572_194_267_4e4,
        5.226_495_278_852_854_561e3,
    ],
];
#[expect(clippy::excessive_precision, reason = "the digits are those printed")]
const TAIL: [[f64; 8]; 2] = [
    [
        1.423_437_110_749_683_577_34,
        4.630_337_846_156_545_295_9,
        5.769_497_221_460_691_405_5,
        3.647_848_324_763_204_605_04,
        1.270_458_252_452_368_382_58,
        2.417_807_251_774_506_117_7e-1,
        2.272_384_498_926_918_458_33e-2,
        7.745_450_142_783_414_076_4e-4,
    ],
    [
        1.0,
        2.053_191_626_637_758_821_87,
        1.676_384_830_183_803_849_4,
        6.897_673_349_851_000_045_5e-1,
        1.481_039_764_274_800_745_9e-1,
        1.519_866_656_361_645_719_66e-2,
        5.475_938_084_995_344_946e-4,
        1.050_750_071_644_416_843_24e-9,
    ],
];
#[expect(clippy::excessive_precision, reason = "the digits are those printed")]
const FAR_TAIL: [[f64; 8]; 2] = [
    [
        6.657_904_643_501_103_777_2,
        5.463_784_911_164_114_369_9,
        1.784_826_539_917_291_335_8,
        2.965_605_718_285_048_912_3e-1,
        2.653_218_952_657_612_309_3e-2,
        1.242_660_947_388_078_438_6e-3,
        2.711_555_568_743_487_578_15e-5,
        2.010_334_399_292_288_132_65e-7,
    ],
    [
        1.0,
        5.998_322_065_558_879_376_9e-1,
        1.369_298_809_227_358_053_1e-1,
        1.487_536_129_085_061_485_25e-2,
        7.868_691_311_456_132_591e-4,
        1.846_318_317_510_054_681_8e-5,
        1.421_511_758_316_445_888_7e-7,
        2.044_263_103_389_939_785_64e-15,
    ],
];

/// The z that a standard normal number is below with probability `u`, 0 < u < 1, to about 1e-15 of its size.
///
/// M. J. Wichura, Algorithm AS 241, Appl. Statist. 37 (1988) 477–484: PPND16.
pub(crate) fn normal_quantile(u: f64) -> f64 {
    let q = u - 0.5;
    if q.abs() <= CENTRE {
        return q * ratio(&CENTRAL, CENTRE * CENTRE - q * q);
    }
    let tail = if q < 0.0 { u } else { 1.0 - u };
    let r = (-tail.ln()).sqrt();
    // 1.6 and 5 are the points about which Wichura expands.
    let z = if r <= FAR { ratio(&TAIL, r - 1.6) } else { ratio(&FAR_TAIL, r - FAR) };
    z.copysign(q)
}

fn ratio([numerator, denominator]: &[[f64; 8]; 2], x: f64) -> f64 {
    polynomial(numerator, x) / polynomial(denominator, x)
}

/// `coefficients[0] + coefficients[1] x + …` by Horner's rule.
pub(super) fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_forty_digits() {
        // √2 erf⁻¹(2u − 1) with 40 digits, at u that are exact in binary.
        for (u, z) in [
            (0.25, -0.674_489_750_196_081_7),
            (0.875, 1.150_349_380_376_008),
            (0.073_242_187_5, -1.452_061_970_245_572_6),
            (0.075_195_312_5, -1.438_153_079_003_016_1),
            (2.0_f64.powi(-10), -3.097_269_078_198_784_6),
            (2.0_f64.powi(-30), -6.009_353_565_530_744),
            (2.0_f64.powi(-36), -6.651_035_379_893_011),
            (2.0_f64.powi(-37), -6.752_300_431_407_015),
            (2.0_f64.powi(-53), -8.209_536_151_601_387),
            (2.0_f64.powi(-1000), -37.111_011_937_164_79),
        ] {
            let error = normal_quantile(u) / z - 1.0;
            assert!(error.abs() < 1e-15, "{u:e}: {error:e}");
        }
        assert_eq!(normal_quantile(0.5), 0.0);
    }

    #[test]
    fn the_two_tails_mirror_each_other() {
        for k in 1..1000 {
            let u = f64::from(k) / 2048.0;
            assert_eq!(normal_quantile(u), -normal_quantile(1.0 - u));
        }
    }
}
