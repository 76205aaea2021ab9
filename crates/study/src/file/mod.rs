//! `study.toml`: its shape, its checks, and the way there and back.

mod check;
mod compare;
mod environment;
mod factors;
mod figures;
mod numbers;
mod own_metrics;
mod people;
mod perception;
mod questions;
mod read;
mod scenes;
mod scores;
mod shape;
mod stages;
mod tasks;
mod units;
mod write;

pub(crate) use write::value_of;

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, demo, text as sample, with};
    use crate::{
        Alignment, Control, ModeLaw, OrderScheme, OwnFigures, Study, StudyError, VelocityFilter,
        template_of_imports,
    };

    fn check(from: &str, to: &str, key: &str, words: &str) {
        let text = sample();
        assert!(text.contains(from), "the template lost '{from}'");
        let errors = Study::from_toml(&text.replace(from, to)).unwrap_err();
        let found = errors.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("{errors:?}"));
        assert!(found.problem.contains(words), "{found}");
        assert!(found.line > 1, "{found}");
    }

    /// One value by another, where the key first stands in the template.
    fn check_value(key: &str, then: &str, now: &str, words: &str) {
        let name = key.rsplit('.').next().unwrap();
        check(&format!("{name} = {then}"), &format!("{name} = {now}"), key, words);
    }

    #[test]
    fn the_template_is_a_valid_study_and_survives_a_round_trip() {
        check_round_trip(&demo());
        assert_eq!(demo().conditions().len(), 6);
    }

    #[test]
    fn the_template_of_imports_is_valid_as_it_stands_and_with_what_it_offers() {
        let text = template_of_imports(&"demo".parse().unwrap());
        let study = Study::from_toml(&text).unwrap();
        assert_eq!(study.device.lever_m, None);
        assert_eq!((study.modes.len(), study.environments.len()), (2, 1));
        // Each line that is a key or a table behind its `# `.
        let offered = |line: &str| {
            let rest = line.strip_prefix("# ").filter(|rest| {
                let is_key = |c: char| c.is_ascii_lowercase() || c == '_';
                rest.starts_with('[')
                    || rest.split(" = ").next().is_some_and(|k| k.chars().all(is_key))
            });
            rest.unwrap_or(line).to_owned()
        };
        let lines: Vec<String> = text.lines().map(offered).collect();
        let whole = lines.join("\n").replace("kind = \"none\"\n", "");
        let whole = whole.replace("schema = 2", "schema = 3");
        let study = Study::from_toml(&whole).unwrap();
        assert_eq!(study.device.lever_m, Some(0.05));
        assert_eq!((study.questions.len(), study.channels.len()), (1, 1));
        assert_eq!(study.compare.primary.names()[0].as_str(), "stiffness_n_per_rad");
        assert_eq!(study.compare.groups.unwrap().levels.len(), 2);
        assert!(study.axes.unwrap().push[2] < 0.0);
    }

    #[test]
    fn degrees_become_radians_and_the_wall_stands_at_26_6_degrees() {
        let study = demo();
        let wall = study.environments[1].scene.wall_rad().unwrap();
        assert!((wall.to_degrees() - 26.6).abs() < 1e-12);
        assert!((study.device.theta_max_rad.unwrap() - 45_f64.to_radians()).abs() < 1e-15);
    }

    #[test]
    fn errors_name_the_key_and_its_line() {
        check("repeats = 6", "repeats = 0", "design.repeats", "at least 1");
        check("repeats = 6", "repeats = 4000000000", "design.repeats", "at most");
        check("pause_s = 5.0", "pause_s = 1e300", "design.pause_s", "at most");
        check("pause_s = 5.0", "pause_s = -1.0", "design.pause_s", "above 0");
        check("rate_hz = 1000.0", "rate_hz = 1e12", "control.rate_hz", "at most");
        check("wall_deg = 26.6", "", "environments[1].wall_deg", "missing");
        check("wall_deg = 26.6", "wall_deg = nan", "environments[1].wall_deg", "finite");
        check("lever_m = 0.045", "lever_m = -1.0", "device.lever_m", "above 0");
        check("id = \"passive\"", "id = \"active\"", "modes[1].id", "twice");
        check("id = \"passive\"", "id = \"Active\"", "modes[1].id", "by more than case");
        check("id = \"passive\"", "id = \"sealed-1\"", "modes[1].id", "looks like the code");
        check("id = \"passive\"", "id = \"../x\"", "id", "not a valid mode id");
        check("theta_max_deg = 45.0", "theta_max_deg = -50.0", "device.theta_max_deg", "above");
        check_value("environments[1].wall_deg", "26.6", "1e6", "from -36000 to 36000");
        check("wall_deg = 26.6", "wall_mm = 26.6", "environments[1].wall_mm", "is not used");
        check("repeats = 6", "repeat = 6", "repeat", "unknown field");
        check("repeats = 6", "repeats = \"six\"", "repeats", "invalid type");
        check("schema = 2", "schema = 4", "schema", "unknown");
        check("rate_hz = 1000.0", "rate_hz = 0.0", "control.rate_hz", "above 0");
        check("let_go_n = 2.0", "let_go_n = -2.0", "control.let_go_n", "0 or a number above");
        check("force_limit_n = 10.0", "force_limit_n = inf", "control.force_limit_n", "above 0");
        check_value("control.velocity_cutoff_hz", "40.0", "0.0", "above 0");
        check(
            "\"second_order\"\n",
            "\"difference\"\n",
            "control.velocity_cutoff_hz",
            "is not used",
        );
        check("order = \"williams\"", "order = \"by hand\"", "order", "unknown variant");
    }

    #[test]
    fn a_mode_may_name_the_law_that_its_actuators_can_follow_and_no_other() {
        check(
            "motor_max_v = 16.0",
            "law = \"hybrid\"\nmotor_max_v = 16.0",
            "modes[0].law",
            "uses the brake",
        );
        check(
            "\nbrake_max_v = 8.0\n",
            "\nlaw = \"active\"\nbrake_max_v = 8.0\n",
            "modes[1].law",
            "uses the motor",
        );
        let named = sample().replace("motor_max_v = 16.0", "law = \"active\"\nmotor_max_v = 16.0");
        let study = Study::from_toml(&named).unwrap();
        assert_eq!(study.modes[0].law(), Some(ModeLaw::Active));
        check_round_trip(&study);
    }

    #[test]
    fn a_question_may_name_its_scale_and_its_default_is_no_change() {
        let named = sample().replace("[[questions]]", "[[questions]]\nscale = \"five_point\"");
        assert_eq!(Study::from_toml(&named).unwrap(), demo());
        check("[[questions]]", "[[questions]]\nscale = \"yes\"", "scale", "unknown variant");
    }

    #[test]
    fn a_file_without_the_keys_of_a_session_has_their_defaults() {
        let text = sample();
        let from = text.find("# Numbers of the control loop").unwrap();
        let to = text.find("# Actuator masses").unwrap();
        let before = (text[..from].to_owned() + &text[to..])
            .replace("order = \"williams\"", "")
            .replace("blinded = false", "");
        assert_eq!(Study::from_toml(&before).unwrap(), demo());
        assert_eq!(demo().control, Control::default());
    }

    #[test]
    fn what_a_session_needs_survives_a_round_trip() {
        let mut study = demo();
        study.design.order = OrderScheme::Constrained;
        study.design.blinded = true;
        for velocity in
            [VelocityFilter::Difference, VelocityFilter::SecondOrder { cutoff_hz: 15.0 }]
        {
            study.control = Control { rate_hz: 120.0, let_go_n: 1.5, force_limit_n: 8.0, velocity };
            check_round_trip(&study);
        }
    }

    /// The study with `[figures]` and what stands under it.
    fn with_figures(figures: &str) -> Result<Study, Vec<StudyError>> {
        with("[figures]", figures)
    }

    #[test]
    fn a_study_chooses_the_alignment_of_all_figures_of_a_kind_or_of_one() {
        let study = with_figures(
            "alignment = \"landmarks\"\nloops.alignment = \"onset\"\nmodes.P01.S01.spring = { alignment = \"onset\" }",
        )
        .unwrap();
        let [onset, landmarks] = Alignment::ALL;
        let of = |id| study.figures.alignment(id);
        assert_eq!(of("modes.P01.S01.spring_wall"), landmarks, "in every panel");
        assert_eq!((of("loops.P01.S01"), of("modes.P01.S01.spring")), (onset, onset));
        check_round_trip(&study);
        let none = demo();
        assert_eq!(none.figures.alignment("modes.P01.S01.spring"), onset);
        assert!(!none.to_toml().unwrap().contains("figures"));
    }

    #[test]
    fn a_study_chooses_which_sessions_have_figures_of_their_own() {
        let own = |text: &str| with_figures(text).unwrap();
        let all = own("sessions = \"all\"\nmodes.alignment = \"onset\"");
        assert_eq!(all.figures.own, OwnFigures::All);
        let named = own("sessions = [\"P01.S01\", \"P30.S02\"]");
        let ids = |p: &str, s: &str| [p.to_owned(), s.to_owned()];
        assert_eq!(named.figures.own, OwnFigures::Of(vec![ids("P01", "S01"), ids("P30", "S02")]));
        [all, named].iter().for_each(check_round_trip);
        for wrong in
            ["sessions = 3", "sessions = [\"P01\"]", "sessions = \"some\"", "sessions = [1]"]
        {
            check_refused(with_figures(wrong), "figures.sessions", "or a list such as");
        }
    }

    #[test]
    fn a_study_chooses_the_font_of_its_figures() {
        let font = |text: &str| with_figures(text).map(|study| study.figures.font);
        assert_eq!(font("").unwrap(), [""; 0]);
        assert_eq!(font("font = \"fonts/My-Font.ttf\"").unwrap(), ["fonts/My-Font.ttf"]);
        let three = with_figures("font = [\"a.otf\", \"b.ttf\", \"c.ttf\"]").unwrap();
        assert_eq!(three.figures.font, ["a.otf", "b.ttf", "c.ttf"]);
        check_round_trip(&three);
        for wrong in [
            "font = \"../My-Font.ttf\"",
            "font = \"/usr/share/fonts/My-Font.ttf\"",
            "font = \"Helvetica\"",
            "font = \"a.woff\"",
            "font = []",
            "font = [\"a.ttf\", 1]",
            "font = [\"a.ttf\", \"b.ttf\", \"c.ttf\", \"d.ttf\"]",
        ] {
            check_refused(with_figures(wrong), "figures.font", "fonts/My-Font.ttf");
        }
    }

    #[test]
    fn a_choice_that_is_not_possible_is_one_error_that_lists_what_is() {
        for (figures, key, words) in [
            ("alignment = \"landmark\"", "figures.alignment", "must be \"onset\" or \"landmarks\""),
            (
                "modes.alignment = 1",
                "figures.modes.alignment",
                "must be \"onset\" or \"landmarks\"",
            ),
            ("mods.alignment = \"onset\"", "figures.mods", "there are modes, loops"),
            ("repeats.alignment = \"onset\"", "figures.repeats", "there are modes, loops"),
            (
                "modes.P01.S01.wall.alignment = \"onset\"",
                "figures.modes.P01.S01.wall",
                "{spring, spring_wall}",
            ),
            (
                "loops.P01.S01.spring.alignment = \"onset\"",
                "figures.loops.P01.S01.spring",
                "as long",
            ),
            ("modes.align = \"onset\"", "figures.modes.align", "has the key alignment"),
        ] {
            check_refused(with_figures(figures), key, words);
        }
    }

    #[test]
    fn no_number_decides_how_much_memory_or_time_is_taken() {
        check("rate_hz = 1000.0", "rate_hz = 1e-300", "control.rate_hz", "from 1e-9 to 1e9");
        check_value("analysis.grid_points", "401", "4294967295", "at most 100000");
        check("repeats = 6", "repeats = 50000", "design.repeats", "300003 trials in a session");
        check_value("design.trial_limit_s", "4.0", "80000.0", "at most 4194304");
        check("lever_m = 0.045", "lever_m = 1e-12", "device.lever_m", "from 1e-9");
        let many = "[[questions]]\nid = \"q\"\ntext = \"t\"\n".repeat(5000);
        let errors = Study::from_toml(&format!("{}\n{many}", sample())).unwrap_err();
        assert!(errors.len() == 100, "{} errors: each costs a look for its line", errors.len());
    }

    #[test]
    fn a_text_that_starts_a_line_or_turns_one_is_refused_and_never_shown_as_it_is() {
        let text = sample();
        let title = text.lines().find(|line| line.starts_with("title = ")).unwrap();
        for bad in ["a\\nb", "\\u001b[2J", "\\u202Eabc", "\\u2066x"] {
            check(title, &format!("title = \"{bad}\""), "study.title", "leave it out");
        }
        check(
            title,
            &format!("title = \"{}\"", "x".repeat(1001)),
            "study.title",
            "longer than 1000",
        );
        let errors = with_figures("\"a\\u001b[2J\\nb\" = 1").unwrap_err();
        let told = errors[0].to_string();
        assert!(!told.contains(['\u{1b}', '\n']) && told.contains(r"\u{1b}[2J\nb"), "{told:?}");
    }

    #[test]
    fn every_problem_is_reported_not_only_the_first() {
        let text = sample()
            .replace("repeats = 6", "repeats = 0")
            .replace("lever_m = 0.045", "lever_m = 0.0");
        assert_eq!(Study::from_toml(&text).unwrap_err().len(), 2);
    }

    #[test]
    fn a_linear_study_speaks_of_millimetres_and_keeps_radians() {
        let text = sample()
            .replace("kind = \"rotational\"", "kind = \"linear\"")
            .replace("lever_m = 0.045", "lever_m = 0.5")
            .replace("stiffness_n_per_rad = 4.0", "stiffness_n_per_mm = 0.2")
            .replace("rest_deg = -45.0", "rest_mm = 0.0")
            .replace("wall_deg = 26.6", "wall_mm = 10.0")
            .replace("onset_deg_s = 10.0", "")
            .replace("offset_deg_s = 5.0", "")
            .replace("slope_from_deg = 0.0", "slope_from_mm = 0.5");
        let study = Study::from_toml(&text).unwrap();
        let scene = study.environments[1].scene;
        assert!((scene.wall_rad().unwrap() - 0.02).abs() < 1e-15);
        assert!((scene.spring().unwrap().stiffness_n_per_rad - 100.0).abs() < 1e-12);
        check_round_trip(&study);
    }
}
