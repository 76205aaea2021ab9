//! The commands that messages suggest, as a POSIX shell reads them.

use crate::Layout;

impl Layout {
    /// `zwidth` with these words, for the data here.
    pub fn command(&self, words: &[&str]) -> String {
        let root = self.root().to_string_lossy();
        let root = (!root.is_empty()).then(|| shell_option("--root", "--root", &root));
        let words = words.iter().map(|word| (*word).to_owned());
        let all = ["zwidth".to_owned()].into_iter().chain(root.into_iter().flatten()).chain(words);
        shell_line(all)
    }
}

/// An option with its value; as one word where the value looks like an option itself.
pub fn shell_option(short: &str, long: &str, value: &str) -> Vec<String> {
    if value.starts_with('-') {
        vec![format!("{long}={value}")]
    } else {
        vec![short.to_owned(), value.to_owned()]
    }
}

/// Words as a shell takes each for itself.
pub fn shell_line(words: impl IntoIterator<Item = String>) -> String {
    words.into_iter().map(quoted).collect::<Vec<_>>().join(" ")
}

fn quoted(word: String) -> String {
    if !word.is_empty()
        && word.chars().all(|c| c.is_ascii_alphanumeric() || "_-./:,=@%+".contains(c))
    {
        return word;
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_command_names_the_folder_of_the_data_where_that_is_another_one() {
        let of = |root: &str| {
            Layout::new(Path::new(root), "s".parse().unwrap())
                .command(&["run", "s", "--shard", "1/2"])
        };
        assert_eq!(of(""), "zwidth run s --shard 1/2");
        assert_eq!(of("/data"), "zwidth --root /data run s --shard 1/2");
        assert_eq!(of("my data"), "zwidth --root 'my data' run s --shard 1/2");
        assert_eq!(of("-x"), "zwidth --root=-x run s --shard 1/2");
        assert_eq!(of("it's"), r"zwidth --root 'it'\''s' run s --shard 1/2");
    }
}
