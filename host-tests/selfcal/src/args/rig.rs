//! Values that the files of a rig may lack.

use clap::Args;
use rigs::data::Meta;
use rigs::doubts;
use rigs::formats::Unknowns;

use super::parse::{numbers, sizes};

/// Values that rig files may lack.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct RigArgs {
    /// Size of the rig's images, px, if its files lack it or have several; of left and right if they differ.
    #[arg(long, value_parser = sizes, value_name = "W,H[,W,H]")]
    size: Option<[[u16; 2]; 2]>,

    /// Unit of T in metres, if T is in units of the board: 0.001 for mm [default: 1].
    #[arg(long, value_name = "M")]
    unit: Option<f64>,

    /// Numbers of the left and right camera in a file: 2,3 for the colour cameras of KITTI [default: 0,1; for a Luxonis
    /// camera the sockets that its file names].
    #[arg(long, value_parser = numbers::<u8, 2>, value_name = "LEFT,RIGHT")]
    cameras: Option<[u8; 2]>,
}

impl RigArgs {
    /// The values in the form of the readers.
    pub(crate) fn unknowns(&self) -> Unknowns {
        Unknowns { sizes: self.size, unit_m: self.unit.unwrap_or(1.0), cameras: self.cameras }
    }
}

/// Tells the doubts about a rig that was read.
pub(crate) fn tell_doubts(meta: &Meta) {
    for doubt in doubts(meta) {
        eprintln!("note: {doubt}");
    }
}
