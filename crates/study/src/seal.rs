//! Sealing: the order of the modes is fixed before the first trial, and known to nobody until it is
//! opened.
//!
//! The session's record holds codes in place of modes, and the commitment BLAKE3(nonce ‖ text),
//! where the nonce is 32 random bytes and the text has a line `<trial> <mode>` for each trial, by
//! number, each ended by a line feed. Of an interval of two of a task the line goes on with ` standard` or ` comparison`:
//! which of them holds the standard is sealed, too. Opening the seal shows nonce and order: every reader of the
//! log can then check that the order is the committed one. A code is BLAKE3 of the trial's number
//! (4 bytes, little-endian) keyed with the nonce: it differs from trial to trial and does not
//! depend on the mode.
//!
//! This protects against accident, not against a person with access to the disk: the voltages of a
//! recording reveal its mode.

use crate::{Event, ModeId, PlannedTrial, SealedTrial, TaskPlace};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What is wrong with a seal.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SealError {
    /// The text is not a seal.
    #[error("not a seal: {0}; restore the file from a copy")]
    NotASeal(String),
    /// The order is not the one that was committed to.
    #[error(
        "nonce and order give the commitment {found}, but the session began with {committed}; \
         only the seal of this very session opens it"
    )]
    OtherOrder {
        /// The session's commitment.
        committed: String,
        /// The commitment of the seal.
        found: String,
    },
    /// A trial of the session does not stand in the sealed order, or under another code.
    #[error(
        "trial {trial} is not sealed under the code '{code}'; only the seal of this very session opens it"
    )]
    OtherTrial {
        /// The trial.
        trial: u32,
        /// The code in the session's record.
        code: ModeId,
    },
}

/// The order of the modes, and the nonce it is sealed with. Kept outside of the data until it is
/// opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seal {
    /// 32 random bytes: without them the order could be guessed from its commitment.
    pub nonce: [u8; 32],
    /// What is sealed of each planned trial, by number.
    pub order: Vec<SealedTrial>,
}

/// A seal as it lies in its file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    nonce: String,
    order: Vec<SealedTrial>,
}

impl Seal {
    /// Seals the modes of `trials`.
    pub fn new(nonce: [u8; 32], trials: &[PlannedTrial]) -> Self {
        let sealed = trials.iter().map(|t| SealedTrial {
            trial: t.trial,
            mode: t.mode.clone(),
            is_standard: t.task.as_ref().and_then(|place| place.is_standard),
        });
        let mut order: Vec<_> = sealed.collect();
        // By number: the commitment is of one text, however the trials were listed.
        order.sort();
        Self { nonce, order }
    }

    /// The commitment, hexadecimal, which a session's record shows before the first trial.
    pub fn commitment(&self) -> String {
        let mut text = String::new();
        for SealedTrial { trial, mode, is_standard } in &self.order {
            let holds = match is_standard {
                None => "",
                Some(true) => " standard",
                Some(false) => " comparison",
            };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{trial} {mode}{holds}");
        }
        blake3::Hasher::new()
            .update(&self.nonce)
            .update(text.as_bytes())
            .finalize()
            .to_hex()
            .to_string()
    }

    /// The code of a trial, which replaces its mode in the record and in the trial's file.
    pub fn code(&self, trial: u32) -> ModeId {
        ModeId::code(&blake3::keyed_hash(&self.nonce, &trial.to_le_bytes()))
    }

    /// Whether this is the seal of `commitment`.
    ///
    /// # Errors
    /// [`SealError::OtherOrder`] with both commitments.
    pub fn verify(&self, commitment: &str) -> Result<(), SealError> {
        let own = self.commitment();
        if own == commitment {
            return Ok(());
        }
        Err(SealError::OtherOrder { committed: commitment.to_owned(), found: own })
    }

    /// The trials as a sealed session shows them: codes in place of modes, and in place of repeats
    /// the place among the trials of the same kind and environment. Presentations of a task are counted without the mode,
    /// too, and none says which interval holds the standard.
    #[must_use]
    pub fn masked(&self, trials: &[PlannedTrial]) -> Vec<PlannedTrial> {
        let mut places = BTreeMap::new();
        let mut presentations = BTreeMap::new();
        // Counted without the mode: a repeat of the mode would tell which codes are alike.
        let masked = trials.iter().map(|t| PlannedTrial {
            mode: self.code(t.trial),
            repeat: count(&mut places, (t.kind, t.environment.clone())),
            task: t.task.as_ref().map(|place| TaskPlace {
                presentation: presentation(&mut presentations, place.task.clone(), place),
                is_standard: None,
                ..place.clone()
            }),
            ..t.clone()
        });
        masked.collect()
    }

    /// The trials of a sealed session with their modes and repeats: undoes [`Seal::masked`].
    ///
    /// # Errors
    /// [`SealError::OtherTrial`] for a trial that is not in the order, or has another code than
    /// this seal gives it.
    pub fn opened(&self, trials: &[PlannedTrial]) -> Result<Vec<PlannedTrial>, SealError> {
        let sealed: BTreeMap<u32, &SealedTrial> =
            self.order.iter().map(|sealed| (sealed.trial, sealed)).collect();
        let mut repeats = BTreeMap::new();
        let mut presentations = BTreeMap::new();
        let mut opened = Vec::with_capacity(trials.len());
        for t in trials {
            // By its code too: the seal of another session has an order for the same numbers.
            let Some(own) = sealed.get(&t.trial).filter(|_| t.mode == self.code(t.trial)) else {
                return Err(SealError::OtherTrial { trial: t.trial, code: t.mode.clone() });
            };
            let mode = own.mode.clone();
            let repeat = count(&mut repeats, (t.kind, t.environment.clone(), mode.clone()));
            let task = t.task.as_ref().map(|place| {
                let of = (place.task.clone(), mode.clone());
                let presentation = presentation(&mut presentations, of, place);
                TaskPlace { presentation, is_standard: own.is_standard, ..place.clone() }
            });
            opened.push(PlannedTrial { mode, repeat, task, ..t.clone() });
        }
        Ok(opened)
    }

    /// The event that opens the seal.
    pub fn event(&self) -> Event {
        let File { nonce, order } = File::from(self);
        Event::Unsealed { nonce, order }
    }

    /// The seal that an event shows.
    ///
    /// # Errors
    /// A nonce that is not 64 hexadecimal digits.
    pub fn from_event(nonce: &str, order: &[SealedTrial]) -> Result<Self, SealError> {
        let nonce = blake3::Hash::from_hex(nonce)
            .map_err(|e| SealError::NotASeal(format!("nonce: {e}")))?;
        Ok(Self { nonce: *nonce.as_bytes(), order: order.to_vec() })
    }

    /// The seal as the text of its file.
    ///
    /// # Errors
    /// None in practice: a seal has nothing that JSON cannot hold.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(&File::from(self)).map(|text| text + "\n")
    }

    /// Reads the text of a seal's file.
    ///
    /// # Errors
    /// Text that is not a seal.
    pub fn from_json(text: &str) -> Result<Self, SealError> {
        let file: File =
            serde_json::from_str(text).map_err(|e| SealError::NotASeal(e.to_string()))?;
        Self::from_event(&file.nonce, &file.order)
    }
}

impl From<&Seal> for File {
    fn from(seal: &Seal) -> Self {
        let nonce = blake3::Hash::from(seal.nonce).to_hex().to_string();
        Self { nonce, order: seal.order.clone() }
    }
}

/// The number of a trial's presentation among those of a task; a new one begins with its first interval.
fn presentation<T: Ord>(counts: &mut BTreeMap<T, u32>, of: T, place: &TaskPlace) -> u32 {
    let number = counts.entry(of).or_default();
    *number += u32::from(place.interval <= 1);
    *number
}

/// Counts how often something came, this time included.
fn count<T: Ord>(counts: &mut BTreeMap<T, u32>, what: T) -> u32 {
    let count = counts.entry(what).or_default();
    *count += 1;
    *count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::demo;
    use crate::{OrderScheme, order};
    use std::collections::BTreeSet;

    fn planned(scheme: OrderScheme) -> Vec<PlannedTrial> {
        let mut study = demo();
        study.design.order = scheme;
        order::draw(&study, 1, 1, 7)
    }

    fn sealed(trial: u32, mode: &str, is_standard: Option<bool>) -> SealedTrial {
        SealedTrial { trial, mode: mode.parse().unwrap(), is_standard }
    }

    fn seal() -> Seal {
        Seal::new([7; 32], &planned(OrderScheme::Williams))
    }

    /// Nonce 0, 1, … 31; trial 1 hybrid, trial 2 active.
    const COMMITMENT: &str = "b46416acc4a09d22c6008e9de9e23ed257315545aa8b652464b64b4d2b226ceb";
    const CODE: &str = "sealed-2e4fc41ffd239f58";

    /// The numbers come from a separate BLAKE3 written in Python from its paper.
    #[test]
    fn commitment_and_code_are_those_of_the_documented_bytes() {
        let order = vec![sealed(1, "hybrid", None), sealed(2, "active", None)];
        let seal = Seal { nonce: std::array::from_fn(|i| i as u8), order };
        assert_eq!(seal.commitment(), COMMITMENT);
        assert_eq!(seal.code(2).as_str(), CODE);
    }

    #[test]
    fn only_the_same_order_and_nonce_verify() {
        let seal = seal();
        let commitment = seal.commitment();
        assert_eq!(seal.verify(&commitment), Ok(()));
        let mut swapped = seal.clone();
        let first = swapped.order[3].mode.clone();
        let other =
            swapped.order.iter().position(|own| own.trial > 4 && own.mode != first).unwrap();
        swapped.order[3].mode = swapped.order[other].mode.clone();
        swapped.order[other].mode = first;
        let renonced = Seal { nonce: [8; 32], ..seal.clone() };
        for other in [swapped, renonced] {
            assert!(other.verify(&commitment).unwrap_err().to_string().contains(&commitment));
        }
    }

    #[test]
    fn codes_differ_from_trial_to_trial_and_know_nothing_of_the_modes() {
        let seal = seal();
        let codes: BTreeSet<ModeId> = (1..=10_000).map(|trial| seal.code(trial)).collect();
        assert_eq!(codes.len(), 10_000);
        assert!(codes.iter().all(ModeId::is_code));
        let all_active = seal.order.iter().map(|own| sealed(own.trial, "active", None)).collect();
        let other = Seal { order: all_active, ..seal.clone() };
        assert!((1..100).all(|trial| other.code(trial) == seal.code(trial)));
    }

    /// Whatever a masked session shows is the same for two orders of the modes.
    #[test]
    fn a_masked_session_shows_nothing_that_depends_on_the_modes() {
        for scheme in [OrderScheme::Williams, OrderScheme::Constrained] {
            let trials = planned(scheme);
            let seal = Seal::new([7; 32], &trials);
            let turned = |t: &PlannedTrial| PlannedTrial {
                mode: "active".parse().unwrap(),
                repeat: 1,
                ..t.clone()
            };
            let turned: Vec<_> = trials.iter().map(turned).collect();
            assert_eq!(seal.masked(&trials), seal.masked(&turned));
        }
    }

    #[test]
    fn opening_undoes_masking() {
        for scheme in [OrderScheme::Williams, OrderScheme::Constrained] {
            let trials = planned(scheme);
            let seal = Seal::new([7; 32], &trials);
            assert_eq!(seal.opened(&seal.masked(&trials)), Ok(trials));
        }
    }

    /// Trials of a session with a task of two intervals.
    fn presented() -> Vec<PlannedTrial> {
        let study = crate::tests::with_task(crate::tests::CONSTANT).unwrap();
        order::draw(&study, 1, 1, 7)
    }

    /// The numbers come from a separate BLAKE3 of the documented text.
    #[test]
    fn which_interval_holds_the_standard_is_part_of_the_commitment() {
        let order = vec![sealed(1, "hybrid", Some(true)), sealed(2, "hybrid", Some(false))];
        let text = "1 hybrid standard\n2 hybrid comparison\n";
        let nonce: [u8; 32] = std::array::from_fn(|i| i as u8);
        let expect =
            blake3::hash(&[nonce.as_slice(), text.as_bytes()].concat()).to_hex().to_string();
        assert_eq!(Seal { nonce, order }.commitment(), expect);
        let seal = Seal::new([7; 32], &presented());
        let mut swapped = seal.clone();
        let two = swapped.order.iter().position(|own| own.is_standard == Some(true)).unwrap();
        swapped.order[two].is_standard = Some(false);
        assert!(swapped.verify(&seal.commitment()).is_err());
    }

    #[test]
    fn a_masked_session_does_not_show_which_interval_holds_the_standard() {
        let trials = presented();
        let seal = Seal::new([7; 32], &trials);
        let masked = seal.masked(&trials);
        let turned = |t: &PlannedTrial| PlannedTrial {
            mode: "active".parse().unwrap(),
            task: t.task.as_ref().map(|place| TaskPlace {
                is_standard: place.is_standard.map(|holds| !holds),
                ..place.clone()
            }),
            ..t.clone()
        };
        let turned: Vec<_> = trials.iter().map(turned).collect();
        // In one mode all along, its presentations are counted through.
        let opened = Seal::new([7; 32], &turned).opened(&masked).unwrap();
        assert_eq!(seal.masked(&opened), masked);
        assert!(
            masked.iter().all(|t| t.task.as_ref().is_none_or(|place| place.is_standard.is_none()))
        );
        assert_eq!(seal.opened(&masked), Ok(trials));
        let Event::Unsealed { nonce, order } = seal.event() else { panic!() };
        assert_eq!(Seal::from_event(&nonce, &order), Ok(seal.clone()));
        assert_eq!(Seal::from_json(&seal.to_json().unwrap()), Ok(seal));
    }

    #[test]
    fn a_trial_that_was_not_sealed_or_has_another_code_is_not_opened() {
        let seal = seal();
        let masked = seal.masked(&planned(OrderScheme::Williams));
        for other in [
            PlannedTrial { trial: 99, ..masked[5].clone() },
            PlannedTrial { mode: "hybrid".parse().unwrap(), ..masked[5].clone() },
            PlannedTrial { mode: seal.code(1), ..masked[5].clone() },
        ] {
            let error = seal.opened(&[masked[0].clone(), other.clone()]).unwrap_err();
            assert_eq!(error, SealError::OtherTrial { trial: other.trial, code: other.mode });
        }
    }

    #[test]
    fn file_and_event_bring_the_seal_back() {
        let seal = seal();
        assert_eq!(Seal::from_json(&seal.to_json().unwrap()), Ok(seal.clone()));
        let Event::Unsealed { nonce, order } = seal.event() else { panic!() };
        assert_eq!(Seal::from_event(&nonce, &order), Ok(seal));
        for bad in ["", "{}", "{\"nonce\":\"00\",\"order\":[]}"] {
            assert!(Seal::from_json(bad).unwrap_err().to_string().contains("not a seal"));
        }
    }
}
