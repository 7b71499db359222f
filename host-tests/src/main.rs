use host_tests::{dataset::Dataset, evaluation::Step, replay::replay};
use stereo_selfcal::{Config, Extrinsics};
fn main() {
    for n in Dataset::SHIPPED {
        let set = Dataset::load(&Dataset::shipped().join(n)).unwrap();
        println!("{n}\n{}", Step::HEADING);
        let e = replay::<f64>(&set, Config::paper(), Extrinsics::SIDE_BY_SIDE, |s| println!("{s}"))
            .unwrap();
        println!("{}", e.summary(&set).unwrap());
        let e = replay::<f32>(&set, Config::paper(), Extrinsics::SIDE_BY_SIDE, |s| println!("{s}"))
            .unwrap();
        println!("{}", e.summary(&set).unwrap());
    }
}
