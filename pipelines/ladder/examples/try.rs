use zwidth_device::Velocity;
use zwidth_ladder::*;
fn main() {
    let f = std::env::args().nth(1).unwrap();
    let n: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let t: f64 = std::env::args().nth(3).map_or(0.0083, |x| x.parse().unwrap());
    let s = zwidth_dynamics::ModelScene::from_toml(&std::fs::read_to_string(f).unwrap()).unwrap();
    let set = Settings {
        looped: Loop {
            period_s: t,
            velocity: Velocity::new(zwidth_study::VelocityFilter::SecondOrder { cutoff_hz: 40.0 })
                .unwrap(),
        },
        points: n,
        bounds: Default::default(),
        offered: TermSet::ALL,
    };
    let b = std::time::Instant::now();
    let l = ladder(&s, &set, &own).unwrap();
    println!("{:?}", b.elapsed());
    for r in &l.rungs {
        println!(
            "{:60} {:9.0} {:?} {:?}",
            r.set.words(),
            r.multiplications,
            r.counts.map(|x| x.round()),
            r.worst.iter().map(|x| (x * 100.).round() / 100.).collect::<Vec<_>>()
        );
    }
    for q in &l.quantities {
        println!("{} {:?}", q.name, (0..8).map(|i| q.variance.total(i)).collect::<Vec<_>>());
    }
    println!("choice {:?}", l.choice().map(|r| r.set.words()));
}
