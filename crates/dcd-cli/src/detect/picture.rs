//! A scene and what was found in it, as binary glTF.

use super::steps::Found;
use dcd_geom::Scene;
use dcd_io::{GlbContact, GlbScene};
use std::io::{self, Write};

/// Objects of contacts and of undecided pairs are coloured; an undecided pair may touch.
pub(super) fn write(scene: &Scene, found: &Found, out: &mut dyn Write) -> io::Result<()> {
    let contacts = found.contacts.iter();
    let undecided = found.undecided.iter().map(|undecided| &undecided.pair);
    let touching = contacts.chain(undecided).flat_map(|pair| [pair.i, pair.j]);
    let points = found.reported.iter().flat_map(|(_, reported)| reported.contact_points());
    let points = points.map(|(point, normal)| GlbContact { point, normal }).collect();
    let mut glb = GlbScene::new(scene);
    glb.frame(0.0, scene.poses(), touching, points)?;
    glb.write(out)
}
