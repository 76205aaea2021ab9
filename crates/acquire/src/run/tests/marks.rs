//! Markers of whole sessions: sent to another program, and kept in the log.

use super::*;
use crate::Target;
use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use zwidth_study::Moment;

/// The markers that the log holds: trial, moment, time, whether the device's own clock is there.
fn kept(desk: &Desk) -> Vec<(u32, Moment, u64, bool)> {
    let one = |event: &Event| match event {
        Event::Marker { trial, moment, t_us, device_us, .. } => {
            Some((*trial, *moment, *t_us, device_us.is_some()))
        }
        _ => None,
    };
    desk.data().sessions[0].events.iter().filter_map(one).collect()
}

#[test]
fn every_trial_has_its_markers_in_the_log_and_each_was_told_in_order() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut desk = Desk::new(false);
    desk.options.markers = vec![Target::Tcp(listener.local_addr().unwrap().to_string())];
    let heard = std::thread::spawn(move || {
        BufReader::new(listener.accept().unwrap().0)
            .lines()
            .map_while(Result::ok)
            .collect::<Vec<_>>()
    });
    let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut diligent()).unwrap();
    let (heard, kept) = (heard.join().unwrap(), kept(&desk));
    assert_eq!(heard.len(), kept.len());
    for (line, (trial, moment, t_us, _)) in heard.iter().zip(&kept) {
        let begin = format!("{{\"marker\":\"{}\",\"trial\":{trial},\"t_s\":", moment.as_str());
        let t_s: String =
            line.strip_prefix(&begin).unwrap().chars().take_while(|c| !",}".contains(*c)).collect();
        assert!((t_s.parse::<f64>().unwrap() * 1e6 - *t_us as f64).abs() < 1.5, "{line} {t_us}");
    }
    let limit_us = desk.plan.study.design.trial_limit_s * 1e6;
    for trial in 1..=outcome.total as u32 {
        let of: Vec<_> = kept.iter().filter(|(n, ..)| *n == trial).collect();
        let moments: Vec<Moment> =
            of.iter().map(|m| m.1).filter(|m| *m != Moment::Contact).collect();
        assert_eq!(moments, [Moment::Start, Moment::End, Moment::Answer], "trial {trial}");
        assert!(of.windows(2).all(|two| two[0].2 <= two[1].2), "{of:?}");
        assert!(
            of.iter().any(|m| m.1 == Moment::End && (1.0..=limit_us).contains(&(m.2 as f64))),
            "{of:?}"
        );
    }
    assert_eq!(verify(&desk.plan.layout), []);
}

#[test]
fn a_program_that_is_not_there_costs_no_trial_and_is_a_note() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut desk = Desk::new(false);
    desk.options.markers = vec![Target::Tcp(free.to_string())];
    // Somebody waits for the note before they go on.
    let mut front = somebody(|view: &View| {
        let told = view.messages.iter().any(|message| message.contains("takes no markers"));
        (view.phase == Shown::Done && !told).then(|| Input::Note("waits".into()))
    });
    let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
    assert_eq!((outcome.done, outcome.stopped), (outcome.total, None));
    let events = desk.data().sessions.remove(0).events.into_iter();
    let notes: Vec<String> = events
        .filter_map(|event| if let Event::Note { text, .. } = event { Some(text) } else { None })
        .filter(|text| text.contains("takes no markers"))
        .collect();
    let words = format!("tcp:{free} takes no markers: ");
    assert!(matches!(&notes[..], [one] if one.starts_with(&words)), "told once: {notes:?}");
    assert!(!kept(&desk).is_empty());
    assert_eq!(verify(&desk.plan.layout), []);
}

#[test]
fn a_board_shows_each_marker_of_the_log_itself_and_one_without_a_pin_is_refused() {
    let mut desk = Desk::new(false);
    desk.options.markers = vec![Target::Board];
    let mut mock = Mock::default();
    let outcome = desk.run(&mut mock, &RealFiles, &mut diligent()).unwrap();
    assert_eq!((outcome.done, outcome.stopped), (outcome.total, None));
    let logged: Vec<Moment> = kept(&desk).iter().map(|marker| marker.1).collect();
    // A spring has no contact.
    assert_eq!(logged, [Moment::Start, Moment::End, Moment::Answer].repeat(outcome.total));
    assert_eq!(mock.moments, logged);

    let mut desk = Desk::new(false);
    desk.options.markers = vec![Target::Board];
    let mut mock = Mock::default();
    mock.capabilities.shows_moments = false;
    let refused = desk.run(&mut mock, &RealFiles, &mut diligent()).unwrap_err().to_string();
    assert!(refused.contains("mock 1 has no pin for markers"), "{refused}");
    assert_eq!(mock.moments, []);
}

#[test]
fn without_a_program_that_listens_no_marker_is_kept() {
    let desk = Desk::new(false);
    desk.run(&mut Mock::default(), &RealFiles, &mut diligent()).unwrap();
    assert_eq!(kept(&desk), []);
}
