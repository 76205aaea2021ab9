//! How either end of the participant's line reads arbitrary bytes, for tests that send them
//! (`fuzz/`).

use super::proof::Secret;
use super::reception::{Reception, Visit};
use super::wire::{Message, answer, place, place_of, read_answer, read_line};

/// Reads bytes as the session does, as the screen does, and as the file that says where a session
/// is found; whether everything that was read of them is read alike when it is written again, or
/// comes byte by byte.
pub fn is_read_as_written(bytes: &[u8]) -> bool {
    let mut input = bytes;
    let mut holds = replies(bytes.chunks(bytes.len().max(1))) == replies(bytes.chunks(1));
    while let Ok(Some(line)) = read_line(&mut input) {
        if let Some((number, value)) = read_answer(&line) {
            holds &= read_answer(&answer(number, value)) == Some((number, value));
        }
        if let Ok(message) = serde_json::from_str::<Message>(&line) {
            let again = serde_json::to_string(&message).ok();
            holds &= again.and_then(|line| serde_json::from_str(&line).ok()) == Some(message);
        }
    }
    let text = String::from_utf8_lossy(bytes);
    if let Some((port, secret)) = place_of(&text) {
        holds &= place_of(&place(port, &secret)) == Some((port, secret));
    }
    holds
}

/// What a session sends back to a screen that sends these bytes; nothing more once it is sent away.
fn replies<'a>(parts: impl Iterator<Item = &'a [u8]>) -> Result<String, String> {
    let mut visit = Visit::new(&Reception::new(Secret::new([7; 32])), [9; 32]);
    let mut back = String::new();
    for part in parts {
        back += &visit.take(part).map_err(|away| away.0)?;
    }
    Ok(back)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_either_end_and_lines_of_neither_hold() {
        for bytes in [
            &b"answer 3 -2\nanswer 99999999999999999999 1\n"[..],
            b"{\"sight\":{\"now\":\"ready\",\"environment\":null,\"practice\":true,\"done\":1,\"total\":9}}\n",
            b"\"taken\"\n4711 word\n",
            format!("4711 {}\n", "07".repeat(32)).as_bytes(),
            format!("zwidth-participant-2 {}\nanswer 1 2\n", "09".repeat(32)).as_bytes(),
            b"\xff\n",
            b"",
        ] {
            assert!(is_read_as_written(bytes), "{:?}", String::from_utf8_lossy(bytes));
        }
    }
}
