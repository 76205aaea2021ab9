//! What the attributes of a data set say about its numbers: `scale_factor` and `add_offset` of the
//! CF conventions, `conversion` and `offset` of NWB, the numbers that stand for a missing value,
//! and the unit.
//!
//! Source: CF Conventions 1.11, 2.5 and 8.1; NWB 2.8, `TimeSeries`, and `ElectricalSeries` for the factor of
//! each channel; NetCDF User's Guide, "Attribute Conventions".

use arrow::array::Float64Array;
use hdf5_pure::{AttrValue, Dataset};
use std::collections::HashMap;

/// The factors that a data set may name; the second is that of NWB.
const FACTORS: [&str; 2] = ["scale_factor", "conversion"];
const OFFSETS: [&str; 2] = ["add_offset", "offset"];
/// The data set beside the numbers that has a factor for each channel, in NWB.
pub(super) const CHANNEL_FACTORS: &str = "channel_conversion";
/// Factors of channels that are told.
const MOST_NAMED: usize = 8;
const MISSING: [&str; 2] = ["_FillValue", "missing_value"];

/// The conversion of stored numbers to those that are meant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Packing {
    factor: f64,
    offset: f64,
    /// Numbers as stored that stand for a missing one.
    missing: Vec<f64>,
    /// Added to a number below zero: whole numbers that netCDF stores as if they had a sign.
    wraps_at: Option<f64>,
    /// The attributes that are applied.
    names: Vec<&'static str>,
    /// The unit that is named.
    pub(super) unit: Option<String>,
}

impl Packing {
    /// Reads the attributes of a data set.
    ///
    /// # Errors
    /// Why they cannot be applied, in words.
    pub(super) fn new(data: &Dataset) -> Result<Self, String> {
        // The library passes by values that it cannot decode; their names stand here all the same.
        let kinds = data.attr_datatypes().map_err(failed)?;
        let values = data.attrs().map_err(failed)?;
        let mut packing = Self {
            factor: 1.0,
            offset: 0.0,
            missing: Vec::new(),
            wraps_at: None,
            names: Vec::new(),
            unit: unit(&values),
        };
        for (names, value, neutral) in
            [(FACTORS, &mut packing.factor, 1.0), (OFFSETS, &mut packing.offset, 0.0)]
        {
            for name in names {
                if !kinds.contains_key(name) {
                    continue;
                }
                let number = match values.get(name).and_then(numbers).as_deref() {
                    Some([number]) if number.is_finite() => *number,
                    _ => {
                        let what = format!("its attribute '{name}' is not one finite number");
                        return Err(format!("{what}; {REMEDY}"));
                    }
                };
                #[allow(clippy::float_cmp)] // What changes no number.
                if number == neutral {
                    continue;
                }
                if number == 0.0 {
                    return Err(format!("its attribute '{name}' is 0; {REMEDY}"));
                }
                *value = number;
                packing.names.push(name);
            }
        }
        let nwb = packing.names.iter().filter(|name| [FACTORS[1], OFFSETS[1]].contains(name));
        let nwb = nwb.count();
        if nwb > 0 && nwb < packing.names.len() {
            let names = packing.names.join("' and '");
            return Err(format!(
                "it has the attributes '{names}' beside each other, and which is meant nobody knows; {REMEDY}"
            ));
        }
        for name in MISSING.into_iter().filter(|name| kinds.contains_key(*name)) {
            let missing = values.get(name).and_then(numbers);
            let missing = missing
                .ok_or_else(|| format!("its attribute '{name}' is not a number; {REMEDY}"))?;
            packing.missing.extend(missing);
        }
        // NetCDF 3 has no unsigned numbers: the attribute says that one below 0 is past the highest.
        let is_unsigned = values.get("_Unsigned").and_then(AttrValue::as_str);
        if is_unsigned.is_some_and(|word| word.eq_ignore_ascii_case("true")) {
            let bits = data.element_size().map_err(failed)?.saturating_mul(8);
            packing.wraps_at = i32::try_from(bits).ok().map(|bits| 2_f64.powi(bits));
            packing.names.push("_Unsigned");
        }
        Ok(packing)
    }

    /// Whether every number is meant as it is stored.
    pub(super) fn is_plain(&self) -> bool {
        self.names.is_empty() && self.missing.is_empty()
    }

    /// The numbers that are meant, with a factor of their own besides; missing ones null.
    pub(super) fn unpack(
        &self,
        stored: impl Iterator<Item = f64>,
        own_factor: f64,
    ) -> Float64Array {
        if self.is_plain() && own_factor.to_bits() == 1_f64.to_bits() {
            return stored.map(Some).collect();
        }
        let numbers = stored.map(|stored| {
            // Missing values are named as they are stored, before the conversion.
            if self.missing.contains(&stored) {
                return None;
            }
            let whole = match self.wraps_at {
                Some(wraps_at) if stored < 0.0 => stored + wraps_at,
                _ => stored,
            };
            Some(whole * (self.factor * own_factor) + self.offset)
        });
        numbers.collect()
    }

    /// The conversion in words, with the factors of channels if there are any; `None` if it changes nothing.
    pub(super) fn words(&self, channels: Option<&[f64]>) -> Option<String> {
        let Self { factor, offset, .. } = self;
        let names = self.names.iter().copied().chain(channels.map(|_| CHANNEL_FACTORS));
        let names = Vec::from_iter(names).join(", ");
        let each = channels.map(|channels| {
            let some = channels.iter().take(MOST_NAMED).map(f64::to_string).collect::<Vec<_>>();
            let more = if channels.len() > MOST_NAMED { ", …" } else { "" };
            format!(" × {}{more} channel by channel", some.join(", "))
        });
        let each = each.unwrap_or_default();
        (!names.is_empty()).then(|| {
            format!("its numbers are those stored × {factor}{each} + {offset}, as its attributes say ({names})")
        })
    }
}

fn failed(error: hdf5_pure::Error) -> String {
    format!("its attributes cannot be read: {error}")
}

/// What to do about attributes that cannot be applied. `tests/interop/foreign.py` tries the line.
const REMEDY: &str = "take away those that do not hold, from a copy: python -c \"import sys, h5py; \
     a = h5py.File(sys.argv[1], 'r+')[sys.argv[2]].attrs; [a.pop(n) for n in sys.argv[3:]]\" COPY DATASET ATTRIBUTES…";

/// The numbers of an attribute; none if it holds something else.
#[allow(clippy::cast_precision_loss)] // Past 2⁵³ the nearest one, as the data are read.
fn numbers(value: &AttrValue) -> Option<Vec<f64>> {
    value.to_f64s().or_else(|| {
        let whole = value.to_i64s().map(|all| all.into_iter().map(|n| n as f64).collect());
        whole.or_else(|| value.to_u64s().map(|all| all.into_iter().map(|n| n as f64).collect()))
    })
}

/// The unit that attributes name: `unit` in NWB, `units` elsewhere. A time may be counted from a date,
/// `seconds since 2026-01-31`.
fn unit(attributes: &HashMap<String, AttrValue>) -> Option<String> {
    let text = ["units", "unit"].iter().find_map(|name| attributes.get(*name)?.as_str())?;
    let text = text.split(" since ").next().unwrap_or(text).trim();
    (!text.is_empty()).then(|| text.to_owned())
}
