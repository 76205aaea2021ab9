//! What a blinded session must reveal to nobody, and who may read its files.

use super::*;

/// Every file below a folder but those of one other.
fn files_outside(folder: &Path, vault: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            _ if path == vault => {}
            true => found.extend(files_outside(&path, vault)),
            false => found.push(path),
        }
    }
    found
}

/// A number as it may stand in a file.
fn spellings(number: u64) -> Vec<Vec<u8>> {
    let texts = [
        number.to_string(),
        format!("{number:x}"),
        format!("{number:X}"),
        (number as i64).to_string(),
    ];
    let float = (number as f64).to_string();
    let bytes = [number.to_le_bytes(), number.to_be_bytes()].map(|b| b.to_vec());
    texts.into_iter().chain([float]).map(String::into_bytes).chain(bytes).collect()
}

#[test]
fn no_seed_of_a_blinded_study_stands_in_any_file_outside_the_vault() {
    for given in [None, Some(0xd1ce_5eed_0bad_cafe_u64)] {
        let mut desk = Desk::new(true);
        desk.plan.seed = given;
        let full = full(&Arc::new(Mutex::new(150)));
        desk.run(&mut Mock::default(), &full, &mut diligent()).unwrap_err(); // leaves a journal
        let keys = desk.plan.keys.clone();
        let search = |when: &str| {
            let seed_file = keys.join("small/seed");
            let drawn =
                std::fs::read_to_string(&seed_file).ok().map(|text| text.trim().parse().unwrap());
            assert_eq!(drawn.is_some(), given.is_none());
            let seed: u64 = given.or(drawn).unwrap();
            let files = files_outside(desk.root(), &keys);
            assert!(files.len() > 5, "{files:?}");
            for path in files {
                let bytes = std::fs::read(&path).unwrap();
                for found in spellings(seed).into_iter().chain([desk.plan.secret.to_vec()]) {
                    let stands = bytes.windows(found.len()).any(|window| window == found);
                    assert!(!stands, "{when}: the seed stands in {}", path.display());
                }
            }
        };
        search("cut short");
        recover(&RealFiles, &desk.plan.layout, UTC);
        desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
        search("whole");
    }
}

#[test]
fn a_blinded_session_says_what_gives_a_mode_away_and_names_none() {
    let desk = Desk::new(true);
    let mut said = Vec::new();
    let mut front = somebody(|view: &View| {
        said = view.messages.iter().cloned().collect();
        (view.done == 1).then_some(Input::Quit)
    });
    desk.run(&mut Mock::default(), &Unsynced, &mut front).unwrap();
    drop(front);
    let told = said.iter().find(|m| m.starts_with("blinded: ")).unwrap();
    for word in ["voltages", "flags", "forces", "angle", "size", "raw/"] {
        assert!(told.contains(word), "{told}");
    }
}
