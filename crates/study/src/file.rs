//! `study.toml`: its shape, its checks, and the way there and back.

mod read;
mod shape;
mod write;

/// Grams in a kilogram, millimetres in a metre.
const MILLI: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use crate::{Study, StudyId, template};

    fn sample() -> String {
        template(&StudyId::new("demo").unwrap())
    }

    fn check(from: &str, to: &str, key: &str, words: &str) {
        let text = sample();
        assert!(text.contains(from), "the template lost '{from}'");
        let errors = Study::from_toml(&text.replace(from, to)).unwrap_err();
        let found = errors.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("{errors:?}"));
        assert!(found.problem.contains(words), "{found}");
        assert!(found.line > 1, "{found}");
    }

    #[test]
    fn the_template_is_a_valid_study_and_survives_a_round_trip() {
        let study = Study::from_toml(&sample()).unwrap();
        let again = Study::from_toml(&study.to_toml().unwrap()).unwrap();
        assert_eq!(study, again);
        assert_eq!(study.conditions().len(), 6);
    }

    #[test]
    fn degrees_become_radians_and_the_wall_stands_at_26_6_degrees() {
        let study = Study::from_toml(&sample()).unwrap();
        let wall = study.environments[1].scene.wall_rad().unwrap();
        assert!((wall.to_degrees() - 26.6).abs() < 1e-12);
        assert!((study.device.theta_max_rad.unwrap() - 45_f64.to_radians()).abs() < 1e-15);
    }

    #[test]
    fn errors_name_the_key_and_its_line() {
        check("repeats = 6", "repeats = 0", "design.repeats", "at least 1");
        check("wall_deg = 26.6", "", "environments[1].wall_deg", "missing");
        check("wall_deg = 26.6", "wall_deg = nan", "environments[1].wall_deg", "finite");
        check("lever_m = 0.045", "lever_m = -1.0", "device.lever_m", "above 0");
        check("id = \"passive\"", "id = \"active\"", "modes[1].id", "twice");
        check("id = \"passive\"", "id = \"../x\"", "id", "not a valid mode id");
        check("theta_max_deg = 45.0", "theta_max_deg = -50.0", "device.theta_max_deg", "above");
        check("wall_deg = 26.6", "wall_mm = 26.6", "environments[1].wall_mm", "no meaning");
        check("repeats = 6", "repeat = 6", "repeat", "unknown field");
        check("repeats = 6", "repeats = \"six\"", "repeats", "invalid type");
        check("schema = 1", "schema = 2", "schema", "unknown");
    }

    #[test]
    fn every_problem_is_reported_not_only_the_first() {
        let text = sample().replace("repeats = 6", "repeats = 0").replace("lever_m = 0.045", "lever_m = 0.0");
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
        assert_eq!(Study::from_toml(&study.to_toml().unwrap()).unwrap(), study);
    }
}
