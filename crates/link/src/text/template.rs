//! What a line contains: words, and fields with numbers.

use super::MOST_LINE;

/// What a field of a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// `{t_ms}`: the board's clock, ms, as `millis()` has it: round after 2³² of them.
    Millis,
    /// `{t_us}`: the board's clock, µs, as `micros()` has it: round after 2³² of them.
    Micros,
    /// `{counts}`: the angle sensor's count.
    Counts,
    /// `{hx711}`: the load cell's count, 24 bits (HX711 data sheet: 800000h … 7FFFFFh).
    Hx711,
    /// `{any}`: something else, of up to [`MOST_ANY`] bytes.
    Any,
    /// `{motor_pwm}`: of a command, the motor's voltage as a share of the full scale, with its
    /// sign.
    MotorPwm,
    /// `{brake_pwm}`: the same of the brake.
    BrakePwm,
    /// `{code}`: of a marker, what happened.
    Code,
    /// `{number}`: of a marker, which.
    Number,
}

/// Longest text that `{any}` stands for, bytes: it bounds a line's length, and so its rate.
pub const MOST_ANY: usize = 16;

/// Every field: its word, its lowest and highest number.
const FIELDS: [(&str, Field, i64, i64); 9] = [
    ("t_ms", Field::Millis, 0, u32::MAX as i64),
    ("t_us", Field::Micros, 0, u32::MAX as i64),
    ("counts", Field::Counts, 0, u16::MAX as i64),
    ("hx711", Field::Hx711, -0x80_0000, 0x7F_FFFF),
    ("any", Field::Any, 0, 0),
    ("motor_pwm", Field::MotorPwm, i16::MIN as i64, i16::MAX as i64),
    ("brake_pwm", Field::BrakePwm, 0, i16::MAX as i64),
    ("code", Field::Code, 0, u8::MAX as i64),
    ("number", Field::Number, 0, u16::MAX as i64),
];

impl Field {
    fn facts(self) -> &'static (&'static str, Self, i64, i64) {
        &FIELDS[self as usize] // the table has the order of the variants
    }

    fn word(self) -> &'static str {
        self.facts().0
    }

    /// Longest text of it, bytes.
    fn longest(self) -> usize {
        let (_, _, lowest, highest) = *self.facts();
        if self == Self::Any {
            return MOST_ANY;
        }
        lowest.to_string().len().max(highest.to_string().len())
    }

    /// A number of it; none that is no decimal number, or beyond its ends. Blanks around it are
    /// those of a number that was printed to a width.
    fn read(self, text: &[u8]) -> Option<i64> {
        let (_, _, lowest, highest) = *self.facts();
        let text = std::str::from_utf8(text.trim_ascii()).ok()?;
        let digits = text.strip_prefix('-').unwrap_or(text);
        let decimal = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        // Not by `parse` alone, which takes a plus sign too.
        let number: i64 = text.parse().ok().filter(|_| decimal)?;
        (lowest..=highest).contains(&number).then_some(number)
    }
}

/// The values of a line's fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Values([Option<i64>; FIELDS.len()]);

impl Values {
    /// With one more.
    #[must_use]
    pub fn with(mut self, field: Field, number: impl Into<i64>) -> Self {
        self.0[field as usize] = Some(number.into());
        self
    }

    /// What stood in a field.
    pub fn get(&self, field: Field) -> Option<i64> {
        self.0[field as usize]
    }
}

/// Why a text is not a template.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TemplateError {
    /// A `{` without its `}`.
    #[error("a {{ is not closed; add its }}")]
    Open,
    /// A field that is not known here.
    #[error("{{{word}}} is not a field of this line; its fields are {known}")]
    Unknown {
        /// What stood there.
        word: String,
        /// What may stand there.
        known: String,
    },
    /// A field that stands there twice.
    #[error("{{{word}}} is there twice; take one out")]
    Twice {
        /// Which.
        word: &'static str,
    },
    /// Two fields with nothing between them that could be told from a number.
    #[error("put something that is not a digit between {{{word}}} and the field before it")]
    Adjacent {
        /// The second.
        word: &'static str,
    },
    /// A field that must be there.
    #[error("{{{word}}} is missing; add it")]
    Missing {
        /// Which.
        word: &'static str,
    },
    /// A line's end within it, or a line that is too long.
    #[error("it must be one line, of at most {MOST_LINE} bytes with its numbers")]
    Long,
}

/// The form of a line: some text, then fields with text after each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    before: Vec<u8>,
    fields: Vec<(Field, Vec<u8>)>,
}

impl Template {
    /// From a text such as `"{t_ms},{counts},{hx711}"`; a line end after it is not part of it.
    /// `may`: the fields that make sense, `must`: those among them that are needed.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str, may: &[Field], must: &[Field]) -> Result<Self, TemplateError> {
        let text = text.strip_suffix('\n').unwrap_or(text);
        let text = text.strip_suffix('\r').unwrap_or(text);
        let mut parts = text.split('{');
        let before = parts.next().unwrap_or_default().as_bytes().to_vec();
        let mut fields: Vec<(Field, Vec<u8>)> = Vec::new();
        for part in parts {
            let (word, behind) = part.split_once('}').ok_or(TemplateError::Open)?;
            let field = find_field(word, may)?;
            let word = field.word();
            if field != Field::Any && fields.iter().any(|(before, _)| *before == field) {
                return Err(TemplateError::Twice { word });
            }
            if fields.last().is_some_and(|(_, between)| !can_part(between)) {
                return Err(TemplateError::Adjacent { word });
            }
            fields.push((field, behind.as_bytes().to_vec()));
        }
        let template = Self { before, fields };
        if let Some(field) = must.iter().find(|field| !template.has(**field)) {
            return Err(TemplateError::Missing { word: field.word() });
        }
        // Two bytes more for the line's end, which `Lines` does not keep.
        if text.contains(['\n', '\r']) || template.longest() > MOST_LINE + 2 {
            return Err(TemplateError::Long);
        }
        Ok(template)
    }

    /// Whether it contains a field.
    pub fn has(&self, field: Field) -> bool {
        self.fields.iter().any(|(contained, _)| *contained == field)
    }

    /// Bytes of its longest line on the wire, with `\r\n` as `Serial.println` ends it.
    pub fn longest(&self) -> usize {
        let fields = self.fields.iter().map(|(field, behind)| field.longest() + behind.len());
        self.before.len() + fields.sum::<usize>() + 2
    }

    /// The numbers of a line; none of a line of another form.
    pub fn read(&self, line: &[u8]) -> Option<Values> {
        let mut rest = line.strip_prefix(self.before.as_slice())?;
        let mut values = Values::default();
        for (i, (field, behind)) in self.fields.iter().enumerate() {
            // The last field ends with the line, the others where the text behind them comes first.
            let last = i + 1 == self.fields.len();
            let end =
                if last { rest.len().checked_sub(behind.len())? } else { find(rest, behind)? };
            let text = &rest[..end];
            rest = rest[end..].strip_prefix(behind.as_slice())?;
            if *field == Field::Any {
                (text.len() <= MOST_ANY).then_some(())?;
            } else {
                values = values.with(*field, field.read(text)?);
            }
        }
        rest.is_empty().then_some(values)
    }

    /// Writes a line with these numbers; a field without one is a 0.
    pub fn write(&self, values: &Values, out: &mut Vec<u8>) {
        out.extend(&self.before);
        for (field, behind) in &self.fields {
            let (_, _, lowest, highest) = *field.facts();
            let number = values.get(*field).unwrap_or(0).clamp(lowest, highest);
            out.extend(number.to_string().bytes());
            out.extend(behind);
        }
        out.push(b'\n');
    }
}

fn find_field(word: &str, may: &[Field]) -> Result<Field, TemplateError> {
    may.iter().copied().find(|field| field.word() == word).ok_or_else(|| {
        let words: Vec<String> = may.iter().map(|f| format!("{{{}}}", f.word())).collect();
        TemplateError::Unknown { word: word.to_owned(), known: words.join(", ") }
    })
}

/// Whether a text can part two numbers.
fn can_part(between: &[u8]) -> bool {
    // A minus sign could begin the number behind it.
    between.first().is_some_and(|first| !first.is_ascii_digit() && *first != b'-')
}

/// Where a text begins in a longer one. What parts two fields is not empty.
fn find(text: &[u8], part: &[u8]) -> Option<usize> {
    text.windows(part.len().max(1)).position(|window| window == part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SEEN: [Field; 5] =
        [Field::Millis, Field::Micros, Field::Counts, Field::Hx711, Field::Any];

    fn template(text: &str) -> Result<Template, TemplateError> {
        Template::parse(text, &SEEN, &[Field::Counts])
    }

    #[test]
    fn every_field_is_found_by_its_place_in_the_list() {
        assert!(FIELDS.iter().enumerate().all(|(i, (_, field, _, _))| *field as usize == i));
    }

    #[test]
    fn numbers_are_read_where_the_template_says() {
        let line = template("t={t_ms}, {counts}/{any}; {hx711} N\r\n").unwrap();
        let expect = Values::default()
            .with(Field::Millis, 4_294_967_295_i64)
            .with(Field::Counts, 4095)
            .with(Field::Hx711, -8_388_608);
        assert_eq!(line.read(b"t=4294967295, 4095/x; -8388608 N"), Some(expect));
        assert_eq!(line.read(b"t=  12, 7/; 3 N").and_then(|v| v.get(Field::Counts)), Some(7));
    }

    #[test]
    fn a_line_of_another_form_is_none() {
        let line = template("{counts},{hx711}").unwrap();
        for bad in [
            &b""[..],
            b"12",
            b"12,",
            b",3",
            b"12,3,4",
            b"-1,3",
            b"65536,3",
            b"1,8388608",
            b"1.5,3",
            b"+1,3",
            b"0x1,3",
            b"1 2,3",
            b"\xff,3",
            b"99999999999999999999,3",
        ] {
            assert_eq!(line.read(bad), None, "{}", String::from_utf8_lossy(bad));
        }
        assert_eq!(
            template("{any},{counts}").unwrap().read(&[&[b'x'; 17][..], b",1"].concat()),
            None
        );
    }

    #[test]
    fn a_text_that_is_no_template_is_refused_with_its_reason() {
        for (text, says) in [
            ("{counts", "add its }"),
            ("{count}", "{t_ms}, {t_us}, {counts}, {hx711}, {any}"),
            ("{motor_pwm} {counts}", "{motor_pwm} is not a field"),
            ("{counts},{counts}", "twice"),
            ("{t_ms}{counts}", "not a digit between {counts}"),
            ("{t_ms}0,{counts}", "not a digit between {counts}"),
            ("{t_ms}-{counts}", "not a digit between {counts}"),
            ("{t_ms}", "{counts} is missing"),
            ("{counts}\n{hx711}", "one line"),
            (&format!("{}{{counts}}", "x".repeat(124)), "at most 128"),
        ] {
            let error = template(text).unwrap_err().to_string();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    #[test]
    fn the_longest_line_is_known() {
        let line = template("{t_ms},{counts},{hx711}").unwrap();
        assert_eq!(line.longest(), "4294967295,65535,-8388608\r\n".len());
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            t in 0..=u32::MAX, counts in any::<u16>(), force in -0x80_0000..=0x7F_FFFF_i32,
        ) {
            let line = template("{t_us} c{counts} {hx711}!").unwrap();
            let values =
                Values::default().with(Field::Micros, t).with(Field::Counts, counts).with(Field::Hx711, force);
            let mut out = Vec::new();
            line.write(&values, &mut out);
            prop_assert_eq!(out.pop(), Some(b'\n'));
            prop_assert!(out.len() + 2 <= line.longest());
            prop_assert_eq!(line.read(&out), Some(values));
        }

        #[test]
        fn any_bytes_are_read_or_refused(
            text in "(\\{(t_ms|counts|hx711|any|x)\\}|[a-z,; {}]){0,6}",
            line in prop::collection::vec(any::<u8>(), 0..40),
        ) {
            if let Ok(template) = Template::parse(&text, &SEEN, &[]) {
                let _ = template.read(&line);
            }
        }
    }
}
