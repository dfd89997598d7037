//! How kept lanes move to the front.

/// For each of 256 masks, the positions of its set bits, in order: a permutation that moves the
/// kept lanes to the front. In bytes: wider, the table would take a quarter of the nearest cache.
pub(super) static FRONT: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut kept) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][kept] = lane as u8;
                kept += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};
