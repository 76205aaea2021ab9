//! A whole session on a disk in memory: everything that it reads and writes goes through the file
//! layer.

use super::*;
use zwidth_store::{Fault as DiskFault, Memory, Survives, recover, verify_from};

/// A desk of which nothing lies on the real disk.
fn in_memory(blinded: bool) -> (Desk, Memory) {
    let (mut desk, disk) = (Desk::new(blinded), Memory::new());
    desk.plan.layout = Layout::new(Path::new("/nowhere"), "small".parse().unwrap());
    desk.plan.keys = PathBuf::from("/nowhere/keys");
    disk.put(&desk.plan.layout.study_toml(), &desk.plan.study_toml);
    (desk, disk)
}

fn findings(desk: &Desk, disk: &Memory) -> Vec<zwidth_store::StoreError> {
    verify_from(disk, &desk.plan.layout)
}

#[test]
fn a_session_in_memory_touches_no_real_disk_and_ended_at_any_step_goes_on_in_the_same_order() {
    for blinded in [false, true] {
        let (desk, disk) = in_memory(blinded);
        let before = disk.steps();
        let outcome = desk.run(&mut Mock::default(), &disk, &mut diligent()).unwrap();
        let steps = disk.steps() - before;
        assert_eq!((outcome.done, outcome.stopped, findings(&desk, &disk)), (TRIALS, None, vec![]));
        let mut data = StudyData::load_from(&disk, &desk.plan.layout).unwrap();
        assert_eq!(data.trials.len(), TRIALS);
        assert_eq!(disk.below(&desk.plan.keys).len(), if blinded { 2 } else { 0 });
        assert!(!Path::new("/nowhere").exists());
        let whole = data.sessions.remove(0).record;
        // Often until the first trial runs, and now and then afterwards; by a kill and by a power
        // cut in turn.
        for (turn, at) in (0..60).step_by(5).chain((60..steps).step_by(311)).enumerate() {
            let survives = [Survives::Everything, Survives::Synced][turn % 2];
            let (desk, disk) = in_memory(blinded);
            disk.fail_in(at, DiskFault::End);
            let mut mock = Mock::default();
            desk.run(&mut mock, &disk, &mut diligent()).unwrap_err();
            assert_eq!(
                mock.writes.last().map_or(Voltages::OFF, |(_, v)| *v),
                Voltages::OFF,
                "{at}"
            );
            disk.restart(survives);
            for found in recover(&disk, &desk.plan.layout, UTC) {
                found.unwrap_or_else(|e| panic!("{at} {survives:?}: {e}"));
            }
            assert_eq!(findings(&desk, &disk), [], "{at} {survives:?}");
            let outcome = desk.run(&mut Mock::default(), &disk, &mut diligent()).unwrap();
            assert_eq!(
                (outcome.done, findings(&desk, &disk)),
                (TRIALS, vec![]),
                "{at} {survives:?}"
            );
            let found =
                StudyData::load_from(&disk, &desk.plan.layout).unwrap().sessions.remove(0).record;
            assert_eq!(found.trials, whole.trials, "{at} {survives:?}");
        }
    }
}

/// Found by seed 13569 of `cargo xtask soak simulate`: a life that was killed between a file and
/// the sync of its name left a seal, or a folder, that the next life took for kept, and a power cut
/// took it away.
#[test]
fn what_a_killed_life_left_unsynced_is_synced_by_the_next_before_a_power_cut_can_take_it() {
    for blinded in [false, true] {
        for at in 0..40 {
            let (desk, disk) = in_memory(blinded);
            disk.fail_in(at, DiskFault::End);
            desk.run(&mut Mock::default(), &disk, &mut diligent()).unwrap_err();
            disk.restart(Survives::Everything);
            disk.fail_in(150, DiskFault::End);
            desk.run(&mut Mock::default(), &disk, &mut diligent()).unwrap_err();
            disk.restart(Survives::Synced);
            for found in recover(&disk, &desk.plan.layout, UTC) {
                found.unwrap_or_else(|e| panic!("{at}: {e}"));
            }
            let outcome = desk.run(&mut Mock::default(), &disk, &mut diligent()).unwrap();
            assert_eq!((outcome.done, findings(&desk, &disk)), (TRIALS, vec![]), "{at}");
        }
    }
}
