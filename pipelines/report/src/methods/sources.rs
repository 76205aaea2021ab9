//! The papers from which the methods are taken.

/// Each source: its key, how it is cited, the whole entry.
pub(super) const SOURCES: [(&str, &str, &str); 31] = [
    (
        "balasubramanian",
        "Balasubramanian et al. 2015",
        "Balasubramanian, Melendez-Calderon, Roby-Brami & Burdet 2015, J. NeuroEng. Rehabil. 12:112",
    ),
    ("bang", "Bang et al. 2004", "Bang, Ni & Davis 2004, Controlled Clinical Trials 25:143"),
    ("bell", "Bell & McCaffrey 2002", "Bell & McCaffrey 2002, Survey Methodology 28:169"),
    ("bland", "Bland & Altman 1999", "Bland & Altman 1999, Stat. Methods Med. Res. 8:135"),
    ("greenhouse", "Greenhouse & Geisser 1959", "Greenhouse & Geisser 1959, Psychometrika 24:95"),
    ("hedges", "Hedges 1981", "Hedges 1981, Journal of Educational Statistics 6:107"),
    ("cumming", "Cumming 2012", "Cumming 2012, Understanding the New Statistics, Routledge"),
    (
        "edgington",
        "Edgington & Onghena 2007",
        "Edgington & Onghena 2007, Randomization Tests, 4th ed., Chapman & Hall/CRC",
    ),
    ("fisher", "Fisher 1935", "Fisher 1935, The Design of Experiments, Oliver & Boyd"),
    ("hedeker", "Hedeker & Gibbons 1994", "Hedeker & Gibbons 1994, Biometrics 50:933"),
    ("holm", "Holm 1979", "Holm 1979, Scand. J. Statist. 6:65"),
    ("hudson", "Hudson 1966", "Hudson 1966, J. Am. Stat. Assoc. 61:1097"),
    ("kenward", "Kenward & Roger 1997", "Kenward & Roger 1997, Biometrics 53:983"),
    ("maris", "Maris & Oostenveld 2007", "Maris & Oostenveld 2007, J. Neurosci. Methods 164:177"),
    ("nichols", "Nichols & Holmes 2002", "Nichols & Holmes 2002, Human Brain Mapping 15:1"),
    (
        "sassenhagen",
        "Sassenhagen & Draschkow 2019",
        "Sassenhagen & Draschkow 2019, Psychophysiology 56:e13335",
    ),
    ("mcgraw", "McGraw & Wong 1996", "McGraw & Wong 1996, Psychol. Methods 1:30"),
    ("newey", "Newey & West 1987", "Newey & West 1987, Econometrica 55:703"),
    ("ogata", "Ogata 2010", "Ogata 2010, Modern Control Engineering, 5th ed., Prentice Hall"),
    ("schuirmann", "Schuirmann 1987", "Schuirmann 1987, J. Pharmacokinet. Biopharm. 15:657"),
    ("satterthwaite", "Satterthwaite 1946", "Satterthwaite 1946, Biometrics Bulletin 2:110"),
    ("chung", "Chung & Romano 2013", "Chung & Romano 2013, Ann. Stat. 41:484"),
    ("welch", "Welch 1947", "Welch 1947, Biometrika 34:28"),
    (
        "wichmann",
        "Wichmann & Hill 2001",
        "Wichmann & Hill 2001, Perception & Psychophysics 63:1293",
    ),
    ("garcia", "García-Pérez 1998", "García-Pérez 1998, Vision Research 38:1861"),
    ("watson", "Watson 2017", "Watson 2017, J. Vision 17(3):10"),
    (
        "gescheider",
        "Gescheider 1997",
        "Gescheider 1997, Psychophysics: The Fundamentals, 3rd ed., Lawrence Erlbaum",
    ),
    ("paule", "Paule & Mandel 1982", "Paule & Mandel 1982, J. Res. NBS 87:377"),
    ("hartung", "Hartung & Knapp 2001", "Hartung & Knapp 2001, Stat. Med. 20:3875"),
    ("wilcoxon", "Wilcoxon 1945", "Wilcoxon 1945, Biometrics Bull. 1:80"),
    (
        "winter",
        "Winter 2009",
        "Winter 2009, Biomechanics and Motor Control of Human Movement, 4th ed., Wiley",
    ),
];

/// The sources that a text names, to be listed below it.
#[derive(Debug, Default)]
pub(super) struct Cited(Vec<&'static str>);

impl Cited {
    /// `(Holm 1979)`; the source will be listed.
    pub(super) fn cite(&mut self, key: &str) -> String {
        let Some((_, short, whole)) = SOURCES.iter().find(|(name, ..)| *name == key) else {
            return String::new();
        };
        if !self.0.contains(whole) {
            self.0.push(whole);
        }
        format!("({short})")
    }

    /// The whole entries, by name.
    pub(super) fn listed(mut self) -> Vec<String> {
        self.0.sort_unstable();
        self.0.into_iter().map(|entry| format!("{entry}.")).collect()
    }
}
