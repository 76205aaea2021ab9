//! The one style of all figures: colours, pens, sizes.
//!
//! Each kind of thing (modes, actuators and other parts of a force, solvers, ways of a command,
//! environments) has a palette of its own. Colours in one figure differ in lightness, so they can
//! be told apart in grey print and by readers without red or green cones; a test computes by how
//! much. The diverging ones are ColorBrewer's "PuOr" (Harrower & Brewer 2003,
//! doi:10.1179/000870403235002042).

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

    /// As style sheets write it, `#0b51a6`.
    pub fn css(self) -> String {
        let Self { r, g, b } = self;
        format!("#{r:02x}{g:02x}{b:02x}")
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

/// Colours of a study's modes. Those of actuators stand beside them in one figure, so both have
/// places of their own on the scale of lightness.
const MODES: [Colour; 6] = [
    Colour::hex(0x0b_51_a6), // blue
    Colour::hex(0xdf_74_23), // orange
    Colour::hex(0x0e_7e_77), // teal
    Colour::hex(0xc1_02_5a), // magenta
    Colour::hex(0x07_89_c4), // cyan
    Colour::hex(0x81_14_15), // red
];

/// The same on a dark screen.
const MODES_ON_DARK: [Colour; 6] = [
    Colour::hex(0x59_8c_fb),
    Colour::hex(0xfd_b5_69),
    Colour::hex(0x0b_c7_ab),
    Colour::hex(0xfe_70_8d),
    Colour::hex(0x8c_de_fe),
    Colour::hex(0xfd_1d_54),
];

/// The brake: the darkest colour of all.
pub const BRAKE: Colour = Colour::hex(0x04_33_66);
/// The motor: the lightest.
pub const MOTOR: Colour = Colour::hex(0xc0_8a_f0);
/// The finger's tissue, and what measures its force.
pub const FINGER: Colour = Colour::hex(0x07_90_59);

/// Further parts of a force.
const PARTS: [Colour; 3] = [
    Colour::hex(0x6a_3d_00), // brown
    Colour::hex(0x8a_1f_b0), // purple
    Colour::hex(0xc0_83_17), // ochre
];

/// Solvers that are not the exact one, which has [`INK`].
const SOLVERS: [Colour; 6] = [
    Colour::hex(0x34_1b_8c), // indigo
    Colour::hex(0x72_36_00), // brown
    Colour::hex(0x08_65_6d), // petrol
    Colour::hex(0x87_45_ee), // violet
    Colour::hex(0x11_87_c5), // sky
    Colour::hex(0x9b_9c_03), // olive
];

/// The ways of a command: up, and down again.
const DIRECTIONS: [Colour; 2] = [
    Colour::hex(0x15_3b_d7), // royal blue
    Colour::hex(0xab_90_00), // brass
];

/// Environments, and models beside a recording.
const ENVIRONMENTS: [Colour; 7] = [
    Colour::hex(0x3d_01_ab), // indigo
    Colour::hex(0x78_9b_12), // olive
    Colour::hex(0x85_0b_71), // wine
    Colour::hex(0x0d_8c_81), // pale teal
    Colour::hex(0xe0_95_7a), // salmon
    Colour::hex(0x2d_67_0d), // green
    Colour::hex(0xb4_2f_bb), // purple
];

/// The colour of the study's `index`-th mode, the same in every figure and on the page. After the
/// sixth they start again.
pub fn mode_colour(index: usize) -> Colour {
    MODES[index % MODES.len()]
}

/// The same on a dark screen.
pub fn mode_colour_on_dark(index: usize) -> Colour {
    MODES_ON_DARK[index % MODES_ON_DARK.len()]
}

/// How many modes have a colour of their own.
pub const MODE_COLOURS: usize = MODES.len();

/// The colour of the `index`-th part of a force besides motor, brake, finger and stop; where they
/// start again, [`dash`] tells them apart.
pub fn part_colour(index: usize) -> Colour {
    PARTS[index % PARTS.len()]
}

/// The colour of the `index`-th solver; the first is the exact one, with which others are compared.
pub fn solver_colour(index: usize) -> Colour {
    match index.checked_sub(1) {
        None => INK,
        Some(other) => SOLVERS[other % SOLVERS.len()],
    }
}

/// The colour of the `index`-th way of a command.
pub fn direction_colour(index: usize) -> Colour {
    DIRECTIONS[index % DIRECTIONS.len()]
}

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
    if contrast(BLACK, ground) >= contrast(PAPER, ground) { BLACK } else { PAPER }
}

fn contrast(a: Colour, b: Colour) -> f64 {
    let [a, b] = [a, b].map(luminance);
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// Relative luminance of an sRGB colour, 0 … 1 (WCAG 2.2).
fn luminance(colour: Colour) -> f64 {
    let [r, g, b] = linear(colour);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The channels of an sRGB colour, linear, 0 … 1.
fn linear(colour: Colour) -> [f64; 3] {
    [colour.r, colour.g, colour.b].map(|channel| {
        let c = f64::from(channel) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
    })
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
    /// Lengths of dashes and gaps in turn, in widths of the pen; nothing for what has none.
    pub fn widths(self) -> &'static [f64] {
        match self {
            Self::Dashed => &[4.0, 2.5],
            Self::DashDotted => &[6.0, 2.0, 1.5, 2.0],
            Self::LongDashed => &[9.0, 2.5],
            _ => &[],
        }
    }

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
    [Dash::Solid, Dash::Dashed, Dash::DashDotted, Dash::LongDashed][index % DASHES]
}

/// How many modes have dashes of their own.
pub const DASHES: usize = 4;

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
        /// A dot is a dash of almost no length under round ends.
        const DOT_PT: f64 = 0.01;
        if self.dash == Dash::Solid {
            return None;
        }
        let dots = self.dash.dots();
        if dots.is_empty() {
            return Some(self.dash.widths().iter().map(|width| width * self.width_pt).collect());
        }
        // Every dot of a beat alike: one dash and one gap say it.
        let shown = if dots.len() == BEAT { 1 } else { dots.len() };
        let mut lengths = Vec::new();
        for (i, dot) in dots.iter().take(shown).enumerate() {
            let next = dots.get(i + 1).copied().unwrap_or(dots[0] + BEAT);
            lengths.extend([DOT_PT, (next - dot) as f64 * DOT * self.width_pt - DOT_PT]);
        }
        Some(lengths)
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
    Stroke { width_pt: 0.5, opacity: 0.32, ..mean(colour) }
}

/// Pen of one repeat where the repeats are the message.
pub const fn single(colour: Colour) -> Stroke {
    Stroke { width_pt: 0.8, ..mean(colour) }
}

/// Pen of what was commanded, beside what was measured.
pub const fn commanded() -> Stroke {
    Stroke { width_pt: 0.9, dash: Dash::Dotted, ..mean(INK) }
}

/// Pen of a reference line.
pub const fn reference() -> Stroke {
    Stroke { width_pt: 0.6, dash: Dash::Dashed, ..mean(GREY) }
}

/// Pen of the line that marks zero.
pub const fn zero() -> Stroke {
    Stroke { width_pt: AXIS_PT, ..mean(INK) }
}

/// Opacity of a band: three overlapping bands can still be told apart.
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
/// Size of tick labels, legends, notes and small print, in pt: no line has smaller letters.
/// Headings and labels are shrunk to it where room is short.
pub const SMALL_PT: f64 = 7.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// How a reader sees linear sRGB.
    type Eye = [[f64; 3]; 3];

    const EVERY_CONE: Eye = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// Deuteranopia of severity 1: Machado, Oliveira & Fernandes 2009 (doi:10.1109/TVCG.2009.113).
    const NO_GREEN: Eye = [
        [0.367_322, 0.860_646, -0.227_968],
        [0.280_085, 0.672_501, 0.047_413],
        [-0.011_820, 0.042_940, 0.968_881],
    ];
    /// Protanopia of severity 1, from the same table.
    const NO_RED: Eye = [
        [0.152_286, 1.052_583, -0.204_868],
        [0.114_503, 0.786_281, 0.099_216],
        [-0.003_882, -0.048_116, 1.051_998],
    ];

    /// Each channel of a colour, linear, 0 … 1, as an eye sees it.
    fn seen(colour: Colour, eye: Eye) -> [f64; 3] {
        let from = linear(colour);
        eye.map(|row| {
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

    /// Distance of two colours for an eye (CIE76; 2.3 is just seen side by side).
    fn apart(a: Colour, b: Colour, eye: Eye) -> f64 {
        let [a, b] = [a, b].map(|colour| lab(seen(colour, eye)));
        a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    /// Difference of their lightness L* in grey print.
    fn apart_in_grey(a: Colour, b: Colour) -> f64 {
        let [a, b] = [a, b].map(|colour| lab(seen(colour, EVERY_CONE))[0]);
        (a - b).abs()
    }

    /// The least ΔE of any two colours for any eye, and the least ΔL* in grey.
    fn least_apart(colours: &[Colour]) -> [f64; 2] {
        let mut least = [f64::INFINITY; 2];
        for (i, a) in colours.iter().enumerate() {
            for b in &colours[..i] {
                for eye in [EVERY_CONE, NO_GREEN, NO_RED] {
                    least[0] = least[0].min(apart(*a, *b, eye));
                }
                least[1] = least[1].min(apart_in_grey(*a, *b));
            }
        }
        least
    }

    /// The bounds: six times what is just seen for every eye (ΔE 14), and a difference of lightness
    /// of 5 of 100 in grey, where dashes and markers differ besides.
    #[test]
    fn roles_that_share_a_figure_are_told_apart_by_every_eye_and_in_grey() {
        let figures: [(&str, Vec<Colour>); 7] = [
            ("modes beside actuators", [&MODES[..], &[MOTOR, BRAKE, INK]].concat()),
            ("parts of a force", [&PARTS[..], &[MOTOR, BRAKE, FINGER, GREY, INK]].concat()),
            ("solvers", [&SOLVERS[..], &[INK]].concat()),
            ("ways of a command", [&DIRECTIONS[..], &[GREY, INK]].concat()),
            ("environments", [&ENVIRONMENTS[..], &[INK]].concat()),
            (
                "limits of a wall",
                [&[0, 2, 3, 4, 5].map(environment_colour)[..], &[4, 6].map(solver_colour), &[INK]]
                    .concat(),
            ),
            ("modes on a dark screen", MODES_ON_DARK.to_vec()),
        ];
        for (figure, colours) in figures {
            let [delta_e, delta_l] = least_apart(&colours);
            assert!(delta_e >= 14.0 && delta_l >= 5.0, "{figure}: ΔE {delta_e}, ΔL* {delta_l}");
        }
        assert!(apart_in_grey(MOTOR, BRAKE) > 40.0, "a light one and a dark one");
        for eye in [EVERY_CONE, NO_GREEN, NO_RED] {
            assert!(apart(MOTOR, BRAKE, eye) > 40.0);
        }
    }

    #[test]
    fn no_colour_has_two_roles() {
        let all = [
            &MODES[..],
            &[BRAKE, MOTOR, FINGER],
            &PARTS,
            &SOLVERS,
            &DIRECTIONS,
            &ENVIRONMENTS,
            &[INK, GREY, MARK],
        ]
        .concat();
        for (i, colour) in all.iter().enumerate() {
            assert!(!all[..i].contains(colour), "{}", colour.css());
        }
    }

    #[test]
    fn curves_that_differ_by_colour_differ_by_dashes_too() {
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
        assert_eq!(mode_colour(0), Colour::hex(0x0b_51_a6));
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
