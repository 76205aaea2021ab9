//! The units that files name for their columns, compared with those of the mapping.

use super::convert::Linear;
use super::recording::Recording;
use super::unit::{Dimension, Unit, declared};
use zwidth_store::StoreError;

impl Recording {
    /// A note about the unit that the file names for a column, if the mapping has another one; a column
    /// that the mapping scales has the unit of the result there.
    ///
    /// # Errors
    /// The unit belongs to the type of the column, and the mapping has another.
    pub(super) fn check_unit(
        &self,
        column: usize,
        unit: &Unit,
        text: &str,
        line: &Linear,
    ) -> Result<Option<String>, StoreError> {
        // A mapping that scales may well make another unit of the file's.
        let is_scaled = line.scale.to_bits() != 1_f64.to_bits();
        let of_angles = self.table.angles.zip(match unit.dimension {
            Dimension::Angle => Some(0),
            Dimension::AngularVelocity => Some(1),
            _ => None,
        });
        let of_angles = of_angles.map(|(units, which)| (units[which], false));
        let of_column = self.table.units.get(&column).map(|one| (one.unit.as_str(), one.is_type));
        let Some((named, is_type)) = of_column.or(of_angles).filter(|_| !is_scaled) else {
            return Ok(None);
        };
        let Some(theirs) = declared(named) else { return Ok(None) };
        #[allow(clippy::float_cmp)] // The constants of one table.
        if theirs.dimension == unit.dimension && theirs.to_si == unit.to_si {
            return Ok(None);
        }
        let name = self.table.name(column);
        if is_type {
            let what = format!("it counts in {named}, and the mapping says {text}");
            let remedy = format!("set unit = \"{named}\"");
            return Err(self.error(what, remedy).column(name));
        }
        Ok(Some(format!(
            "column {name}: the file says that its unit is '{}', and the mapping takes it for {text}",
            super::spelling::shown(named)
        )))
    }
}
