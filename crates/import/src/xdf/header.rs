//! The description of a stream: XML, of which a few texts are read.

use super::super::limits::MOST_COLUMNS;
use super::super::table::{Number, NumberKind};
use super::super::xml::{Event, Xml};

/// The format of a stream's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Written {
    Number(Number),
    Text,
}

impl Written {
    fn of(word: &str) -> Option<Self> {
        let (kind, size) = match word {
            "string" => return Some(Self::Text),
            "float32" => (NumberKind::Float, 4),
            "double64" => (NumberKind::Float, 8),
            "int8" => (NumberKind::Signed, 1),
            "int16" => (NumberKind::Signed, 2),
            "int32" => (NumberKind::Signed, 4),
            "int64" => (NumberKind::Signed, 8),
            _ => return None,
        };
        Some(Self::Number(Number { kind, size, big: false }))
    }
}

/// A channel of a stream.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Channel {
    /// Its label, or one of its number where it has none.
    pub(crate) name: String,
    /// Its unit, empty where there is none.
    pub(crate) unit: String,
}

/// The header of a stream.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    pub(crate) name: String,
    /// What it says it holds (`EEG`), which program or device it names as its source, and the outlet that it came from: each
    /// start of an outlet has an id of its own.
    pub(crate) kind: String,
    pub(crate) source_id: String,
    pub(crate) uid: String,
    pub(crate) channels: Vec<Channel>,
    /// Samples a second, 0 where they come as they do.
    pub(crate) rate_hz: f64,
    pub(super) written: Written,
    /// Whether samples may be left out: then its times are not those of a steady clock.
    pub(super) may_drop: bool,
}

/// The header in a text; `Err` says what it lacks.
pub(super) fn header(xml: &str) -> Result<Header, String> {
    let mut name = None;
    let [mut kind, mut source_id, mut uid] = [const { String::new() }; 3];
    let mut count = None;
    let mut rate = None;
    let mut format = None;
    let mut channels = Vec::<Channel>::new();
    let mut may_drop = false;
    elements(xml, &mut |path, text| match (path, text) {
        (["info", "name"], Some(text)) => name = Some(text.to_owned()),
        (["info", "type"], Some(text)) => text.clone_into(&mut kind),
        (["info", "source_id"], Some(text)) => text.clone_into(&mut source_id),
        (["info", "uid"], Some(text)) => text.clone_into(&mut uid),
        (["info", "channel_count"], Some(text)) => count = text.parse::<usize>().ok(),
        (["info", "nominal_srate"], Some(text)) => rate = text.parse::<f64>().ok(),
        (["info", "channel_format"], Some(text)) => format = Written::of(text),
        (["info", "desc", "channels", "channel"], None) => channels.push(Channel::default()),
        (["info", "desc", "channels", "channel", part], Some(text)) => {
            let Some(channel) = channels.last_mut() else { return };
            match *part {
                "unit" => channel.unit.push_str(text),
                "label" => channel.name.push_str(text),
                _ => {}
            }
        }
        (["info", "desc", "synchronization", "can_drop_samples"], Some(text)) => {
            may_drop = text.eq_ignore_ascii_case("true");
        }
        _ => {}
    })?;
    let count = count.filter(|count| (1..=MOST_COLUMNS).contains(count));
    let count =
        count.ok_or_else(|| format!("its channel_count is not from 1 to {MOST_COLUMNS}"))?;
    // A header may describe more channels than it counts, or fewer.
    channels.resize(count, Channel::default());
    for (i, channel) in channels.iter_mut().enumerate().filter(|(_, one)| one.name.is_empty()) {
        channel.name = format!("channel_{}", i + 1);
    }
    Ok(Header {
        name: name.unwrap_or_default(),
        kind,
        source_id,
        uid,
        channels,
        rate_hz: rate
            .filter(|rate| rate.is_finite() && *rate >= 0.0)
            .ok_or("its nominal_srate is not a rate")?,
        written: format.ok_or("its channel_format is not known")?,
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
type Visit<'v> = &'v mut dyn FnMut(&[&str], Option<&str>);

/// Gives the path of every element as it begins, and with each text in it.
fn elements(xml: &str, visit: Visit) -> Result<(), String> {
    let mut path: Vec<&str> = Vec::new();
    let mut reader = Xml::new(xml);
    while let Some(event) = reader.next()? {
        match event {
            Event::Begin { name, .. } => {
                path.push(name);
                visit(&path, None);
            }
            Event::Text(text) if text.trim().is_empty() => {}
            Event::Text(text) => visit(&path, Some(text.trim())),
            Event::End(_) => {
                path.pop();
            }
        }
    }
    Ok(())
}
