//! Open Sound Control 1.0, as far as a marker needs it: one message, big-endian, each part padded
//! to a multiple of four bytes. Source: M. Wright, "The Open Sound Control 1.0 Specification", 2002
//! (opensoundcontrol.org/spec-1_0).

/// An argument of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Argument<'a> {
    /// `i`: 32 bits.
    Int(i32),
    /// `f`: 32 bits. Only the specification's own examples have one.
    #[cfg(test)]
    Float(f32),
    /// `d`: 64 bits, which the specification lists among the types that not every receiver takes.
    Double(f64),
    /// `s`: ASCII.
    Text(&'a str),
}

/// A message: address, types, arguments.
pub(super) fn message(address: &str, arguments: &[Argument<'_>]) -> Vec<u8> {
    let (types, values): (String, Vec<Vec<u8>>) = arguments.iter().map(encoded).unzip();
    [text(address), text(&format!(",{types}")), values.concat()].concat()
}

/// The letter of an argument's type, and its bytes.
fn encoded(argument: &Argument<'_>) -> (char, Vec<u8>) {
    match argument {
        Argument::Int(n) => ('i', n.to_be_bytes().to_vec()),
        #[cfg(test)]
        Argument::Float(x) => ('f', x.to_be_bytes().to_vec()),
        Argument::Double(x) => ('d', x.to_be_bytes().to_vec()),
        Argument::Text(words) => ('s', text(words)),
    }
}

/// A text with the zero byte that ends it, and zero bytes up to a multiple of four.
fn text(words: &str) -> Vec<u8> {
    const UNIT: usize = 4;
    let mut bytes = words.as_bytes().to_vec();
    bytes.resize((bytes.len() / UNIT + 1) * UNIT, 0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_specification_are_encoded_byte_by_byte() {
        let oscillator = [
            0x2f, 0x6f, 0x73, 0x63, 0x69, 0x6c, 0x6c, 0x61, 0x74, 0x6f, 0x72, 0x2f, 0x34, 0x2f,
            0x66, 0x72, 0x65, 0x71, 0x75, 0x65, 0x6e, 0x63, 0x79, 0x00, 0x2c, 0x66, 0x00, 0x00,
            0x43, 0xdc, 0x00, 0x00,
        ];
        assert_eq!(message("/oscillator/4/frequency", &[Argument::Float(440.0)]), oscillator);
        let foo = [
            0x2f, 0x66, 0x6f, 0x6f, 0x00, 0x00, 0x00, 0x00, 0x2c, 0x69, 0x69, 0x73, 0x66, 0x66,
            0x00, 0x00, 0x00, 0x00, 0x03, 0xe8, 0xff, 0xff, 0xff, 0xff, 0x68, 0x65, 0x6c, 0x6c,
            0x6f, 0x00, 0x00, 0x00, 0x3f, 0x9d, 0xf3, 0xb6, 0x40, 0xb5, 0xb2, 0x2d,
        ];
        let arguments = [
            Argument::Int(1000),
            Argument::Int(-1),
            Argument::Text("hello"),
            Argument::Float(1.234),
            Argument::Float(5.678),
        ];
        assert_eq!(message("/foo", &arguments), foo);
    }

    #[test]
    fn every_part_is_a_multiple_of_four_bytes_and_a_text_always_ends_in_zero() {
        for n in 0..9 {
            let words = "a".repeat(n);
            let bytes = text(&words);
            assert!(
                bytes.len().is_multiple_of(4) && bytes.len() > n && bytes.len() <= n + 4,
                "{n}"
            );
            assert_eq!(
                message("/m", &[Argument::Text(&words), Argument::Double(0.5)]).len() % 4,
                0
            );
        }
    }
}
