//! The error against a reference in 120 digits, for parameters that are not short binary fractions.
//! The run is the motion of exactly the given numbers, although a double cannot hold K_O/(M_O L)
//! and similar terms.
//!
//! The numbers in `REFERENCES` and `HELD` are `exp(A n h) z0` of the augmented matrix, made with
//! mpmath 1.4.1 in 120 digits by scaling, a Taylor series and squaring, from the doubles below as
//! exact fractions, and rounded to doubles at the end. The random ones were drawn once: masses 1
//! g…1 kg, levers 0.03…2 m, stiffnesses 0.1…1e6, steps 1 ms…3 s.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::super::*;
use crate::scene::ModelScene;
use crate::scene::actuators::DriveMode;
use crate::scene::environment::Environment;
use crate::scene::finger::{Finger, FingerLaw};
use crate::scene::input::Input;
use crate::scene::plant::Start;
use crate::scene::table3;

/// A lever on an unsaturated spring, from rest, and where it is after each quarter of its steps.
struct Reference {
    name: &'static str,
    /// M_O (kg) and L (m).
    plant: [f64; 2],
    /// K_O (N/rad), B_O (N s/rad) and θ_rest (rad).
    spring: [f64; 3],
    start_rad: f64,
    /// Law, M_F (kg), K_F (N/m) and B_F (N s/m).
    finger: Option<(FingerLaw, [f64; 3])>,
    /// a (N) and ω (rad/s) of (7); without ω nobody pushes.
    sine: [f64; 2],
    /// h (s) and the number of steps.
    grid: (f64, usize),
    /// θ (rad) and x2 (m).
    states: [[f64; 2]; 4],
}

impl Reference {
    fn scene(&self) -> ModelScene {
        let [magnitude, omega_rad_s] = self.sine;
        let sine = Input::Sine { magnitude, omega_rad_s };
        let input = if omega_rad_s > 0.0 { sine } else { Input::constant(0.0) };
        let mut scene = table3::scene(DriveMode::Active, input);
        [scene.plant.mass_kg, scene.plant.lever_m] = self.plant;
        scene.plant.stops_rad = None;
        scene.environment = Environment::spring(self.spring[0], self.spring[1], self.spring[2]);
        scene.motor.max_n = 1e30;
        scene.start = Start { theta_rad: self.start_rad, theta_dot_rad_s: 0.0 };
        scene.finger = self.finger.map(|(law, [mass_kg, stiffness_n_per_m, damping_ns_per_m])| {
            Finger { law, mass_kg, stiffness_n_per_m, damping_ns_per_m, length_m: None }
        });
        scene
    }

    /// Condition number of a step, number of events, and the larger of the errors of θ and x2, each
    /// over its largest signal.
    fn measure(&self) -> (f64, usize, f64) {
        let system = System::new(self.scene()).unwrap();
        let (step_s, steps) = self.grid;
        let run = Exact::default().run(&system, &Grid::Even { step_s, steps }).unwrap();
        let error = |entry: usize, quantity: usize| {
            let signal = (0..run.len()).map(|i| run.state(i)[entry].abs()).fold(0.0, f64::max);
            let at = |quarter: usize| run.state((quarter + 1) * steps / 4)[entry];
            let errors =
                self.states.iter().enumerate().map(|(i, state)| (at(i) - state[quantity]).abs());
            errors.fold(0.0, f64::max) / signal
        };
        let finger = run.layout.finger.map_or(0.0, |entry| error(entry, 1));
        (system.largest_condition(&run, step_s), run.events.len(), error(0, 0).max(finger))
    }
}

#[test]
fn any_parameters_give_the_motion_of_the_numbers_they_are() {
    let mut largest: f64 = 0.0;
    for reference in REFERENCES {
        let (condition, reversals, error) = reference.measure();
        // Every radian between two reversals is gone through in pieces, each of which is rounded.
        let radians = PI * reversals as f64;
        let bound = if condition < 1e6 { 1e-12 } else { 1e-12 + f64::EPSILON * radians };
        assert!(error <= bound, "{}: {error} at a condition number of {condition}", reference.name);
        largest = if condition < 1e6 { largest.max(condition) } else { largest };
    }
    assert!(largest > 5e5, "{largest}");
}

/// M_F (kg), K_F (N/m) and B_F (N s/m) of a finger on a held lever, h (s), and x2 (m) after 16, 32,
/// 48 and 64 steps of a pull of 1 N from rest. No event interrupts it: a step is a few products,
/// however many swings are in it.
type Held = ([f64; 3], f64, [f64; 4]);

#[test]
fn a_finger_that_swings_a_thousand_times_a_step_keeps_its_phase() {
    let mut largest: f64 = 0.0;
    for (finger, step_s, expect) in HELD {
        let mut scene = table3::scene(DriveMode::Passive, Input::constant(-1.0));
        scene.start.theta_rad = 0.2; // the brake holds 3.9 N here, the finger pulls 2 N at most
        let [mass_kg, stiffness_n_per_m, damping_ns_per_m] = *finger;
        let law = FingerLaw::Consistent;
        scene.finger =
            Some(Finger { law, mass_kg, stiffness_n_per_m, damping_ns_per_m, length_m: None });
        let system = System::new(scene).unwrap();
        let run =
            Exact::default().run(&system, &Grid::Even { step_s: *step_s, steps: 64 }).unwrap();
        let signal = run.finger_m().fold(0.0, |m: f64, x| m.max(x.abs()));
        let errors = expect.iter().enumerate().map(|(i, x)| (run.state(16 * (i + 1))[2] - x).abs());
        let error = errors.fold(0.0, f64::max) / signal;
        assert!(error < 1e-13, "{finger:?}, {step_s} s: {error}");
        largest = largest.max(system.largest_condition(&run, *step_s));
    }
    assert!(largest > 1e11, "{largest}");
}

const HELD: &[Held] = &[
    (
        [0.021, 584.6, 1.53],
        0.1,
        [
            -0.001_710_571_330_824_495_3,
            -0.001_710_571_330_824_495_3,
            -0.001_710_571_330_824_495_3,
            -0.001_710_571_330_824_495_3,
        ],
    ),
    (
        [0.021, 584.6, 0.001],
        0.1,
        [
            -0.003_352_004_485_154_225,
            -0.000_145_440_035_484_559_35,
            -0.003_193_331_389_088_903_7,
            -0.000_315_192_619_062_162_7,
        ],
    ),
    (
        [0.021, 584.6, 1.0e-5],
        10.0,
        [
            -0.001_842_535_152_369_269_5,
            -0.003_275_293_999_543_794,
            -0.001_346_868_354_867_902_8,
            -0.000_316_752_706_897_499_4,
        ],
    ),
    (
        [0.1, 0.3, 0.0],
        0.7,
        [
            -0.490_562_905_939_847_64,
            -1.817_860_444_948_901_8,
            -3.591_218_854_357_308_5,
            -5.288_671_821_409_716,
        ],
    ),
    (
        [0.3, 7_000_000.0, 0.0],
        0.1,
        [
            -1.220_335_467_452_481_3e-8,
            -4.672_851_258_372_780_3e-8,
            -9.767_695_526_736_925e-8,
            -1.563_442_958_988_847e-7,
        ],
    ),
    (
        [0.086, 51_200.0, 2.43e-5],
        2.27,
        [
            -1.051_721_288_366_200_5e-5,
            -3.054_279_483_723_182_6e-5,
            -3.861_731_768_168_158_6e-5,
            -2.624_928_152_759_023_7e-5,
        ],
    ),
    (
        [0.129, 409_000.0, 0.0],
        0.011_8,
        [
            -4.889_071_237_457_94e-6,
            -3.616_581_712_056_393_6e-9,
            -4.881_840_749_319_714e-6,
            -1.445_562_768_366_255e-8,
        ],
    ),
    (
        [0.049_9, 521_000.0, 8.85e-6],
        1.79,
        [
            -3.401_928_046_444_433_4e-6,
            -1.538_802_313_796_872e-6,
            -1.032_283_721_916_626e-6,
            -3.668_444_289_828_03e-6,
        ],
    ),
    (
        [0.014_8, 2_210.0, 0.0],
        0.041_3,
        [
            -0.000_740_557_799_875_223,
            -0.000_538_188_920_595_235_7,
            -5.530_042_801_242_292e-5,
            -0.000_872_514_553_389_467_8,
        ],
    ),
    (
        [0.065_4, 7_410.0, 1.09e-7],
        0.034_8,
        [
            -7.063_735_907_595_247e-5,
            -0.000_208_602_897_898_864_4,
            -0.000_269_468_056_866_680_34,
            -0.000_189_516_536_673_995_56,
        ],
    ),
    (
        [0.026_3, 382_000.0, 0.0],
        0.821,
        [
            -2.203_228_907_247_362_7e-6,
            -5.104_293_369_043_419e-6,
            -3.819_927_645_199_117e-6,
            -5.120_620_270_665_641e-7,
        ],
    ),
    (
        [0.017_4, 96_800.0, 2.61e-7],
        0.35,
        [
            -6.308_945_672_924_549_5e-6,
            -1.752_909_377_354_790_8e-5,
            -1.995_655_195_430_363_6e-5,
            -1.062_733_638_812_107_7e-5,
        ],
    ),
];

const REFERENCES: &[Reference] = &[
    Reference {
        name: "tenths",
        plant: [0.1, 0.3],
        spring: [0.7, 0.0, 0.1],
        start_rad: 0.3,
        finger: None,
        sine: [0.0, 0.0],
        grid: (0.1, 64),
        states: [
            [0.124_984_033_770_081_77, 0.0],
            [-0.093_757_980_565_754_11, 0.0],
            [0.026_607_406_933_141_748, 0.0],
            [0.275_421_550_329_191_6, 0.0],
        ],
    },
    Reference {
        name: "tenths, stiff",
        plant: [0.1, 0.3],
        spring: [700_000.0, 0.0, 0.1],
        start_rad: 0.3,
        finger: None,
        sine: [0.0, 0.0],
        grid: (0.1, 64),
        states: [
            [0.282_915_303_455_682_6, 0.0],
            [0.234_580_082_382_844_56, 0.0],
            [0.163_252_262_625_805_14, 0.0],
            [0.081_117_985_741_732_26, 0.0],
        ],
    },
    Reference {
        name: "tenths, lightly damped",
        plant: [0.3, 0.1],
        spring: [700.0, 0.001, 0.0],
        start_rad: 0.1,
        finger: None,
        sine: [0.0, 0.0],
        grid: (0.1, 64),
        states: [
            [0.078_081_445_547_909_37, 0.0],
            [0.027_137_759_188_915_866, 0.0],
            [-0.031_643_649_079_923_786, 0.0],
            [-0.075_147_984_388_424_34, 0.0],
        ],
    },
    Reference {
        name: "Table 3",
        plant: [0.005, 1.0],
        spring: [4.0, 1.0, -FRAC_PI_4],
        start_rad: -FRAC_PI_4,
        finger: None,
        sine: [2.15, FRAC_PI_2],
        grid: (0.008_3, 480),
        states: [
            [0.211_425_512_162_104_03, 0.0],
            [-0.058_299_370_011_121, 0.0],
            [-0.711_091_424_248_126_2, 0.0],
            [-0.443_424_663_792_846_1, 0.0],
        ],
    },
    Reference {
        name: "Table 3 with finger",
        plant: [0.005, 1.0],
        spring: [4.0, 1.0, -FRAC_PI_4],
        start_rad: -FRAC_PI_4,
        finger: Some((FingerLaw::Consistent, [0.021, 584.6, 1.53])),
        sine: [2.15, FRAC_PI_2],
        grid: (0.008_3, 480),
        states: [
            [0.217_480_173_889_330_03, 0.007_400_644_283_443_57],
            [-0.053_966_622_164_908_53, 0.003_756_470_467_237_693_4],
            [-0.715_518_996_268_463_6, -4.070_325_479_276_573_6e-5],
            [-0.447_757_118_069_516, 0.003_552_297_577_612_36],
        ],
    },
    Reference {
        name: "Table 3 with the thesis finger",
        plant: [0.005, 1.0],
        spring: [4.0, 1.0, -FRAC_PI_4],
        start_rad: -FRAC_PI_4,
        finger: Some((FingerLaw::Thesis, [0.021, 584.6, 1.53])),
        sine: [2.15, FRAC_PI_2],
        grid: (0.008_3, 480),
        states: [
            [0.211_470_495_491_647_4, 0.007_355_552_938_933_263],
            [-0.058_282_320_387_667_15, 0.003_739_066_704_846_412],
            [-0.711_132_410_384_086_9, 6.745_788_986_316_454e-7],
            [-0.443_442_163_665_333_4, 0.003_570_183_101_131_399],
        ],
    },
    Reference {
        name: "Table 3 with finger, lever 45 mm",
        plant: [0.005, 0.045],
        spring: [4.0, 1.0, -FRAC_PI_4],
        start_rad: -FRAC_PI_4,
        finger: Some((FingerLaw::Consistent, [0.021, 584.6, 1.53])),
        sine: [2.15, FRAC_PI_2],
        grid: (0.008_3, 480),
        states: [
            [0.210_399_738_465_314_65, 0.007_357_575_758_643_31],
            [-0.059_056_617_246_485_41, 0.003_739_831_175_070_259],
            [-0.710_339_121_788_26, -1.166_799_994_167_878e-6],
            [-0.442_669_886_987_451_74, 0.003_569_398_630_024_639_8],
        ],
    },
    Reference {
        name: "random 1",
        plant: [0.064_8, 0.423],
        spring: [0.288, 1.1e-5, 0.473],
        start_rad: -0.033,
        finger: Some((FingerLaw::Consistent, [0.017_3, 429.0, 0.012_9])),
        sine: [0.0, 0.0],
        grid: (0.005_05, 64),
        states: [
            [-0.019_323_974_577_342_553, -8.217_293_765_877_923e-5],
            [0.020_867_736_581_729_288, -0.000_125_876_572_472_634_64],
            [0.085_354_852_456_276_73, -2.131_613_991_822_823_6e-5],
            [0.170_772_525_220_333_73, 2.700_285_864_547_515_5e-6],
        ],
    },
    Reference {
        name: "random 2",
        plant: [0.97, 0.222],
        spring: [71_700.0, 0.0, 0.089_7],
        start_rad: -0.19,
        finger: None,
        sine: [5.45, 8.03],
        grid: (0.002_83, 64),
        states: [
            [-0.062_511_617_577_002_7, 0.0],
            [0.203_758_304_755_158_88, 0.0],
            [0.366_210_033_817_023_55, 0.0],
            [0.276_835_057_075_458_97, 0.0],
        ],
    },
    Reference {
        name: "random 3",
        plant: [0.037_1, 0.683],
        spring: [5_010.0, 1.56e-5, 0.328],
        start_rad: -0.152,
        finger: None,
        sine: [0.0, 0.0],
        grid: (0.008_01, 64),
        states: [
            [-0.106_650_659_584_565_21, 0.0],
            [0.020_790_734_812_853_48, 0.0],
            [0.206_246_923_068_667_63, 0.0],
            [0.414_684_868_558_558_1, 0.0],
        ],
    },
    Reference {
        name: "random 4",
        plant: [0.612, 1.1],
        spring: [865_000.0, 0.001_03, 0.021_2],
        start_rad: -0.526,
        finger: Some((FingerLaw::Consistent, [0.038_4, 5_160.0, 0.111])),
        sine: [0.0, 0.0],
        grid: (0.783, 64),
        states: [
            [0.132_461_938_241_251_46, -0.136_802_723_480_514],
            [0.007_104_238_774_327_449, 0.017_398_765_802_039_31],
            [0.020_517_463_023_576_02, 0.000_811_645_080_956_197_4],
            [0.022_298_529_564_348_715, -0.001_343_303_611_532_911_5],
        ],
    },
    Reference {
        name: "random 5",
        plant: [0.007_16, 0.041_1],
        spring: [95_000.0, 0.009_32, 0.015],
        start_rad: -0.399,
        finger: None,
        sine: [0.0, 0.0],
        grid: (0.017, 64),
        states: [
            [0.012_967_661_568_046_85, 0.0],
            [0.015_055_124_195_656_964, 0.0],
            [0.015_000_911_210_909_964, 0.0],
            [0.014_999_998_963_854_74, 0.0],
        ],
    },
    Reference {
        name: "random 6",
        plant: [0.202, 1.18],
        spring: [0.204, 0.0, 0.169],
        start_rad: -0.012_3,
        finger: Some((FingerLaw::Consistent, [0.014_2, 76.2, 0.0])),
        sine: [5.78, 0.984],
        grid: (0.143, 64),
        states: [
            [68.591_604_549_865_56, 0.196_573_781_382_924_28],
            [56.214_675_201_116_65, -0.013_783_011_421_771_54],
            [-82.095_882_223_953_47, 0.071_255_245_749_277_32],
            [122.932_638_326_632_22, 0.174_865_421_365_031_75],
        ],
    },
    Reference {
        name: "random 7",
        plant: [0.003_91, 0.172],
        spring: [1_880.0, 0.0, 0.020_5],
        start_rad: -0.012_2,
        finger: None,
        sine: [0.0, 0.0],
        grid: (0.401, 64),
        states: [
            [0.031_346_305_039_115_42, 0.0],
            [0.046_004_750_275_135_14, 0.0],
            [-0.007_265_711_854_441_321, 0.0],
            [0.013_414_539_046_054_679, 0.0],
        ],
    },
];
