//! What a seed draws: the study, what goes wrong, and a clock that is late.

use crate::played::{changed_template, plan};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use zwidth_acquire::Plan;
use zwidth_device::mock::Fault as DeviceFault;
use zwidth_device::{Clock, SimulatedClock};
use zwidth_store::{Fault, Memory, Survives};

/// Rate of the loop, Hz, as the thesis'.
const RATE_HZ: f64 = 120.0;
/// Longest trial, s: fifty samples at most.
const LIMIT_S: f64 = 0.41;
/// A disk that fails does so within so many steps: several trials' worth.
const MOST_STEPS: u64 = 250;

/// Draws from a seed.
pub(super) struct Draw(ChaCha8Rng);

impl Draw {
    /// A stream of its own for each use, so that one more draw in one place changes nothing
    /// elsewhere.
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Self(rng)
    }

    /// A number below `n`, which is small.
    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.0.next_u64() % n
    }

    pub(super) fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    pub(super) fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }
}

/// How a life goes wrong.
pub(super) struct Trouble {
    /// What the disk does, and after how many steps.
    pub(super) disk: Option<(u64, Fault)>,
    /// What the next life finds.
    pub(super) survives: Survives,
    /// What the device does, from which time on, s.
    pub(super) device: Option<(f64, DeviceFault)>,
    /// Whether ticks are late and the clock jumps.
    pub(super) late: bool,
    /// Whether the time of day jumps.
    pub(super) jumps: bool,
    /// Steps of the time of day while the session runs: when, s of the loop's clock, and by how
    /// much, s.
    pub(super) steps: Vec<(f64, i64)>,
}

impl Trouble {
    pub(super) fn none() -> Self {
        Self {
            disk: None,
            survives: Survives::Everything,
            device: None,
            late: false,
            jumps: false,
            steps: Vec::new(),
        }
    }

    pub(super) fn draw(draw: &mut Draw) -> Self {
        let torn = Survives::Torn(draw.below(1 << 32));
        let power =
            [Survives::Synced, Survives::Names, Survives::Zeros, Survives::Half, torn, torn];
        let (fault, survives) = match draw.below(8) {
            0..=2 => (Some(Fault::End), Survives::Everything),
            3..=5 => (Some(Fault::End), draw.of(&power)),
            6 => (Some(Fault::Full), Survives::Everything),
            _ => (None, Survives::Everything),
        };
        let faults = [
            DeviceFault::Unplugged,
            DeviceFault::AngleStops,
            DeviceFault::ForceStops,
            DeviceFault::ForceNan,
            DeviceFault::AngleOff(0.9),
            DeviceFault::Force(40.0),
            DeviceFault::Panic,
        ];
        let device = draw.one_in(4).then(|| (draw.below(3000) as f64 * 1e-3, draw.of(&faults)));
        Self {
            disk: fault.map(|fault| (draw.below(MOST_STEPS), fault)),
            survives,
            device,
            late: draw.one_in(4),
            jumps: draw.one_in(3),
            steps: if draw.one_in(3) { Self::steps(draw) } else { Vec::new() },
        }
    }

    /// A few steps, by seconds to years, forwards and backwards, within the first trials.
    fn steps(draw: &mut Draw) -> Vec<(f64, i64)> {
        const UNITS_S: [i64; 5] = [1, 60, 3_600, 86_400, 31_557_600];
        (0..=4)
            .map(|_| {
                let at_s = draw.below(20_000) as f64 * 1e-3;
                let by_s = draw.of(&UNITS_S) * (1 + draw.below(9) as i64) * draw.of(&[-1, 1]);
                (at_s, by_s)
            })
            .collect()
    }

    /// What it is called where it is counted.
    pub(super) fn words(&self) -> Vec<&'static str> {
        let disk = self.disk.map(|(_, fault)| match (fault, self.survives) {
            (Fault::Full, _) => "a full disk",
            (Fault::ReadOnly, _) => "a disk that can be read only",
            (Fault::End, Survives::Everything) => "a kill",
            (Fault::End, Survives::Synced) => "a power cut: synced names and content stay",
            (Fault::End, Survives::Names) => "a power cut: names stay, unsynced content goes",
            (Fault::End, Survives::Zeros) => "a power cut: zeros where content was not synced",
            (Fault::End, Survives::Half) => "a power cut: half of what was not synced",
            (Fault::End, Survives::Torn(_)) => "a power cut: any sectors of what was not synced",
        });
        let device = self.device.map(|(_, fault)| match fault {
            DeviceFault::Unplugged => "a pulled cable",
            DeviceFault::AngleStops => "an angle sensor that stops",
            DeviceFault::ForceStops => "a force sensor that stops",
            DeviceFault::AngleNan | DeviceFault::ForceNan => "a reading that is no number",
            DeviceFault::AngleOff(_) => "an angle that jumps",
            DeviceFault::Force(_) => "a force beyond the limit",
            DeviceFault::Panic => "a device whose code fails",
        });
        let others = [
            (self.late, "late ticks"),
            (self.jumps, "a time of day that jumps"),
            (!self.steps.is_empty(), "a time of day that steps while the session runs"),
        ];
        let others = others.into_iter().filter_map(|(is, word)| is.then_some(word));
        disk.into_iter().chain(device).chain(others).collect()
    }
}

/// A clock of which now and then a tick is late: by a fiftieth of a second, or by the time that a
/// machine slept.
pub(super) struct Late {
    clock: SimulatedClock,
    draw: Option<Draw>,
    /// The machine's sleep, s.
    nap_s: f64,
    off_s: f64,
}

impl Late {
    pub(super) fn new(seed: u64, draw: Option<Draw>, nap_s: f64) -> Self {
        Self { clock: SimulatedClock::new(seed), draw, nap_s, off_s: 0.0 }
    }
}

impl Clock for Late {
    fn now_s(&mut self) -> f64 {
        self.clock.now_s() + self.off_s
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        if let Some(draw) = &mut self.draw
            && draw.one_in(100)
        {
            self.off_s += draw.of(&[0.002, 0.009, 0.02, 0.1, self.nap_s]);
        }
        self.clock.wait_until(deadline_s - self.off_s) + self.off_s
    }
}

/// The study of a seed, laid down on a disk of its own: three to six trials and perhaps one for
/// practice.
pub(super) fn study(seed: u64) -> anyhow::Result<(Memory, Plan)> {
    const STUDY: &str = "soak";
    let mut draw = Draw::new(seed, 1);
    let (environments, modes) = draw.of(&[(1, 3), (2, 2), (2, 3)]);
    let fields = [
        ("design", "repeats", toml::Value::from(1)),
        ("design", "familiarisation", i64::from(draw.below(2) as u32).into()),
        ("design", "trial_limit_s", LIMIT_S.into()),
        ("design", "redo_unmet", i64::from(Draw::new(seed, 4).below(3) as u32).into()),
        ("design", "blinded", draw.one_in(3).into()),
        ("control", "rate_hz", RATE_HZ.into()),
    ];
    let lists = [("environments", environments), ("modes", modes)];
    let (disk, plan) = plan(STUDY, &changed_template(STUDY, &lists, fields)?)?;
    let participant = format!("P{:02}", 1 + draw.below(3)).parse()?;
    Ok((disk, Plan { participant, seed: draw.one_in(2).then_some(seed), ..plan }))
}
