//! The tasks of a session that goes on: what its log says happened, event by event.

use super::Tasks;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{Event, TaskLevel};

impl Tasks {
    /// Follows a log. `numbers` are those of the planned trials, by place. Each level that the log has is held against the
    /// one that follows from the plan and the answers before it.
    ///
    /// # Errors
    /// A level that is another one, in words.
    pub(crate) fn replay(&mut self, numbers: &[u32], events: &[Event]) -> Result<(), String> {
        if self.presentations.is_empty() {
            return Ok(());
        }
        // The trial that holds each place, and the place of each trial that ever did.
        let mut holders: Vec<u32> = numbers.to_vec();
        let mut places: BTreeMap<u32, usize> =
            numbers.iter().enumerate().map(|(place, trial)| (*trial, place)).collect();
        let mut excluded: BTreeSet<usize> = BTreeSet::new();
        for event in events {
            let Some(place) = event.trial().and_then(|trial| places.get(&trial).copied()) else {
                continue;
            };
            match event {
                // Numbers only grow; an event that says otherwise is not followed.
                Event::Superseded { trial, by } if by > trial => {
                    places.insert(*by, place);
                    holders[place] = *by;
                    excluded.remove(&place);
                    self.forget(place);
                }
                Event::Excluded { trial, .. } if holders[place] == *trial => {
                    excluded.insert(place);
                    self.forget(place);
                }
                Event::Level { trial, level } => self.check(place, *trial, *level)?,
                Event::Answer { trial, question, value, .. } if holders[place] == *trial => {
                    let is_own = self.at(place).is_some_and(|p| self.tasks[p.task].id == *question);
                    let counts = !self.places(place).any(|own| excluded.contains(&own));
                    if is_own
                        && counts
                        && !self.is_followed(place)
                        && let Some(value) = value.whole()
                    {
                        // What is to be told was told when it was answered.
                        let _ = self.answered(place, value);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Takes a level from the log.
    fn check(&mut self, place: usize, trial: u32, logged: TaskLevel) -> Result<(), String> {
        let Some(index) = self.of_place[place] else {
            return Err(format!("the log gives trial {trial} a level, and it is of no task"));
        };
        let expect = self.level(&self.presentations[index]);
        if expect != Some(logged) {
            let expect = expect.map_or("none".to_owned(), |level| level.value().to_string());
            return Err(format!(
                "the log gives trial {trial} the level {}, and by the plan and the answers before it the level is {expect}",
                logged.value()
            ));
        }
        let presentation = &mut self.presentations[index];
        presentation.level = Some(logged);
        presentation.logged = Some(trial);
        Ok(())
    }
}
