//! Bytes to messages and back.

use super::*;
use proptest::prelude::*;

/// What a message is, apart from where it stands.
fn told(message: &Message<'_>) -> String {
    format!("{message:?}")
}

fn read(of: End, bytes: &[u8]) -> (Vec<String>, u64) {
    let mut parser = Parser::new(of);
    let mut messages = Vec::new();
    for byte in bytes {
        messages.extend(parser.push(*byte).as_ref().map(told));
    }
    (messages, parser.damaged())
}

fn wire(messages: &[Message<'_>]) -> Vec<u8> {
    let mut out = Vec::new();
    messages.iter().for_each(|message| message.write(&mut out));
    out
}

#[test]
fn messages_have_the_bytes_of_the_protocols_page() {
    let cases: [(Message<'_>, &[u8]); 11] = [
        (Message::Analog { channel: 3, value: 1023 }, &[0xE3, 0x7F, 0x07]),
        (Message::Digital { port: 2, pins: 0x81 }, &[0x92, 0x01, 0x01]),
        (Message::ReportAnalog { channel: 0, on: true }, &[0xC0, 1]),
        (Message::ReportDigital { port: 1, on: false }, &[0xD1, 0]),
        (Message::PinMode { pin: 9, mode: Mode::Pwm as u8 }, &[0xF4, 9, 3]),
        (Message::DigitalPin { pin: 13, on: true }, &[0xF5, 13, 1]),
        (Message::Version { major: 2, minor: 5 }, &[0xF9, 2, 5]),
        (Message::Reset, &[0xFF]),
        (Message::Sysex { id: id::CAPABILITY_QUERY, data: &[] }, &[0xF0, 0x6B, 0xF7]),
        (
            Message::Sysex { id: id::SAMPLING_INTERVAL, data: &two(200) },
            &[0xF0, 0x7A, 0x48, 0x01, 0xF7],
        ),
        (
            Message::Sysex { id: id::STRING, data: &string("é") },
            &[0xF0, 0x71, 0x43, 0x01, 0x29, 0x01, 0xF7],
        ),
    ];
    for (message, bytes) in cases {
        assert_eq!(wire(&[message]), bytes, "{message:?}");
        assert_eq!(read(End::Board, bytes), (vec![told(&message)], 0));
    }
    assert_eq!(wire(&[Message::VersionQuery]), [0xF9]);
    assert_eq!(read(End::Host, &[0xF9]).0, [told(&Message::VersionQuery)]);
}

#[test]
fn requests_of_the_i2c_bus_have_the_bytes_of_its_page() {
    let read = |again| I2cRequest::Read { address: 0x36, register: Some(0x0C), length: 2, again };
    assert_eq!(read(false).data(), [0x36, 0x08, 0x0C, 0, 2, 0]);
    assert_eq!(read(true).data(), [0x36, 0x10, 0x0C, 0, 2, 0]);
    let write = I2cRequest::Write { address: 0x36, bytes: vec![0x07, 0xFF] };
    assert_eq!(write.data(), [0x36, 0, 7, 0, 0x7F, 1]);
    for request in [read(false), read(true), write, I2cRequest::Stop { address: 0x36 }] {
        assert_eq!(I2cRequest::read(&request.data()), Some(request));
    }
    let reply = I2cReply { address: 0x36, register: 0x0C, bytes: vec![0x0F, 0xFF] };
    assert_eq!(reply.data(), [0x36, 0, 0x0C, 0, 0x0F, 0, 0x7F, 1]);
    assert_eq!(I2cReply::read(&reply.data()), Some(reply));
    assert_eq!(I2cRequest::read(&[0x36, 0x28, 0, 0]), None);
}

#[test]
fn what_is_no_message_is_counted_and_the_next_one_is_right() {
    let analog = Message::Analog { channel: 0, value: 5 };
    for (before, damaged) in [
        (&[][..], 0),
        (&[1, 2, 3], 1),
        (&[0xE1, 2], 1),
        (&[0xF0, 0x79, 2], 1),
        (&[0xF7], 1),
        (&[0xF0, 0xF7], 1),
        (&[0xA0, 1, 2], 1),
        (&[0xE1, 0xE2, 3], 2),
    ] {
        let bytes = [before, &wire(&[analog])].concat();
        assert_eq!(read(End::Board, &bytes), (vec![told(&analog)], damaged), "{before:x?}");
    }
}

#[test]
fn a_message_without_an_end_takes_no_more_memory() {
    let mut parser = Parser::new(End::Board);
    assert!(parser.push(0xF0).is_none());
    for _ in 0..10 * MOST_SYSEX {
        assert!(parser.push(1).is_none());
    }
    assert!(parser.push(0xF7).is_none());
    assert!(parser.bytes.capacity() <= 2 * MOST_SYSEX);
    assert_eq!(read(End::Board, &wire(&[Message::Reset])).0.len(), 1);
}

/// One that is there to be sent, by what it is made of.
fn message<'a>(which: u8, a: u8, b: u16, data: &'a [u8]) -> Message<'a> {
    let (channel, pin, on) = (a % 16, a % 128, b % 2 == 1);
    match which % 9 {
        0 => Message::Analog { channel, value: b % 16_384 },
        1 => Message::Digital { port: channel, pins: b as u8 },
        2 => Message::ReportAnalog { channel, on },
        3 => Message::ReportDigital { port: channel, on },
        4 => Message::PinMode { pin, mode: b as u8 % 128 },
        5 => Message::DigitalPin { pin, on },
        6 => Message::Version { major: pin, minor: b as u8 % 128 },
        7 => Message::Reset,
        _ => Message::Sysex { id: pin, data },
    }
}

proptest! {
    #[test]
    fn what_is_sent_arrives_however_it_is_split_and_whatever_came_before(
        parts in prop::collection::vec(
            (any::<(u8, u8, u16)>(), prop::collection::vec(0..0x80_u8, 0..40)), 1..12),
        noise in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let sent: Vec<Message<'_>> =
            parts.iter().map(|((which, a, b), data)| message(*which, *a, *b, data)).collect();
        let expect: Vec<String> = sent.iter().map(told).collect();
        let clean = wire(&sent);
        prop_assert_eq!(read(End::Board, &clean), (expect.clone(), 0));
        let before = read(End::Board, &noise).0.len();
        let (found, _) = read(End::Board, &[noise, clean].concat());
        prop_assert_eq!(&found[before..], &expect[..]);
    }

    #[test]
    fn any_pins_are_read_as_they_were_written(
        pins in prop::collection::vec(prop::collection::vec((0..0x7F_u8, 0..0x80_u8), 0..6), 0..128),
    ) {
        let pins: Vec<Pin> = pins.into_iter().map(Pin).collect();
        prop_assert_eq!(Pin::read_all(&Pin::write_all(&pins)), pins);
    }

    #[test]
    fn what_any_bytes_carry_is_read_or_refused(data in prop::collection::vec(0..0x80_u8, 0..64)) {
        let _ = (Pin::read_all(&data), unstring(&data));
        if let Some(request) = I2cRequest::read(&data) {
            prop_assert_eq!(I2cRequest::read(&request.data()), Some(request));
        }
        if let Some(reply) = I2cReply::read(&data) {
            prop_assert_eq!(I2cReply::read(&reply.data()), Some(reply));
        }
    }
}
