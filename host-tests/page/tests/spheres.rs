//! Estimates on their spheres.

use page::report::Picture;
use page::run::{Estimates, sphere_figure};
use sim::synth::rig;

#[test]
fn every_pair_is_on_its_sphere() {
    let reference = rig([2.0, -1.0, 0.5], [1.0, 2.0]).unwrap();
    let pairs: Vec<_> = (0..7)
        .map(|i| {
            rig([2.0, -1.0 + 0.1 * f64::from(i), 0.5], [1.0, 2.0 - 0.1 * f64::from(i)]).unwrap()
        })
        .collect();
    let estimates = Estimates { pairs, fused: Some(reference), reference };
    let figure = sphere_figure("sphere", &estimates, estimates.reach(), "selfcal replay");
    assert_eq!(figure.panels.len(), 4);
    for (picture, label) in &figure.panels {
        let Picture::Svg(svg) = picture else { panic!("{label} is no SVG") };
        // Seven pairs and the fused estimate.
        assert_eq!(svg.matches("<circle").count(), 8, "{label}");
    }
    assert_eq!(figure.numbers.rows.len(), 9);
}

/// The words of a picture, and the numbers at its axes.
fn texts(svg: &str) -> Vec<String> {
    let after = svg.split("<text").skip(1).filter_map(|text| text.split(['>', '<']).nth(1));
    after.map(String::from).collect()
}

#[test]
fn spheres_of_one_reach_have_one_scale() {
    let reference = rig([2.0, -1.0, 0.5], [1.0, 2.0]).unwrap();
    let off = |degrees: f64| Estimates {
        pairs: vec![rig([2.0 + degrees, -1.0, 0.5], [1.0, 2.0 + degrees]).unwrap()],
        fused: Some(reference),
        reference,
    };
    let (near, far) = (off(0.1), off(1.0));
    let reach = near.reach().or(far.reach());
    let scales = |estimates: &Estimates, reach| {
        let figure = sphere_figure("sphere", estimates, reach, "selfcal replay");
        let of = |(picture, _): &(Picture, String)| match picture {
            Picture::Svg(svg) => texts(svg),
            Picture::Png(_) | Picture::Jpeg(_) => panic!("no SVG"),
        };
        figure.panels.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(scales(&near, reach), scales(&far, reach));
    assert_ne!(scales(&near, near.reach()), scales(&far, reach));
}
