//! The levels of people that chance gives.

use crate::people::{Known, People, PersonColumn, PersonValue};
use crate::{LevelId, SessionRecord, order};

impl PersonColumn {
    /// Whether chance chooses everybody's level.
    pub fn is_drawn(&self) -> bool {
        matches!(self.known, Known::Level { assigned: true, .. })
    }

    /// The level that chance gives the participant of that number in the counterbalancing, by the study's seed;
    /// `None` where chance chooses none. Of as many people as twice the number of levels, counted from 1, each
    /// level has two, in an order of its own. With the block, from 0.
    pub fn drawn(&self, participant_number: u32, seed: u64) -> Option<(LevelId, u32)> {
        match &self.known {
            Known::Level { levels, assigned: true } => {
                let (block, place) =
                    order::in_block(self.id.as_str(), participant_number, levels.len(), seed);
                Some((levels.get(place)?.clone(), block))
            }
            _ => None,
        }
    }
}

impl People {
    /// Adds the levels that chance gave when a session began, where the file says nothing of them.
    pub fn with_drawn<'a>(
        mut self,
        columns: &[PersonColumn],
        records: impl Iterator<Item = &'a SessionRecord>,
    ) -> Self {
        for record in records {
            for id in record.drawn.keys() {
                let column = columns.iter().find(|column| column.id == *id);
                let (Some(Known::Level { levels, .. }), Some(PersonValue::Level(level))) =
                    (column.map(|column| &column.known), record.person.get(id))
                else {
                    continue;
                };
                // One that study.toml has no longer is not known.
                if levels.contains(level) {
                    let row = self.0.entry(record.participant.clone()).or_default();
                    row.entry(id.clone()).or_insert_with(|| PersonValue::Level(level.clone()));
                }
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(id: &str, levels: &[&str], assigned: bool) -> PersonColumn {
        let levels = levels.iter().map(|level| level.parse().unwrap()).collect();
        PersonColumn { id: id.parse().unwrap(), known: Known::Level { levels, assigned } }
    }

    #[test]
    fn chance_gives_every_level_twice_in_each_block_and_columns_apart() {
        let levels = ["a", "b", "c"];
        let group = column("group", &levels, true);
        let drawn = |column: &PersonColumn, seed: u64| -> Vec<String> {
            (1..=60).map(|number| column.drawn(number, seed).unwrap().0.to_string()).collect()
        };
        let of_group = drawn(&group, 7);
        for block in of_group.chunks(6) {
            for level in levels {
                assert_eq!(block.iter().filter(|own| *own == level).count(), 2, "{block:?}");
            }
        }
        let blocks: std::collections::BTreeSet<&[String]> = of_group.chunks(6).collect();
        assert!(blocks.len() > 5, "each block has an order of its own");
        assert_eq!(of_group, drawn(&group, 7));
        assert_ne!(of_group, drawn(&group, 8));
        assert_ne!(of_group, drawn(&column("crew", &levels, true), 7));
        assert_eq!([1, 6, 7].map(|number| group.drawn(number, 7).unwrap().1), [0, 0, 1]);
        assert!(group.drawn(0, 7).unwrap().1 > 100_000_000, "nobody is in the block of 0");
        assert_eq!(column("group", &levels, false).drawn(1, 7), None);
        let number = Known::Number { unit: "years".to_owned() };
        assert_eq!(PersonColumn { known: number, ..group }.drawn(1, 7), None);
    }
}
