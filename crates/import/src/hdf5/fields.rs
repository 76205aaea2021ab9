//! Data sets whose values have several fields: tables as h5py and PyTables write them, and the ranges of
//! Octave, `0:0.001:1`, of which the file has the first, the last and the step.

use super::super::limits::MOST_COLUMNS;
use super::super::table::{Cells, Number, NumberKind};
use super::super::text::HDF5;
use super::links::MOST_DEPTH;
use hdf5_pure::{
    AttrValue, CompoundMember, Dataset, Datatype, DatatypeByteOrder, FixedPointLayout,
    FloatingPointLayout,
};

/// The fields of a table.
pub(super) struct Fields {
    /// Bytes of a row.
    row: usize,
    all: Vec<Field>,
}

struct Field {
    name: String,
    from: usize,
    /// How its number is written; nothing if it is none.
    number: Option<Number>,
}

impl Fields {
    /// The fields of a data set; nothing if it is no table. A complex number is none, though it has two.
    pub(super) fn new(data: &Dataset) -> Option<Self> {
        let Ok(Datatype::Compound { size, members }) = data.datatype() else { return None };
        if is_complex(&members) {
            return None;
        }
        let mut all = Vec::new();
        add_fields(&members, "", 0, &mut all)?;
        Some(Self { row: usize::try_from(size).ok()?, all })
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.all.iter().map(|field| field.name.as_str())
    }

    /// The values of a field in so many rows, or why it has none; nothing if there is no such field, or not so
    /// many rows.
    pub(super) fn values(&self, name: &str, bytes: &[u8], rows: usize) -> Option<Cells> {
        let field = self.all.iter().find(|field| field.name == name)?;
        let Some(number) = field.number else {
            let what = format!(
                "it is a field without numbers of its own (texts, arrays, complex); {HDF5}"
            );
            return Some(Cells::Other(what));
        };
        let end = field.from.checked_add(number.size).filter(|end| *end <= self.row)?;
        if bytes.len() != rows.checked_mul(self.row)? {
            return None;
        }
        let cells = bytes.chunks_exact(self.row).map(|row| &row[field.from..end]);
        Some(match number.kind {
            NumberKind::Float => {
                Cells::Numbers(cells.map(|cell| Some(number.read(cell))).collect())
            }
            _ => Cells::whole(cells.map(|cell| Some(number.whole(cell)))),
        })
    }
}

/// Adds the fields of a table, those within fields by their path, `s/angle`; nothing if a place or a size is
/// none, or if there are too many.
fn add_fields(
    members: &[CompoundMember],
    before: &str,
    base: usize,
    all: &mut Vec<Field>,
) -> Option<()> {
    for member in members {
        let name = format!("{before}{}", member.name);
        let from = base.checked_add(usize::try_from(member.byte_offset).ok()?)?;
        match &member.datatype {
            Datatype::Compound { members, .. } if !is_complex(members) => {
                (name.matches('/').count() < MOST_DEPTH).then_some(())?;
                add_fields(members, &format!("{name}/"), from, all)?;
            }
            kind => {
                // A type may hold types: a few bytes describe very many fields.
                (all.len() < MOST_COLUMNS).then_some(())?;
                all.push(Field { name, from, number: number(kind) });
            }
        }
    }
    Some(())
}

/// Whether the fields are the two parts of complex numbers.
fn is_complex(members: &[CompoundMember]) -> bool {
    let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
    matches!(names[..], ["r", "i"] | ["real", "imag"])
}

/// How numbers of a type are written, if they are of the usual ones.
fn number(datatype: &Datatype) -> Option<Number> {
    let size = usize::try_from(datatype.type_size()).ok()?;
    let (kind, order) = match datatype {
        Datatype::FixedPoint { size: 1 | 2 | 4 | 8, byte_order, layout } => {
            let &FixedPointLayout { signed, bit_offset: 0, bit_precision } = layout else {
                return None;
            };
            let kind = if signed { NumberKind::Signed } else { NumberKind::Unsigned };
            (kind, (usize::from(bit_precision) == 8 * size).then_some(*byte_order)?)
        }
        Datatype::FloatingPoint { byte_order, layout, .. }
            if (size == 4 && *layout == FloatingPointLayout::IEEE754_BINARY32)
                || (size == 8 && *layout == FloatingPointLayout::IEEE754_BINARY64) =>
        {
            (NumberKind::Float, *byte_order)
        }
        // What h5py has for true and false.
        Datatype::Enumeration { base_type, .. } => {
            // A damaged file may give it another size than its numbers have.
            return number(base_type).filter(|base| base.size == size);
        }
        _ => return None,
    };
    let big = match order {
        DatatypeByteOrder::LittleEndian => false,
        DatatypeByteOrder::BigEndian => true,
        _ => return None,
    };
    Some(Number { kind, size, big })
}

/// The values of a range of Octave's; nothing if the data set is none.
///
/// Source: Octave 9, `ov-range.cc`: the compound's fields are `base`, `limit` and `increment`, and an attribute
/// has the number of values. The last does not pass the limit.
pub(super) fn octave_range(data: &Dataset) -> Option<Result<Vec<f64>, String>> {
    const COUNT: &str = "OCTAVE_RANGE_NELEM";
    let fields = Fields::new(data)?;
    let names: Vec<&str> = fields.names().collect();
    if names != ["base", "limit", "increment"] {
        return None;
    }
    let Ok(bytes) = data.read_raw() else { return Some(Err("a range cannot be read".to_owned())) };
    let parts = ["base", "limit", "increment"].map(|name| match fields.values(name, &bytes, 1) {
        Some(Cells::Numbers(values)) => values.iter().next().flatten(),
        _ => None,
    });
    let [Some(base), Some(limit), Some(step)] = parts else {
        return Some(Err("a range has no numbers".to_owned()));
    };
    let named = data.attrs().ok().and_then(|all| all.get(COUNT).and_then(AttrValue::as_u64));
    // Where the attribute is missing; the quotient may lie a hair below a whole number.
    let counted = ((limit - base) / step * (1.0 + f64::EPSILON)).floor() + 1.0;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // What is no number is 0.
    let count = named.unwrap_or(counted as u64).min(u64::from(u32::MAX));
    if count > super::super::limits::MOST_WHOLE_ROWS as u64 {
        return Some(Err(format!("a range has {count} values, and fewer are read")));
    }
    let values = (0..count).map(|i| {
        #[allow(clippy::cast_precision_loss)] // Checked.
        let value = base + i as f64 * step;
        if step > 0.0 { value.min(limit) } else { value.max(limit) }
    });
    Some(Ok(values.collect()))
}
