use stereo_selfcal::*;
fn main() {
    println!(
        "{} {} {}",
        size_of::<Calibrator<f32, 256>>(),
        size_of::<PairReport<f32>>(),
        size_of::<Calibrator<f32, 0>>()
    );
}
