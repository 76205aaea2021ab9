//! The description of a stream: XML, of which a few texts are read.

use super::super::limits::MOST_COLUMNS;
use super::super::xml::{Event, Xml};
use std::borrow::Cow;

/// The format of a stream's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Written {
    Float32,
    Double64,
    Int8,
    Int16,
    Int32,
    Int64,
    Text,
}

impl Written {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "float32" => Self::Float32,
            "double64" => Self::Double64,
            "int8" => Self::Int8,
            "int16" => Self::Int16,
            "int32" => Self::Int32,
            "int64" => Self::Int64,
            "string" => Self::Text,
            _ => return None,
        })
    }

    /// Bytes of a number; 0 for texts.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Text => 0,
            Self::Int8 => 1,
            Self::Int16 => 2,
            Self::Int32 | Self::Float32 => 4,
            Self::Int64 | Self::Double64 => 8,
        }
    }

    /// The number in bytes of its size.
    #[allow(clippy::cast_precision_loss)] // Whole numbers past 2⁵³ become the nearest one, as in every other format.
    pub(super) fn number(self, bytes: &[u8]) -> Option<f64> {
        Some(match self {
            Self::Text => return None,
            Self::Int8 => f64::from(i8::from_le_bytes(bytes.try_into().ok()?)),
            Self::Int16 => f64::from(i16::from_le_bytes(bytes.try_into().ok()?)),
            Self::Int32 => f64::from(i32::from_le_bytes(bytes.try_into().ok()?)),
            Self::Int64 => i64::from_le_bytes(bytes.try_into().ok()?) as f64,
            Self::Float32 => f64::from(f32::from_le_bytes(bytes.try_into().ok()?)),
            Self::Double64 => f64::from_le_bytes(bytes.try_into().ok()?),
        })
    }
}

/// The header of a stream.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) name: String,
    pub(super) channels: usize,
    /// Samples a second, 0 where they come as they do.
    pub(super) rate_hz: f64,
    pub(super) written: Written,
    /// The channels' labels, empty where there is none.
    pub(super) labels: Vec<String>,
    /// The channels' units, empty where there is none.
    pub(super) units: Vec<String>,
    /// Whether samples may be left out: then its times are not those of a steady clock.
    pub(super) may_drop: bool,
}

/// The header in a text; `Err` says what it lacks.
pub(super) fn header(xml: &str) -> Result<Header, String> {
    let mut name = None;
    let mut count = None;
    let mut rate = None;
    let mut format = None;
    let mut labels = Vec::<String>::new();
    let mut units = Vec::<String>::new();
    let mut may_drop = false;
    elements(xml, &mut |path, text| match (path, text) {
        (["info", "name"], Some(text)) => name = Some(text.into_owned()),
        (["info", "channel_count"], Some(text)) => count = text.parse::<usize>().ok(),
        (["info", "nominal_srate"], Some(text)) => rate = text.parse::<f64>().ok(),
        (["info", "channel_format"], Some(text)) => format = Written::of(&text),
        (["info", "desc", "channels", "channel"], None) => {
            labels.push(String::new());
            units.push(String::new());
        }
        (["info", "desc", "channels", "channel", "unit"], Some(text)) => {
            if let Some(unit) = units.last_mut() {
                unit.push_str(&text);
            }
        }
        (["info", "desc", "channels", "channel", "label"], Some(text)) => {
            if let Some(label) = labels.last_mut() {
                label.push_str(&text);
            }
        }
        (["info", "desc", "synchronization", "can_drop_samples"], Some(text)) => {
            may_drop = text.eq_ignore_ascii_case("true");
        }
        _ => {}
    })?;
    let channels = count.filter(|count| (1..=MOST_COLUMNS).contains(count));
    // A header may describe more channels than it counts, or fewer.
    labels.resize(channels.unwrap_or(0), String::new());
    units.resize(channels.unwrap_or(0), String::new());
    Ok(Header {
        name: name.unwrap_or_default(),
        channels: channels
            .ok_or_else(|| format!("its channel_count is not from 1 to {MOST_COLUMNS}"))?,
        rate_hz: rate
            .filter(|rate| rate.is_finite() && *rate >= 0.0)
            .ok_or("its nominal_srate is not a rate")?,
        written: format.ok_or("its channel_format is not known")?,
        labels,
        units,
        may_drop,
    })
}

/// The number of samples that a stream's footer counts.
pub(super) fn sample_count(xml: &str) -> Option<u64> {
    let mut count = None;
    let read = elements(xml, &mut |path, text| {
        if let (["info", "sample_count"], Some(text)) = (path, text) {
            count = text.parse().ok();
        }
    });
    read.ok().and(count)
}

/// Takes the path of an element, and a text in it.
type Visit<'v, 'a> = &'v mut dyn FnMut(&[&'a str], Option<Cow<'a, str>>);

/// Gives the path of every element as it begins, and with each text in it.
fn elements<'a>(xml: &'a str, visit: Visit<'_, 'a>) -> Result<(), String> {
    let mut path: Vec<&str> = Vec::new();
    let mut reader = Xml::new(xml);
    while let Some(event) = reader.next()? {
        match event {
            Event::Begin { name, .. } => {
                path.push(name);
                visit(&path, None);
            }
            Event::Text(text) if text.trim().is_empty() => {}
            Event::Text(Cow::Borrowed(text)) => visit(&path, Some(Cow::Borrowed(text.trim()))),
            Event::Text(Cow::Owned(text)) => {
                visit(&path, Some(Cow::Owned(text.trim().to_owned())));
            }
            Event::End(_) => {
                path.pop();
            }
        }
    }
    Ok(())
}
