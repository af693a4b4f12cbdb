//! Where in a sample's cell visibility is found.

use foveasim_models::Msaa;

/// Offsets from the middle of the cell.
pub(crate) mod offsets {
    use super::Msaa;

    /// Four positions on a rotated grid [sub-samples]: ±2/16 and ±6/16 of a sample, the pattern that
    /// graphics hardware has for 4× multisampling (Direct3D 11.3 functional specification, §19.2).
    pub(crate) const FOUR: [[i32; 2]; 4] = [[-32, -96], [96, -32], [-96, 32], [32, 96]];

    /// Greatest offset along either axis [sub-samples].
    pub(crate) fn reach(msaa: Msaa) -> i32 {
        match msaa {
            Msaa::One => 0,
            Msaa::Four => 96,
        }
    }
}
