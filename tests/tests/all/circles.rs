//! What files need, proved from the sources. No circle of files inside a crate: what two files need
//! of each other belongs into one of them, or into a third. The lower floors and the stages need no
//! file, clock or environment.
//!
//! A file needs another if an item of its product code (nothing below `#[cfg(test)]`) names one
//! that the other defines: by `use`, or by a path in code or in a macro's arguments. A name is
//! followed through every `use` and `pub use` to the file that defines it, so that it does not
//! matter by which way an item is reached; a `pub use` alone is another name, not a need, so that
//! a folder's `mod.rs` may give out what its files define. Names of traits' methods and macros of
//! our own are not seen.

use crate::folders::workspace;
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Circles that stand: the reason, the crate, the modules (`crate` is `lib.rs` or `main.rs`).
const KNOWN: [(&str, &str, &[&str]); 6] = [
    (
        "a job says its provenance, which is read back from records, which are made of jobs",
        "crates/runner",
        &["job", "provenance", "record"],
    ),
    (
        "a file is opened without following a link, and how it is read is one of the ways to files",
        "crates/store",
        &["disk::atomic", "disk::regular"],
    ),
    (
        "a trial's form follows from its study, which lists the form's channels",
        "crates/study",
        &["form", "model"],
    ),
    (
        "a layout is of shown cells, shown within the layout's widths",
        "crates/tables",
        &["layout", "shown", "width"],
    ),
    (
        "an estimate carries its profile and verdict, which are drawn from its spread",
        "pipelines/identify",
        &["estimate", "profile", "verdict"],
    ),
    (
        "errors list the solvers and the limit, whose use gives errors",
        "pipelines/simulate",
        &["error", "run", "solvers"],
    ),
];

#[test]
fn no_files_of_a_crate_need_each_other_in_a_circle_but_the_known_ones() {
    let mut found = BTreeSet::new();
    let mut read = 0;
    for root in roots() {
        let modules = modules(&root);
        read += modules.len();
        let folder = root.parent().unwrap().parent().unwrap();
        let name = folder.strip_prefix(workspace()).unwrap().to_str().unwrap();
        found.extend(circles(&needs(&modules)).into_iter().map(|c| (name.to_owned(), c)));
    }
    let known: BTreeSet<_> = KNOWN
        .iter()
        .map(|(_, place, files)| {
            ((*place).to_owned(), files.iter().map(|f| (*f).to_owned()).collect())
        })
        .collect();
    let fresh: Vec<&(String, BTreeSet<String>)> = found.difference(&known).collect();
    assert!(fresh.is_empty(), "new circles, move an item to break them: {fresh:#?}");
    let broken: Vec<_> = known.difference(&found).collect();
    assert!(broken.is_empty(), "circles that are no more, take them off the list: {broken:#?}");
    assert!(read > 300, "only {read} files: were they found?");
}

/// Places that compute and nothing else: same input, same output, on any machine, at any time.
const PURE: [&str; 4] = ["crates/study", "crates/numerics", "crates/dynamics", "crates/stats"];
/// Ways to the world outside, in `std` or `core`.
const OUTSIDE: [&str; 6] = ["fs", "env", "net", "process", "SystemTime", "Instant"];

#[test]
fn the_lower_floors_and_the_stages_touch_no_file_no_clock_and_no_environment() {
    let is_pure = |root: &PathBuf| {
        let place = root.strip_prefix(workspace()).unwrap();
        place.starts_with("pipelines") || PURE.iter().any(|pure| place.starts_with(pure))
    };
    let mut read = 0;
    for root in roots().into_iter().filter(is_pure) {
        let modules = modules(&root);
        read += modules.len();
        for (name, module) in &modules {
            let outside = module.paths.iter().filter(|path| leads_outside(path));
            let none: Vec<&Name> = Vec::new();
            assert_eq!(outside.collect::<Vec<_>>(), none, "{} {name:?}", root.display());
        }
    }
    assert!(read > 150, "only {read} files: were they found?");
}

fn leads_outside(path: &[String]) -> bool {
    path.first().is_some_and(|first| ["std", "core"].contains(&first.as_str()))
        && path.iter().any(|word| OUTSIDE.contains(&word.as_str()))
}

#[test]
fn a_way_outside_is_found_however_it_is_named() {
    for text in [
        "use std::{fmt, fs};",
        "use std::time::{Duration, Instant as Now};",
        "fn f() { drop(std::env::var(\"HOME\")) }",
        "fn f() { println!(\"{}\", std::process::id()) }",
    ] {
        assert!(Module::read(text).paths.iter().any(|path| leads_outside(path)), "{text}");
    }
    for text in ["// std::fs\nuse std::fmt;", "#[cfg(test)] mod tests { use std::fs; }"] {
        assert!(!Module::read(text).paths.iter().any(|path| leads_outside(path)), "{text}");
    }
}

/// The folders of `crates/store`, the lowest first.
const STORE: [&str; 4] = ["disk", "form", "judge", "keep"];

#[test]
fn a_layer_of_the_store_needs_those_below_it_and_none_above() {
    let modules = modules(&workspace().join("crates/store/src/lib.rs"));
    let layer =
        |name: &Name| STORE.iter().position(|layer| name.first().is_some_and(|n| n == layer));
    let mut layers = BTreeSet::new();
    for (name, needed) in needs(&modules) {
        let above =
            needed.into_iter().filter(|other| layer(name).is_some() && layer(other) > layer(name));
        assert_eq!(above.collect::<Vec<_>>(), Vec::<&Name>::new(), "{name:?}");
        layers.extend(layer(name));
    }
    assert_eq!(layers.len(), STORE.len());
}

#[test]
fn a_circle_is_found_through_names_that_are_given_on() {
    let module = |name: &str, text: &str| (vec![name.to_owned()], Module::read(text));
    let modules = BTreeMap::from([
        (vec![], Module::read("mod a; mod b; mod c; pub use b::B; pub use a::A;")),
        module("a", "pub struct A(crate::B);"),
        module(
            "b",
            "use crate::c::{self, f as g}; pub struct B; fn h() { println!(\"{}\", c::f()) }",
        ),
        module("c", "pub fn f() {} #[cfg(test)] mod tests { use crate::B; }"),
    ]);
    let needs_of = |modules: &BTreeMap<_, _>| circles(&needs(modules));
    assert_eq!(needs_of(&modules), BTreeSet::new());
    let closed = |text: &str| {
        let mut modules = modules.clone();
        modules.insert(vec!["c".to_owned()], Module::read(text));
        needs_of(&modules)
    };
    let all = ["a", "b", "c"].map(str::to_owned).into();
    assert_eq!(closed("use super::A; pub fn f() {}"), BTreeSet::from([all]));
    let two = BTreeSet::from(["b", "c"].map(str::to_owned));
    assert_eq!(closed("pub fn f() { drop(vec![super::B]) }"), BTreeSet::from([two]));
}

/// `lib.rs` and `main.rs` of every crate below `crates`, `pipelines`, and of `xtask`.
fn roots() -> Vec<PathBuf> {
    let inside = |place: &str| {
        let entries = fs::read_dir(workspace().join(place)).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect::<Vec<_>>()
    };
    let crates = inside("crates").into_iter().chain(inside("pipelines"));
    let places = crates.chain([workspace().join("xtask")]);
    let roots =
        places.flat_map(|place| ["lib.rs", "main.rs"].map(|name| place.join("src").join(name)));
    roots.filter(|root| root.is_file()).collect()
}

/// A module's path in its crate; empty for the crate itself.
type Name = Vec<String>;

/// What a file of product code defines and names.
#[derive(Debug, Clone, Default)]
struct Module {
    /// Its modules in files of their own.
    files: Vec<String>,
    /// What it defines.
    items: BTreeSet<String>,
    /// What it brings in or gives on: name → path.
    names: BTreeMap<String, Name>,
    /// Every path it needs: in code, and of each `use` that is not `pub`.
    paths: BTreeSet<Name>,
}

impl Module {
    fn read(text: &str) -> Self {
        let mut module = Self::default();
        module.take(text.parse().unwrap(), true);
        module
    }

    /// Takes tokens in: of the file itself (`is_outer`), or of a group in it.
    fn take(&mut self, tokens: TokenStream, is_outer: bool) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut i = 0;
        while i < tokens.len() {
            i += match &tokens[i] {
                TokenTree::Punct(sign) if sign.as_char() == '#' => attribute(&tokens[i..]),
                TokenTree::Ident(word) if word == "use" => self.take_use(&tokens, i),
                TokenTree::Ident(_) => self.take_words(&tokens[i..], is_outer),
                TokenTree::Group(group) => {
                    self.take(group.stream(), false);
                    1
                }
                _ => 1,
            };
        }
    }

    /// Takes a `use` in; how many tokens it has.
    fn take_use(&mut self, tokens: &[TokenTree], at: usize) -> usize {
        let is_given_on = match tokens[..at] {
            [.., ref word] if is(word, "pub") => true,
            [.., ref word, TokenTree::Group(_)] => is(word, "pub"),
            _ => false,
        };
        let length = tokens[at..].iter().take_while(|token| !is(token, ";")).count();
        self.take_tree(&tokens[at + 1..at + length], &[], is_given_on);
        length
    }

    fn take_tree(&mut self, tree: &[TokenTree], before: &[String], is_given_on: bool) {
        let (path, rest) = path(tree);
        let mut whole = [before, &path].concat();
        let group = rest.iter().find_map(|token| match token {
            TokenTree::Group(group) => Some(group.stream().into_iter().collect::<Vec<_>>()),
            _ => None,
        });
        if let Some(group) = group {
            let trees = group.split(|token| is(token, ",")).filter(|tree| !tree.is_empty());
            return trees.for_each(|tree| self.take_tree(tree, &whole, is_given_on));
        }
        if whole.len() > 1 && whole.last().is_some_and(|name| name == "self") {
            whole.pop();
        }
        let renamed = rest.last().filter(|_| rest.len() == 2).map(ToString::to_string);
        let name = renamed.or_else(|| whole.last().cloned()).unwrap_or_default();
        if !is_given_on {
            self.paths.insert(whole.clone());
        }
        self.names.insert(name, whole);
    }

    /// Takes in a path, or a word that begins an item, and the item's name; how many tokens these
    /// are.
    fn take_words(&mut self, tokens: &[TokenTree], is_outer: bool) -> usize {
        const ITEMS: [&str; 7] = ["fn", "struct", "enum", "trait", "type", "const", "static"];
        if let ([word, TokenTree::Ident(name), after, ..], true) = (tokens, is_outer) {
            if is(word, "mod") && is(after, ";") {
                self.files.push(name.to_string());
                return 2;
            }
            if ITEMS.iter().any(|item| is(word, item)) && name != "fn" {
                self.items.insert(name.to_string());
                return 2;
            }
        }
        let (path, rest) = path(tokens);
        self.paths.insert(path);
        tokens.len() - rest.len()
    }
}

fn is(token: &TokenTree, text: &str) -> bool {
    !matches!(token, TokenTree::Group(_)) && token.to_string() == text
}

/// The path at the beginning of tokens, and the tokens after it.
fn path(tokens: &[TokenTree]) -> (Name, &[TokenTree]) {
    let mut path = Name::new();
    let mut rest = tokens;
    while let [TokenTree::Ident(word), after @ ..] = rest {
        path.push(word.to_string());
        rest = after;
        match after {
            [first, second, after @ ..] if is(first, ":") && is(second, ":") => rest = after,
            _ => break,
        }
    }
    (path, rest)
}

/// How many tokens an attribute has, with the item below it if that is for tests alone.
fn attribute(tokens: &[TokenTree]) -> usize {
    const ATTRIBUTE: usize = 2;
    let is_for_tests = |token: &TokenTree| token.to_string().replace(' ', "") == "[cfg(test)]";
    if !tokens.get(1).is_some_and(is_for_tests) {
        return ATTRIBUTE;
    }
    let mut length = ATTRIBUTE;
    while tokens.get(length).is_some_and(|token| is(token, "#")) {
        length += ATTRIBUTE;
    }
    let ends = |token: &TokenTree| {
        is(token, ";")
            || matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace)
    };
    let item = tokens[length.min(tokens.len())..].iter().take_while(|token| !ends(token)).count();
    length + item + 1
}

/// Every module of a crate that has a file of its own.
fn modules(root: &Path) -> BTreeMap<Name, Module> {
    let mut modules = BTreeMap::new();
    let mut waiting = vec![(Name::new(), root.to_owned())];
    while let Some((name, path)) = waiting.pop() {
        let module = Module::read(&fs::read_to_string(&path).unwrap());
        let folder = match path.file_stem().unwrap().to_str().unwrap() {
            "lib" | "main" | "mod" => path.parent().unwrap().to_owned(),
            stem => path.with_file_name(stem),
        };
        for child in &module.files {
            let flat = folder.join(format!("{child}.rs"));
            let deep = folder.join(child).join("mod.rs");
            let path = if flat.is_file() { flat } else { deep };
            waiting.push(([&name[..], std::slice::from_ref(child)].concat(), path));
        }
        modules.insert(name, module);
    }
    modules
}

/// Which file needs which others.
fn needs(modules: &BTreeMap<Name, Module>) -> BTreeMap<&Name, BTreeSet<&Name>> {
    let of = |name: &Name, module: &Module| -> BTreeSet<_> {
        let others = module.paths.iter().filter_map(|path| definer(modules, name, path, 0));
        others.filter(|other| *other != name).collect()
    };
    modules.iter().map(|(name, module)| (name, of(name, module))).collect()
}

/// The module that defines what `path` means in the module `from`; none if it is another crate's,
/// or in scope without a path.
fn definer<'m>(
    modules: &'m BTreeMap<Name, Module>,
    from: &[String],
    path: &[String],
    depth: u8,
) -> Option<&'m Name> {
    /// No name is given on so many times.
    const MOST: u8 = 9;
    let (first, mut rest) = path.split_first().filter(|_| depth < MOST)?;
    if rest.is_empty() {
        // A name alone: an item that a `use` brought, or a variable, perhaps of a module's name.
        let brought = modules[from].names.get(first).filter(|brought| brought.len() > 1)?;
        return definer(modules, from, brought, depth + 1).filter(|at| at.last() != Some(first));
    }
    let mut at = match first.as_str() {
        "crate" => Name::new(),
        "self" => from.to_vec(),
        "super" => from.split_last()?.1.to_vec(),
        _ if modules[from].files.contains(first) => [from, std::slice::from_ref(first)].concat(),
        _ => {
            let brought = modules[from].names.get(first).filter(|brought| brought[..] != *path)?;
            return definer(modules, from, &[brought, rest].concat(), depth + 1);
        }
    };
    while let Some((next, after)) = rest.split_first() {
        if next == "super" {
            at.pop();
        } else if modules.get(&at)?.files.contains(next) {
            at.push(next.clone());
        } else if modules[&at].items.contains(next) {
            break;
        } else if let Some(given) = modules[&at].names.get(next) {
            return definer(modules, &at, &[given, after].concat(), depth + 1);
        } else {
            break;
        }
        rest = after;
    }
    modules.get_key_value(&at).map(|(name, _)| name)
}

/// Files that need each other, directly or through others.
fn circles(needs: &BTreeMap<&Name, BTreeSet<&Name>>) -> BTreeSet<BTreeSet<String>> {
    let reached = |from: &Name| {
        let mut reached: BTreeSet<&Name> = BTreeSet::new();
        let mut waiting: Vec<&Name> = needs[from].iter().copied().collect();
        while let Some(next) = waiting.pop() {
            if reached.insert(next) {
                waiting.extend(needs[next].iter().copied());
            }
        }
        reached
    };
    let reached: BTreeMap<&Name, _> = needs.keys().map(|name| (*name, reached(name))).collect();
    let shown = |name: &Name| if name.is_empty() { "crate".to_owned() } else { name.join("::") };
    let circle = |name: &Name| -> BTreeSet<String> {
        reached[name]
            .iter()
            .filter(|other| reached[**other].contains(name))
            .map(|n| shown(n))
            .collect()
    };
    reached.keys().map(|name| circle(name)).filter(|circle| circle.len() > 1).collect()
}
