//! MCAP, the container of ROS 2 bags and of Foxglove: messages of topics.
//!
//! Source of the format: "MCAP Format Specification" (mcap.dev/spec). By hand: of damaged files some end the program in
//! `mcap` 0.26 by asking for more memory than there is. Whatever the index at the end says, records are read one after
//! the other, so that of a recorder that was killed only the last is missing.

mod records;
mod ros;
#[cfg(test)]
pub(super) mod tests;
mod values;

use super::limits::Take;
use super::spelling::shown;
use super::table::{Table, listed};
use records::{Known, MAGIC, walk};
use ros::Definition;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use values::{Columns, Leaf};
use zwidth_store::StoreError;

const REMEDY: &str = "copy the file again, or try the command `mcap recover` of its makers";
/// The columns behind those of a message: when it was logged, and published, ns.
const LOG_TIME: &str = "log_time";
const PUBLISH_TIME: &str = "publish_time";

/// How messages are written.
enum Form {
    Ros(Definition),
    Json,
}

/// Reads the messages of a topic, a row each: their values by path (`wrench.force.x`, `position[0]`), then the times at
/// which they were logged and published.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    topic: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let unreadable =
        |why: &str| StoreError::new(path, format!("not a readable MCAP file: {why}"), REMEDY);
    if !bytes.starts_with(MAGIC) {
        return Err(unreadable("it does not begin as one"));
    }
    // Topics first: which is meant may need all of them.
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut known = Known::default();
    let lost = walk(bytes, &mut known, &mut |known, message| {
        if let Some(channel) = known.channels.get(&message.channel) {
            *counts.entry(channel.topic.clone()).or_default() += 1;
        }
        Ok(())
    })
    .map_err(|why| unreadable(&why))?;
    let topic = match (topic, Vec::from_iter(counts.keys()).as_slice()) {
        (Some(topic), _) if counts.contains_key(topic) => topic.to_owned(),
        (None, [only]) => (*only).clone(),
        (wanted, topics) => {
            let list = listed(topics.iter().map(|topic| format!("'{}'", shown(topic))));
            let what = match wanted {
                _ if topics.is_empty() => match lost {
                    // What is not there cannot be read, whatever topic is named.
                    Some(why) => return Err(unreadable(&why)),
                    None => "the file has no messages".to_owned(),
                },
                Some(wanted) => {
                    format!("no message is of topic '{}'; the file has {list}", shown(wanted))
                }
                None => format!("{} topics have messages: {list}", topics.len()),
            };
            return Err(StoreError::new(path, what, "set topic in [file] to a topic of the file"));
        }
    };
    let mut forms: BTreeMap<u16, Form> = BTreeMap::new();
    for (number, channel) in known.channels.iter().filter(|(_, channel)| channel.topic == topic) {
        let schema = known.schemas.get(&channel.schema).cloned().unwrap_or_default();
        let form = match (channel.encoding.as_str(), schema.encoding.as_str()) {
            ("cdr", "ros2msg") => Definition::read(&schema.name, &schema.text).map(Form::Ros),
            ("json", _) => Ok(Form::Json),
            ("ros1", _) => Err("its messages are those of ROS 1".to_owned()),
            (encoding, description) => {
                Err(format!("its messages are '{encoding}', described by '{description}'"))
            }
        };
        let form = form.map_err(|why| {
            let what = format!("topic '{}' is not read: {}", shown(&topic), shown(&why));
            let remedy = "record messages of ROS 2 with their definitions (ros2msg), or JSON, or write the topic as CSV";
            StoreError::new(path, what, remedy)
        })?;
        forms.insert(*number, form);
    }
    let mut columns = Columns::new(path, take);
    let mut refused = None;
    let mut unread = 0_usize;
    let lost = walk(bytes, &mut Known::default(), &mut |_, message| {
        let Some(form) = forms.get(&message.channel) else { return Ok(()) };
        let mut add = |name: &str, leaf: Leaf| {
            columns.add(name, &leaf).map_err(|error| {
                refused.get_or_insert(error);
                String::new()
            })
        };
        let read = match form {
            Form::Ros(definition) => definition.walk(message.data, &mut add),
            Form::Json => match serde_json::from_slice(message.data) {
                Ok(value) => leaves(&value, &mut String::new(), &mut add),
                Err(error) => Err(error.to_string()),
            },
        };
        if read.is_err() {
            unread += 1;
        }
        let times = [(LOG_TIME, message.log_time), (PUBLISH_TIME, message.publish_time)];
        for (name, time) in times {
            let _: Result<(), String> = add(name, Leaf::Nanoseconds(time.into()));
        }
        match refused.is_some() {
            true => Err(String::new()),
            false => columns.end().map_err(|error| {
                refused = Some(error);
                String::new()
            }),
        }
    });
    if let Some(refused) = refused {
        return Err(refused);
    }
    let lost = lost.map_err(|why| unreadable(&why))?;
    let unread =
        (unread > 0).then(|| format!("{unread} messages are not as their description says"));
    let lost = Vec::from_iter([lost, unread].into_iter().flatten());
    let lost = (!lost.is_empty()).then(|| lost.join("; "));
    Ok(Table { lost, ..columns.table() })
}

/// Gives every value of a JSON text by its path.
fn leaves(
    value: &Value,
    path: &mut String,
    each: &mut dyn FnMut(&str, Leaf) -> Result<(), String>,
) -> Result<(), String> {
    let length = path.len();
    match value {
        Value::Null => Ok(()),
        Value::Bool(truth) => each(path, Leaf::Whole((*truth).into())),
        Value::String(text) => each(path, Leaf::Text(text)),
        Value::Number(number) => match (number.as_i64(), number.as_u64(), number.as_f64()) {
            (Some(whole), ..) => each(path, Leaf::Whole(whole.into())),
            (_, Some(whole), _) => each(path, Leaf::Whole(whole.into())),
            (_, _, number) => each(path, Leaf::Number(number.unwrap_or(f64::NAN))),
        },
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                path.push_str(&format!("[{i}]"));
                leaves(value, path, each)?;
                path.truncate(length);
            }
            Ok(())
        }
        Value::Object(fields) => {
            for (name, value) in fields {
                if length > 0 {
                    path.push('.');
                }
                path.push_str(name);
                leaves(value, path, each)?;
                path.truncate(length);
            }
            Ok(())
        }
    }
}
