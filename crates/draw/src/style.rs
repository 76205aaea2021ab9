//! The one style of all figures: colours, pens, sizes.
//!
//! Colours are told apart by readers with any common colour blindness: the categorical ones are
//! Paul Tol's "vibrant" scheme (Tol, *Colour Schemes*, SRON/EPS/TN/09-002, 2021), the diverging
//! ones ColorBrewer's "PuOr" (Harrower & Brewer 2003, doi:10.1179/000870403235002042).

/// An sRGB colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
pub struct Colour {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
}

impl Colour {
    /// From `0xRRGGBB`.
    pub(crate) const fn hex(rgb: u32) -> Self {
        Self { r: (rgb >> 16) as u8, g: (rgb >> 8) as u8, b: rgb as u8 }
    }

    /// The colour on the straight way from `self` (0) to `other` (1).
    pub(crate) fn mix(self, other: Self, share: f64) -> Self {
        let channel =
            |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
        Self {
            r: channel(self.r, other.r),
            g: channel(self.g, other.g),
            b: channel(self.b, other.b),
        }
    }
}

/// Text, axes and curves that belong to no mode: a soft black.
pub const INK: Colour = Colour::hex(0x22_22_22);
/// The darkest text, for coloured grounds.
const BLACK: Colour = Colour::hex(0);
/// Reference lines and small print.
pub const GREY: Colour = Colour::hex(0x6b_6b_6b);
/// Grid lines.
pub const GRID: Colour = Colour::hex(0xe4_e4_e4);
/// Paper.
pub const PAPER: Colour = Colour::hex(0xff_ff_ff);
/// The stamp at a figure's head.
pub const MARK: Colour = Colour::hex(0xb3_26_00);

/// Paul Tol's "vibrant" scheme without its grey.
const MODES: [Colour; 6] = [
    Colour::hex(0x00_77_bb), // blue
    Colour::hex(0xee_77_33), // orange
    Colour::hex(0x00_99_88), // teal
    Colour::hex(0xee_33_77), // magenta
    Colour::hex(0x33_bb_ee), // cyan
    Colour::hex(0xcc_33_11), // red
];

/// The brake, in figures of forces by part.
pub const BRAKE: Colour = MODES[0];
/// The motor, in figures of forces by part.
pub const MOTOR: Colour = MODES[5];
/// The fingertip's tissue, in figures of forces by part.
pub const TISSUE: Colour = MODES[2];

/// The colour of the study's `index`-th mode, the same in every figure. After the sixth they start
/// again.
pub fn mode_colour(index: usize) -> Colour {
    MODES[index % MODES.len()]
}

/// Paul Tol's "muted" scheme: told apart from the modes' colours too.
const ENVIRONMENTS: [Colour; 7] = [
    Colour::hex(0x33_22_88), // indigo
    Colour::hex(0x99_99_33), // olive
    Colour::hex(0x88_22_55), // wine
    Colour::hex(0x44_aa_99), // pale teal
    Colour::hex(0xcc_66_77), // rose
    Colour::hex(0x11_77_33), // green
    Colour::hex(0xaa_44_99), // purple
];

/// The colour of the study's `index`-th environment, where curves of one mode differ by
/// environment.
pub fn environment_colour(index: usize) -> Colour {
    ENVIRONMENTS[index % ENVIRONMENTS.len()]
}

/// The colour of the `index`-th of `count` repeats of one mode: from a dark to a light shade of the
/// mode's own.
pub fn repeat_colour(mode: Colour, index: usize, count: usize) -> Colour {
    /// How far the outermost shades are mixed with black and with white.
    const REACH: f64 = 0.5;
    let place = if count < 2 { 0.0 } else { 2.0 * index as f64 / (count - 1) as f64 - 1.0 };
    let end = if place < 0.0 { Colour::hex(0) } else { PAPER };
    mode.mix(end, REACH * place.abs())
}

/// Colour of answer `index` of `count`, from the most negative (orange-brown) over a light grey to
/// the most positive (violet).
pub fn likert_colour(index: usize, count: usize) -> Colour {
    const NEUTRAL: Colour = Colour::hex(0xe6_e6_e6);
    const NEGATIVE: [Colour; 3] = [NEUTRAL, Colour::hex(0xfd_b8_63), Colour::hex(0xe6_61_01)];
    const POSITIVE: [Colour; 3] = [NEUTRAL, Colour::hex(0xb2_ab_d2), Colour::hex(0x5e_3c_99)];
    let middle = count.saturating_sub(1) as f64 / 2.0;
    let place = if count < 2 { 0.0 } else { (index as f64 - middle) / middle };
    let side = if place < 0.0 { NEGATIVE } else { POSITIVE };
    match 2.0 * place.abs() {
        along if along <= 1.0 => side[0].mix(side[1], along),
        along => side[1].mix(side[2], (along - 1.0).min(1.0)),
    }
}

/// Black or white, whichever stands out more against `ground` (contrast ratio of WCAG 2.2, §1.4.3).
pub fn text_on(ground: Colour) -> Colour {
    let contrast = |colour| {
        let (a, b) = (luminance(colour), luminance(ground));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    };
    if contrast(BLACK) >= contrast(PAPER) { BLACK } else { PAPER }
}

/// Relative luminance of an sRGB colour, 0 … 1 (WCAG 2.2).
fn luminance(colour: Colour) -> f64 {
    let linear = |channel: u8| {
        let c = f64::from(channel) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
    };
    0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b)
}

/// How a pen draws along its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Without a break.
    #[default]
    Solid,
    /// Dashes.
    Dashed,
    /// A dash and a short one in turn.
    DashDotted,
    /// Long dashes.
    LongDashed,
    /// Round dots: kept for what is commanded, and for what lies at a wall or past it.
    Dotted,
    /// Round dots in twos.
    InTwos,
    /// Round dots in threes.
    InThrees,
    /// Round dots far apart.
    FarApart,
}

/// Distance of dots, in widths of the pen.
const DOT: f64 = 2.1;
/// Dots after which the rhythms begin again, all on one beat: where curves lie on each other along
/// the page, dots in twos, in threes and far apart stand beside each other.
const BEAT: usize = 6;

impl Dash {
    /// Which dots of a beat are drawn; none for what has dashes.
    fn dots(self) -> &'static [usize] {
        match self {
            Self::Dotted => &[0, 1, 2, 3, 4, 5],
            Self::InTwos => &[0, 1],
            Self::InThrees => &[2, 3, 4],
            Self::FarApart => &[5],
            _ => &[],
        }
    }

    /// The dots of a curve with these dashes, so that curves stay apart where all are dotted.
    pub fn dotted(self) -> Self {
        match self {
            Self::Dashed => Self::InTwos,
            Self::DashDotted => Self::InThrees,
            Self::LongDashed => Self::FarApart,
            _ => Self::Dotted,
        }
    }
}

/// The dashes of curves that differ by colour too, so that print in grey tells them apart: of the
/// study's `index`-th mode, or of whatever else a figure counts. After the fourth they start again.
pub fn dash(index: usize) -> Dash {
    [Dash::Solid, Dash::Dashed, Dash::DashDotted, Dash::LongDashed][index % 4]
}

/// The marker of the `index`-th of what a figure counts, likewise. After the third they start
/// again.
pub fn marker(index: usize) -> Marker {
    [Marker::Disc, Marker::Square, Marker::Diamond][index % 3]
}

/// A pen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Ink.
    pub colour: Colour,
    /// Width on paper.
    pub width_pt: f64,
    /// 0 (not seen) to 1 (solid).
    pub opacity: f64,
    /// Solid, dashed or dotted.
    pub dash: Dash,
    /// How far into its dashes the pen begins, pt.
    pub from_pt: f64,
}

impl Stroke {
    /// Lengths of dashes and gaps in turn, in pt; nothing for a pen that does not break.
    pub(crate) fn dashes_pt(&self) -> Option<Vec<f64>> {
        let widths: &[f64] = match self.dash {
            Dash::Solid => return None,
            Dash::Dashed => &[4.0, 2.5],
            Dash::DashDotted => &[6.0, 2.0, 1.5, 2.0],
            Dash::LongDashed => &[9.0, 2.5],
            dotted => return Some(self.gaps_pt(dotted.dots())),
        };
        Some(widths.iter().map(|width| width * self.width_pt).collect())
    }

    /// Dots at these places of a beat, from the first of them on: dashes of almost no length under
    /// round ends.
    fn gaps_pt(&self, dots: &[usize]) -> Vec<f64> {
        const LENGTH_PT: f64 = 0.01;
        let next = |i: usize| dots.get(i + 1).copied().unwrap_or(dots[0] + BEAT);
        // Every dot of a beat alike: one dash and one gap say it.
        let shown = if dots.len() == BEAT { 1 } else { dots.len() };
        let gap = |i: usize| (next(i) - dots[i]) as f64 * DOT * self.width_pt - LENGTH_PT;
        (0..shown).flat_map(|i| [LENGTH_PT, gap(i)]).collect()
    }

    pub(crate) fn round_ends(&self) -> bool {
        !self.dash.dots().is_empty()
    }

    /// The same pen for a curve that begins at `x_pt` of the page: dots along the page stand where
    /// those of any other curve with a pen of this width do.
    pub(crate) fn on_beat(self, x_pt: f64) -> Self {
        let Some(first) = self.dash.dots().first() else { return self };
        let dot_pt = DOT * self.width_pt;
        let from_pt = (x_pt - *first as f64 * dot_pt).rem_euclid(BEAT as f64 * dot_pt);
        Self { from_pt, ..self }
    }

    /// The same pen with other dashes.
    pub fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }
}

impl Default for Stroke {
    fn default() -> Self {
        mean(INK)
    }
}

/// Shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marker {
    /// Filled circle.
    #[default]
    Disc,
    /// Filled square.
    Square,
    /// Filled square standing on a corner.
    Diamond,
}

/// Pen of a mean, a fit, or any curve that carries the message.
pub const fn mean(colour: Colour) -> Stroke {
    Stroke { colour, width_pt: 1.1, opacity: 1.0, dash: Dash::Solid, from_pt: 0.0 }
}

/// Pen of one repeat behind the mean of all.
pub const fn faint(colour: Colour) -> Stroke {
    Stroke { colour, width_pt: 0.5, opacity: 0.32, dash: Dash::Solid, from_pt: 0.0 }
}

/// Pen of one repeat where the repeats are the message.
pub const fn single(colour: Colour) -> Stroke {
    Stroke { colour, width_pt: 0.8, opacity: 1.0, dash: Dash::Solid, from_pt: 0.0 }
}

/// Pen of what was commanded, beside what was measured.
pub const fn commanded() -> Stroke {
    Stroke { colour: INK, width_pt: 0.9, opacity: 1.0, dash: Dash::Dotted, from_pt: 0.0 }
}

/// Pen of a reference line.
pub const fn reference() -> Stroke {
    Stroke { colour: GREY, width_pt: 0.6, opacity: 1.0, dash: Dash::Dashed, from_pt: 0.0 }
}

/// Pen of the line that marks zero.
pub const fn zero() -> Stroke {
    Stroke { colour: INK, width_pt: AXIS_PT, opacity: 1.0, dash: Dash::Solid, from_pt: 0.0 }
}

/// Opacity of a band: three that overlap are still told apart.
pub const BAND_OPACITY: f64 = 0.2;
/// Diameter of a single point, in pt.
pub const POINT_PT: f64 = 2.6;
/// Diameter of the marker at an estimate, in pt.
pub const MARKER_PT: f64 = 4.2;
/// Width of a whisker, in pt.
pub const WHISKER_PT: f64 = 1.0;
/// Width of axes and ticks, in pt.
pub const AXIS_PT: f64 = 0.6;
/// Width of grid lines, in pt.
pub const GRID_PT: f64 = 0.4;
/// Length of a tick, outwards, in pt.
pub const TICK_PT: f64 = 2.6;

/// Size of the figure's heading, in pt.
pub const TITLE_PT: f64 = 9.0;
/// Size of axis labels and panel headings, in pt.
pub const LABEL_PT: f64 = 8.0;
/// Size of tick labels, legends, notes and small print, in pt.
pub const SMALL_PT: f64 = 7.0;
/// The smallest size that text is shrunk to where room is short, in pt.
pub const LEAST_PT: f64 = 5.5;

#[cfg(test)]
mod tests {
    use super::*;

    fn contrast(a: Colour, b: Colour) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// Each channel of a colour, 0 … 1, by a matrix on linear sRGB: Machado, Oliveira & Fernandes
    /// 2009 (doi:10.1109/TVCG.2009.113), deuteranopia of severity 1.
    fn without_green_cones(colour: Colour) -> [f64; 3] {
        const MATRIX: [[f64; 3]; 3] = [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ];
        let linear = |channel: u8| {
            let c = f64::from(channel) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
        };
        let from = [colour.r, colour.g, colour.b].map(linear);
        MATRIX.map(|row| {
            let sum: f64 = row.iter().zip(from).map(|(a, c)| a * c).sum();
            sum.clamp(0.0, 1.0)
        })
    }

    /// CIELAB of linear sRGB (white point D65).
    fn lab([r, g, b]: [f64; 3]) -> [f64; 3] {
        let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
        let [x, y, z] =
            [x, y, z].map(|t| if t > 0.008856 { libm::cbrt(t) } else { 7.787 * t + 16.0 / 116.0 });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Ten times what is just seen side by side (CIE76), for the three modes of the thesis.
    #[test]
    fn the_first_three_modes_are_told_apart_without_green_cones_and_by_dashes_without_colour() {
        let seen: Vec<[f64; 3]> =
            (0..3).map(|i| lab(without_green_cones(mode_colour(i)))).collect();
        for (i, a) in seen.iter().enumerate() {
            for b in &seen[..i] {
                let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
                let apart = squares.sum::<f64>().sqrt();
                assert!(apart > 23.0, "{apart}");
            }
        }
        let dashes: Vec<Dash> = (0..4).map(dash).collect();
        assert!((0..4).all(|i| !dashes[..i].contains(&dashes[i]) && dashes[i] != Dash::Dotted));
    }

    #[test]
    fn dots_of_curves_that_lie_on_each_other_stand_beside_each_other() {
        let pen = mean(INK);
        let along = |dash: Dash, x_pt: f64| -> Vec<f64> {
            let pen = pen.dashed(dash.dotted()).on_beat(x_pt);
            let steps = pen.dashes_pt().unwrap();
            let mut at = x_pt - pen.from_pt;
            let mut dots = Vec::new();
            for (i, step) in steps.iter().cycle().take(40 * steps.len()).enumerate() {
                if i % 2 == 0 && at >= x_pt {
                    dots.push(at);
                }
                at += step;
            }
            dots
        };
        let (twos, threes) = (along(Dash::Dashed, 31.7), along(Dash::DashDotted, 12.3));
        let few = along(Dash::LongDashed, 100.0);
        assert!(twos.len() > 20 && threes.len() > 20 && few.len() > 20);
        let all = [&twos, &threes, &few];
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                let apart = |x: &f64| b.iter().map(|y| (x - y).abs()).fold(f64::MAX, f64::min);
                let least = a.iter().map(apart).fold(f64::MAX, f64::min);
                assert!(least > 0.99 * DOT * pen.width_pt, "{least}");
            }
        }
        let every = along(Dash::Solid, 0.0);
        assert!((every[9] - every[8] - DOT * pen.width_pt).abs() < 1e-9);
        assert_eq!(mean(INK).on_beat(5.0).from_pt, 0.0, "a pen that does not break has no beat");
    }

    #[test]
    fn text_in_every_likert_box_has_the_contrast_that_wcag_asks_for() {
        for count in 2..=11 {
            for index in 0..count {
                let ground = likert_colour(index, count);
                let ratio = contrast(text_on(ground), ground);
                assert!(ratio >= 4.5, "answer {index} of {count}: {ratio:.2}");
            }
        }
    }

    #[test]
    fn contrast_of_black_on_white_is_twenty_one() {
        assert!((contrast(Colour::hex(0), PAPER) - 21.0).abs() < 1e-12);
    }

    #[test]
    fn modes_keep_their_colour_and_start_again_after_the_last() {
        assert_eq!(mode_colour(0), Colour::hex(0x00_77_bb));
        assert_eq!(mode_colour(6), mode_colour(0));
    }

    #[test]
    fn repeats_of_a_mode_are_all_different() {
        let mut shades: Vec<_> = (0..6).map(|i| repeat_colour(mode_colour(0), i, 6)).collect();
        shades.sort();
        shades.dedup();
        assert_eq!(shades.len(), 6);
        assert_eq!(repeat_colour(mode_colour(0), 0, 1), mode_colour(0));
    }

    #[test]
    fn the_middle_answer_is_grey_and_the_ends_are_the_schemes_own() {
        let middle = likert_colour(2, 5);
        assert!(middle.r == middle.g && middle.g == middle.b);
        assert_eq!(likert_colour(0, 5), Colour::hex(0xe6_61_01));
        assert_eq!(likert_colour(4, 5), Colour::hex(0x5e_3c_99));
    }
}
