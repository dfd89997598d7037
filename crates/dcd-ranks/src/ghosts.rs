//! What goes from rank to rank before a step: bodies that have left, and ghosts.

use crate::local::{Local, Role};
use crate::wire::{Reader, Writer};
use crate::{Cuts, RankError, Transport};
use std::collections::HashSet;

/// What a message says of a body.
const GHOST: u8 = 0;
const OWNED: u8 = 1;

/// Bytes of a body in a message: flag, two names, twelve numbers.
const BODY_BYTES: usize = 1 + 2 * 8 + 12 * 8;
/// Bytes of a shape in a message, at least: name, kind, radius.
const SHAPE_BYTES: usize = 8 + 4 + 8;

/// What goes to one rank.
#[derive(Debug, Default)]
struct Outbox {
    shapes: Writer,
    shape_count: u64,
    bodies: Writer,
    body_count: u64,
    /// The shapes of its bodies, which the other rank keeps for as long as it has them.
    sent: HashSet<u64>,
    /// Those of the step before.
    known: HashSet<u64>,
}

impl Outbox {
    fn body(&mut self, local: &Local, slot: usize, flag: u8) -> Result<(), RankError> {
        let (name, shape) = local.shape(slot);
        if self.sent.insert(name) && !self.known.contains(&name) {
            self.shapes.number(name);
            self.shapes.shape(name, shape)?;
            self.shape_count += 1;
        }
        self.bodies.byte(flag);
        self.bodies.number(local.names()[slot]);
        self.bodies.number(name);
        self.bodies.pose(&local.scene().poses()[slot]);
        self.body_count += 1;
        Ok(())
    }

    /// The message, empty where there is no body.
    fn take(&mut self) -> Vec<u8> {
        self.known = std::mem::take(&mut self.sent);
        let (shapes, bodies) = (std::mem::take(&mut self.shapes), std::mem::take(&mut self.bodies));
        if self.body_count == 0 {
            return Vec::new();
        }
        let mut message = Writer(Vec::with_capacity(16 + shapes.0.len() + bodies.0.len()));
        message.number(std::mem::take(&mut self.shape_count));
        message.0.extend_from_slice(&shapes.0);
        message.number(std::mem::take(&mut self.body_count));
        message.0.extend_from_slice(&bodies.0);
        message.0
    }
}

/// The messages of a rank to all others, and the shapes that these hold by them.
#[derive(Debug, Default)]
pub(crate) struct Exchange {
    to: Vec<Outbox>,
    /// Steps so far.
    now: u64,
}

impl Exchange {
    /// Gives away the bodies that have left the region, and sends every rank those that reach into its region;
    /// receives the same of the others. The boxes must be those of the poses.
    pub(crate) fn run(
        &mut self,
        transport: &impl Transport,
        cuts: &Cuts,
        local: &mut Local,
        grown: f64,
    ) -> Result<(), RankError> {
        self.now += 1;
        self.to.resize_with(transport.size(), Outbox::default);
        self.write(transport.rank(), cuts, local)?;
        let outboxes = self.to.iter_mut().enumerate();
        let messages = outboxes.map(|(to, outbox)| (to, outbox.take()));
        let messages = messages.filter(|(_, message)| !message.is_empty()).collect();
        for (sender, message) in transport.exchange(messages) {
            self.read(&message, local, grown)
                .map_err(|lost| lost.unwrap_or(RankError::Message { sender }))?;
        }
        local.forget_unheard(self.now);
        local.drop_unused_shapes()
    }

    fn write(&mut self, rank: usize, cuts: &Cuts, local: &mut Local) -> Result<(), RankError> {
        let mut reached = Vec::new();
        for slot in 0..local.roles().len() {
            if local.roles()[slot] != (Role::Owned { inside: false }) {
                continue;
            }
            let aabb = local.boxes()[slot];
            let owner = cuts.owner(&aabb);
            cuts.reached(&aabb, &mut reached);
            for &to in reached.iter().filter(|&&to| to != rank && to != owner) {
                self.to[to].body(local, slot, GHOST)?;
            }
            if owner == rank {
                continue;
            }
            self.to[owner].body(local, slot, OWNED)?;
            if reached.contains(&rank) {
                local.set_role(slot, Role::Ghost { heard: self.now });
            } else {
                local.remove(slot);
            }
        }
        Ok(())
    }

    /// `Err(None)` where the message is none.
    fn read(&self, message: &[u8], local: &mut Local, grown: f64) -> Result<(), Option<RankError>> {
        let mut reader = Reader(message);
        let count = reader.count(SHAPE_BYTES).ok_or(None)?;
        let shapes = (0..count).map(|_| Some((reader.number()?, reader.shape()?)));
        let shapes = shapes.collect::<Option<Vec<_>>>().ok_or(None)?;
        local.learn(shapes)?;
        for _ in 0..reader.count(BODY_BYTES).ok_or(None)? {
            let flag = reader.byte().ok_or(None)?;
            let names = reader.number().zip(reader.number()).ok_or(None)?;
            let pose = reader.pose().ok_or(None)?;
            let role = match flag {
                GHOST => Role::Ghost { heard: self.now },
                OWNED => Role::Owned { inside: false },
                _ => return Err(None),
            };
            local.put(names, pose, role)?;
            if let Some(slot) = local.slot(names.0) {
                local.make_box(slot, grown);
            }
        }
        if reader.0.is_empty() { Ok(()) } else { Err(None) }
    }
}
