//! Figures of the paper, rad: `e_t`, `e_theta` of several fused pairs, the best row of each of its tables.

/// Data set, view, and `[e_t, e_theta]` of \[7\] and of the paper's method.
pub(super) type Reported = (&'static str, &'static str, [[f64; 2]; 2]);

pub(super) const KITTI: &str = "KITTI 2015";
pub(super) const MIDDLEBURY: &str = "Middlebury 2021";

/// All rows.
pub(super) const REPORTED: [Reported; 10] = [
    (KITTI, "middle", [[0.0715, 0.0030], [0.0130, 0.0014]]),
    (KITTI, "top", [[0.1155, 0.0027], [0.0163, 0.0024]]),
    (KITTI, "bottom", [[0.0600, 0.0037], [0.0322, 0.0027]]),
    (KITTI, "left", [[0.1494, 0.0053], [0.0282, 0.0027]]),
    (KITTI, "right", [[0.0461, 0.0036], [0.0370, 0.0018]]),
    (MIDDLEBURY, "middle", [[0.0171, 0.0007], [0.0084, 0.0005]]),
    (MIDDLEBURY, "top", [[0.0185, 0.0006], [0.0050, 0.0004]]),
    (MIDDLEBURY, "bottom", [[0.0490, 0.0086], [0.0091, 0.0009]]),
    (MIDDLEBURY, "left", [[0.0184, 0.0010], [0.0094, 0.0004]]),
    (MIDDLEBURY, "right", [[0.0200, 0.0006], [0.0048, 0.0008]]),
];

/// The paper's figures for a data set of the same kind: rectified pairs of Middlebury, or KITTI.
pub(super) fn comparable(set: &str, view: &str) -> Option<[[f64; 2]; 2]> {
    let of_middlebury = ["motorcycle", "aloe", "middlebury"].iter().any(|name| set.contains(name));
    let of_kitti = set.contains("kitti");
    let name = match (of_middlebury, of_kitti) {
        (true, _) => MIDDLEBURY,
        (_, true) => KITTI,
        _ => return None,
    };
    REPORTED.iter().find(|(of, at, _)| (*of, *at) == (name, view)).map(|(.., errors)| *errors)
}
