//! Facts of the whole screen, read off its cells.

pub(super) mod examples;

use super::keys::{Ask, Entry, commands};
use super::look::Look;
use super::render::render;
use crate::{Phase, Timing, Verdict, View};
use examples::{asked, phases, question, view};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::Color;
use zwidth_study::AnswerScale;

const FULL: Look = Look { colour: true, ascii: false };
const BARE: Look = Look { colour: false, ascii: true };
const SMALLEST: (u16, u16) = (80, 24);

fn draw(view: &View, entry: Option<&Entry>, look: Look, size: (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
    terminal.draw(|frame| render(view, entry, look, frame)).unwrap();
    terminal.backend().buffer().clone()
}

fn rows(view: &View, entry: Option<&Entry>, look: Look, size: (u16, u16)) -> Vec<String> {
    let buffer = draw(view, entry, look, size);
    let cells = buffer.content.chunks(usize::from(size.0));
    cells.map(|row| row.iter().map(|cell| cell.symbol()).collect()).collect()
}

/// What a screen of 80 × 24 says, its lines joined and runs of spaces made one.
fn words(view: &View, entry: Option<&Entry>) -> String {
    let text = rows(view, entry, FULL, SMALLEST).join(" ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn entries() -> [Option<Entry>; 7] {
    [
        None,
        Some(Entry::Note(None, "a note".into())),
        Some(Entry::Answer("-3".into())),
        Some(Entry::Exclude(None, String::new())),
        Some(Entry::Which("12".into())),
        Some(Entry::Trial(12)),
        Some(Entry::Sure(Ask::Quit)),
    ]
}

#[test]
fn the_stop_key_stands_in_the_last_row_in_every_phase_whatever_is_typed_and_however_small_the_window()
 {
    for phase in phases() {
        for entry in entries() {
            let typing = matches!(entry, Some(Entry::Note(..) | Entry::Exclude(..)));
            let runs = matches!(phase, Phase::Trial { .. });
            let key = if typing && !runs { " Ctrl-C STOP " } else { " Space STOP " };
            for size in [(120, 40), SMALLEST, (40, 6), (16, 1)] {
                let rows = rows(&view(phase.clone(), false), entry.as_ref(), FULL, size);
                assert!(rows.last().unwrap().contains(key), "{phase:?} {entry:?} {size:?}");
            }
        }
    }
}

#[test]
fn where_there_is_little_room_a_question_keeps_the_ends_of_its_scale() {
    let small = rows(&view(asked(), false), None, FULL, (40, 10)).join("\n");
    assert!(small.contains("1 strongly disagree") && small.contains("5 strongly agree"), "{small}");
    assert!(small.contains("stiffness.") && !small.contains("3 neutral"), "{small}");
    let high = rows(&view(asked(), false), None, FULL, (40, 24)).join("\n");
    assert!(high.contains("3 neutral"), "{high}");
}

#[test]
fn a_blinded_screen_shows_neither_mode_nor_voltage_even_if_the_view_held_them() {
    for phase in phases() {
        let mut leaky = view(phase.clone(), false);
        let open = words(&leaky, None);
        // What is done of each condition stands there at the end, too.
        let before_or_after = [Phase::Check, Phase::AtStop, Phase::Homing, Phase::Left];
        let is_step = matches!(phase, Phase::Step { .. });
        assert_eq!(open.contains("Hybrid"), !is_step && !before_or_after.contains(&phase));
        leaky.blinded = true;
        assert_eq!(words(&leaky, None), words(&view(phase, true), None));
        if is_step {
            continue; // the check names the motor and the brake in either case
        }
        leaky.checks.clear(); // they name the motor and the brake in either case
        let blinded = words(&leaky, None);
        for word in ["Hybrid", "voltage", "motor", "brake"] {
            assert!(!blinded.contains(word), "{word} in {blinded}");
        }
        assert!(blinded.contains("BLINDED"));
    }
}

#[test]
fn a_wide_window_has_the_force_against_the_angle_beside_the_traces_with_the_trial_before() {
    let running = Phase::Trial { t_s: 1.6, limit_s: 4.0 };
    let wide = |view: &View, look| rows(view, None, look, (120, 40)).join("\n");
    let shown = view(running.clone(), false);
    let text = wide(&shown, BARE);
    for words in ["force (N) at angle", "one before", "velocity", "voltage", "45 deg"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let of = |letter: char, view: &View| wide(view, BARE).matches(letter).count();
    let alone = View { earlier: std::collections::VecDeque::new(), ..shown.clone() };
    assert!(of('.', &shown) > of('.', &alone) + 5, "{text}");
    let lawless = View { law: Vec::new(), ..shown.clone() };
    assert!(of('-', &shown) > of('-', &lawless) + 3, "{text}");
    let other = crate::Labels { environment: "Spring".into(), mode: None };
    let strange = View { traced: Some(other), ..shown };
    assert!(!wide(&strange, FULL).contains("one before"));
    assert!(!words(&view(running, false), None).contains("force (N) at"));
}

#[test]
fn at_80_by_24_nothing_is_cut() {
    for (phase, entry) in phases().into_iter().flat_map(|p| entries().map(|e| (p.clone(), e))) {
        for blinded in [true, false] {
            let text = words(&view(phase.clone(), blinded), entry.as_ref());
            assert!(!text.contains('…'), "{text}");
            assert!(text.contains("thesis-twin · P01 · S01 twin 1 SIMULATED"), "{text}");
            assert!(text.contains("11 of 39 done"));
            assert!(text.contains(
                "1000 of 1000 Hz jitter µs p50 58 p99 112 max 1340 missed 3 ! dropouts 0"
            ));
            assert!(
                text.contains("> trial 11 stored: 3,998 samples"),
                "{phase:?} {entry:?} {text}"
            );
            let commands = commands(&phase);
            let keys = commands.iter().map(|(key, meaning)| format!("{key} {meaning}"));
            let keys: Vec<String> = keys.filter(|_| entry.is_none()).collect();
            assert!(keys.iter().all(|key| text.contains(key)), "{text}");
        }
    }
}

#[test]
fn a_question_is_asked_whole_with_every_word_of_the_scale() {
    let text = words(&view(asked(), true), None);
    assert!(text.contains(&question()), "{text}");
    let five = AnswerScale::FivePoint;
    for n in five.answers() {
        assert!(text.contains(&format!("{n} {}", five.word(n).unwrap())), "{text}");
    }
    let narrow = rows(&view(asked(), true), None, FULL, (50, 24)).join("\n");
    assert!(narrow.contains(" 4 agree") && narrow.contains(" 5 strongly agree"), "{narrow}");
}

#[test]
fn a_long_scale_is_told_by_its_ends_and_how_it_is_answered() {
    let labels = ["very low", "very high"].map(str::to_owned).to_vec();
    let scale = zwidth_study::NumberScale { points: 21, from: 0, step: 5, labels };
    let scale = AnswerScale::Numbers(scale);
    let text = words(&view(Phase::Question { text: "Effort?".into(), scale }, true), None);
    assert!(text.contains("A number from 0 to 100 in steps of 5, then Enter."), "{text}");
    assert!(text.contains("0 very low") && text.contains("100 very high"), "{text}");
    assert!(!text.contains(" 55 "), "{text}");
}

#[test]
fn every_mode_is_shown_with_its_number_where_it_is_asked_for() {
    let modes: Vec<String> = (1..=10).map(|n| format!("mode {n}")).collect();
    for (few, key) in [(3, "0–3"), (10, "0 to 10, Enter")] {
        let scale = AnswerScale::Modes(modes[..few].to_vec());
        let text = words(&view(Phase::Question { text: "Which?".into(), scale }, true), None);
        assert!(text.contains("0 do not know") && text.contains(key), "{text}");
        for (n, mode) in (1..).zip(&modes[..few]) {
            assert!(text.contains(&format!("{n} {mode}")), "{text}");
        }
    }
}

#[test]
fn answers_are_offered_in_the_question_phase_alone() {
    for phase in phases() {
        let asks = matches!(phase, Phase::Question { .. });
        let text = words(&view(phase, false), None);
        assert_eq!(
            (text.contains("1–5 answer"), text.contains("strongly agree")),
            (asks, asks),
            "{text}"
        );
    }
}

#[test]
fn whether_the_trial_met_the_protocol_stands_below_the_phase_and_in_the_smallest_window_too() {
    let unmet = Some("2 movements forward, 1 back".to_owned());
    for (unmet, told) in [
        (None, ["trial 2 met the protocol"; 2]),
        (
            unmet,
            [
                "trial 2 did not meet the protocol: 2 movements forward, 1 back",
                "not met: 2 movements forward, 1 back",
            ],
        ),
    ] {
        let verdict = Some(Verdict { trial: 2, unmet });
        let view = View { verdict, ..view(asked(), false) };
        let rows = rows(&view, None, FULL, (80, 24));
        assert!(rows[3].contains(told[0]), "{}", rows.join("\n"));
        assert_eq!(
            rows[4..],
            self::rows(&View { verdict: None, ..view.clone() }, None, FULL, (80, 24))[4..]
        );
        let small = self::rows(&view, None, BARE, (40, 10)).join("\n");
        assert!(small.contains(told[1]), "{small}");
    }
}

#[test]
fn the_traces_stand_where_they_stood_from_trial_to_question_to_pause() {
    let at = |phase| {
        rows(&view(phase, false), None, FULL, SMALLEST)
            .iter()
            .position(|row| row.contains("velocity"))
    };
    let trial = at(Phase::Trial { t_s: 1.0, limit_s: 4.0 });
    assert!(trial.is_some());
    assert_eq!(at(asked()), trial);
    assert_eq!(at(Phase::Pause { left_s: 1.0, pause_s: 5.0 }), trial);
    assert_eq!(at(Phase::Ready), trial);
}

#[test]
fn the_wall_is_a_broken_line_at_its_angle() {
    let mut view = view(Phase::Trial { t_s: 1.6, limit_s: 4.0 }, true);
    let with = rows(&view, None, BARE, SMALLEST);
    let dashes = |rows: &[String]| rows.iter().position(|row| row.contains("- - - -"));
    // Scale from −48° to 48° over nine rows: 26.6° lies in the third, below the title at row 4.
    assert_eq!(dashes(&with), Some(4 + 1 + 2), "{}", with.join("\n"));
    view.wall_rad = None;
    assert_eq!(dashes(&rows(&view, None, BARE, SMALLEST)), None);
}

#[test]
fn a_motor_that_pushes_back_is_drawn_below_zero_and_the_brake_above() {
    let rows =
        rows(&view(Phase::Pause { left_s: 1.0, pause_s: 5.0 }, false), None, BARE, (120, 40));
    let row = |what: &str| rows.iter().position(|row| row.contains(what));
    let (brake, zero, motor) = (row("bbbbbbbbb"), row("0|bbb"), row("mmmmmmmmmm"));
    assert!(brake.is_some() && brake < zero && zero < motor, "{}", rows.join("\n"));
}

#[test]
fn values_are_shown_while_they_are_those_of_the_device() {
    let trial = words(&view(Phase::Trial { t_s: 1.6, limit_s: 4.0 }, false), None);
    assert!(trial.contains("motor -8.0 ─ brake 2.7 ╌") && trial.contains("2.4 s left"), "{trial}");
    let pause = words(&view(Phase::Pause { left_s: 3.2, pause_s: 5.0 }, false), None);
    assert!(pause.contains("last trial") && pause.contains("motor ─ brake ╌"), "{pause}");
    assert!(pause.contains("3.2 s left") && pause.contains("Next: trial 41"), "{pause}");
}

#[test]
fn what_is_typed_and_what_is_asked_is_in_sight() {
    let note = Entry::Note(None, "the finger slipped ".into());
    assert!(words(&view(Phase::Ready, false), Some(&note)).contains("Note: the finger slipped _"));
    let long = Entry::Note(None, "x".repeat(150) + " the end");
    assert!(words(&view(asked(), false), Some(&long)).contains("the end_"));
    let repeat = Entry::Sure(Ask::Repeat(None));
    let text = words(&view(Phase::Pause { left_s: 3.2, pause_s: 5.0 }, false), Some(&repeat));
    assert!(
        text.contains("Do the last trial again?") && text.contains("y yes any other key no"),
        "{text}"
    );
}

#[test]
fn without_colour_no_cell_has_one_and_in_ascii_no_cell_has_more() {
    for phase in phases() {
        let buffer = draw(&view(phase, false), None, BARE, SMALLEST);
        assert!(
            buffer.content.iter().all(|cell| (cell.fg, cell.bg) == (Color::Reset, Color::Reset))
        );
        assert!(buffer.content.iter().all(|cell| cell.symbol().is_ascii()));
    }
}

#[test]
fn every_size_of_window_is_drawn_and_the_phase_is_named_in_two_rows() {
    let sizes = [(1, 1), (5, 2), (30, 2), (200, 3), (79, 9), (3, 70), (80, 16), (250, 90)];
    for (phase, size) in phases().into_iter().flat_map(|p| sizes.map(|s| (p.clone(), s))) {
        for look in [FULL, BARE] {
            let rows = rows(&view(phase.clone(), false), entries()[1].as_ref(), look, size);
            if size.0 >= 30 {
                assert!(
                    rows.iter().any(|row| row.contains(super::panel::name(&phase))),
                    "{phase:?} {size:?}"
                );
            }
        }
    }
}

#[test]
fn an_empty_view_is_a_screen_too() {
    let text = words(&View::default(), None);
    assert!(text.contains("DEVICE CHECK") && text.contains("0 of 0 done"), "{text}");
}

#[test]
fn before_the_first_trial_the_device_check_stands_where_the_traces_will() {
    let mut view = view(Phase::Ready, false);
    assert!(!words(&view, None).contains("unwrap margin"));
    view.trace.clear();
    let text = words(&view, None);
    assert!(
        text.contains("ok unwrap margin 0.02 turn") && text.contains("FAILED motor responds"),
        "{text}"
    );
    assert!(!text.contains("velocity"), "{text}");
}

#[test]
fn what_is_done_of_each_condition_and_how_long_the_rest_takes_is_in_sight_between_trials() {
    let pause = Phase::Pause { left_s: 3.2, pause_s: 5.0 };
    for phase in [Phase::Ready, pause.clone(), Phase::Done] {
        let text = words(&view(phase.clone(), false), None);
        assert!(text.contains("Spring: Active 1 of 6, Passive 1 of 6, Hybrid 0 of 6"), "{text}");
        assert!(text.contains("11 of 39 done · 3 min, about 7 min to go"), "{text}");
        let text = words(&view(phase, true), None);
        assert!(text.contains("Spring 2 of 18 Spring + wall 2 of 18"), "{text}");
    }
    let mut many = view(pause.clone(), false);
    many.cells.extend(view(pause.clone(), false).cells.into_iter().map(|mut cell| {
        cell.environment += " again";
        cell
    }));
    assert!(words(&many, None).contains("Spring 2 of 18 · Spring + wall 2 of 18 · Spring again"));
    let mut held = view(pause, false);
    held.held = true;
    assert!(words(&held, None).contains("The pause is held; both actuators are off."));
}

#[test]
fn the_device_check_says_how_far_it_is() {
    let mut view = view(Phase::Check, false);
    view.step = Some("Step 2 of 3: the lever all the way and back, for 4 s".into());
    assert!(words(&view, None).contains("DEVICE CHECK Step 2 of 3: the lever all the way"));
}

#[test]
fn messages_are_shown_whole_the_newest_last() {
    let mut view = view(asked(), false);
    view.say("a message of two lines: ".to_owned() + &"word ".repeat(20));
    let text = words(&view, None);
    assert!(
        text.contains("> a message of two lines: word") && !text.contains("trial 11 stored"),
        "{text}"
    );
    view.say("the newest");
    let text = words(&view, None);
    assert!(text.contains("word > the newest") || !text.contains("a message of two"), "{text}");
    assert!(text.contains("> the newest"), "{text}");
}

#[test]
fn jitter_is_told_once_it_is_known() {
    let mut view = view(Phase::Trial { t_s: 0.1, limit_s: 4.0 }, false);
    view.timing = Timing { rate_hz: 1000.0, measured_hz: 1000.0, ..Timing::default() };
    assert!(words(&view, None).contains("1000 of 1000 Hz jitter µs – missed 0"));
}

#[test]
fn lost_samples_and_a_slow_loop_are_marked_without_colour() {
    let mut view = view(Phase::Ready, false);
    view.timing.dropouts = 12;
    view.timing.measured_hz = 871.0;
    let text = words(&view, None);
    assert!(text.contains("871 of 1000 Hz !") && text.contains("dropouts 12 !"), "{text}");
    view.timing.jitter_max_s = 0.25;
    view.timing.missed = 123_456;
    let text = words(&view, None);
    assert!(
        text.contains("871 Hz !")
            && text.contains("missed 123456 !")
            && text.contains("dropouts 12 !"),
        "{text}"
    );
}

#[test]
fn before_the_first_trial_a_message_is_seen_however_long_the_device_check_is() {
    let mut view = view(Phase::Ready, false);
    view.trace.clear();
    let check = view.checks[0].clone();
    view.checks = vec![check; 20];
    view.say("there is no trial to do again yet");
    let text = words(&view, None);
    assert!(
        text.contains("there is no trial to do again yet")
            && text.contains("20 of 20 device checks are ok"),
        "{text}"
    );
}
