//! The step of a rank.

use crate::ghosts::Exchange;
use crate::local::{Local, Role};
use crate::share::{Bounds, agree, check_names, check_shapes};
use crate::wire::{Reader, Writer};
use crate::{Cuts, Load, RankError, Share, Transport, cut};
use dcd_exec::{Exec, Par};
use dcd_geom::{Aabb, Object, Pair, Pose, Scene, Shape};
use dcd_pipeline::{Answer, AnyPipeline, AnyStep, Precision, Question};
use std::collections::{HashMap, HashSet};

/// Bodies that are moved to their owners at a time: so that what is on the way takes little memory.
const BODIES_A_ROUND: usize = 1 << 14;

/// New cuts cost about as much as so many steps; they are made when what the imbalance has cost since the
/// last ones exceeds it.
const STEPS_A_CUT: u64 = 2;

/// A scene of which this rank has a part.
#[derive(Debug)]
pub struct RankScene<'t, T> {
    transport: &'t T,
    /// Those by which the ghosts are here.
    cuts: Cuts,
    /// Those from the next refresh on.
    next_cuts: Option<Cuts>,
    /// Whether no body has moved since the ghosts were brought up to date.
    is_refreshed: bool,
    local: Local,
    exchange: Exchange,
    pipeline: AnyPipeline,
    /// Measures again the pairs whose order in the scene is not that of their names.
    ordered: AnyPipeline,
    is_measured: bool,
    /// By which boxes are grown, metres: half of the question's margin.
    grown: f64,
    /// What the imbalance has cost since the last cut, and the least of it in a step: what new cuts would leave, too.
    wasted: u64,
    left: u64,
}

/// What a rank found in a step: the pairs that it reports.
#[derive(Clone, Debug, Default)]
pub struct RankStep {
    /// The touching pairs by name, the smaller first; in no order.
    pub contacts: Vec<[u64; 2]>,
    /// What was measured of each, in the same order; nothing where the question is yes or no.
    pub answers: Vec<Answer>,
    /// How many pairs are undecided.
    pub undecided: usize,
    /// What there was to do.
    pub load: Load,
}

impl<'t, T: Transport> RankScene<'t, T> {
    /// Spreads what the ranks bring along: regions of equal cost are cut, and every body goes to its owner.
    ///
    /// # Errors
    /// On all ranks if there is one on any: a question without error bounds, a margin that no pipeline takes, a
    /// shape that no message holds, a body without a shape or out of range, two bodies or two shapes of one name.
    pub fn new(transport: &'t T, share: Share, question: Question) -> Result<Self, RankError> {
        let made = Self::prepared(question).and_then(|made| share.check().map(|()| made));
        let bounds = share
            .shapes
            .iter()
            .map(|(name, shape)| Bounds::of(shape).ok_or(RankError::Foreign { shape: *name }));
        let made = made.and_then(|made| Ok((made, bounds.collect::<Result<Vec<_>, _>>()?)));
        let ([pipeline, ordered], bounds) = agree(transport, made)?;
        let (margin, is_measured) = match question {
            Question::Overlap { margin, .. } => (margin, false),
            Question::Distance { margin, .. } | Question::Gradient { margin, .. } => (margin, true),
            _ => (0.0, true),
        };
        // Two boxes of two that are within the margin overlap when each is grown by half of it.
        let grown = margin * (0.5 + f64::EPSILON);
        let boxes: Vec<Aabb> = share
            .bodies
            .iter()
            .map(|body| bounds[body.shape as usize].aabb(&body.pose, grown))
            .collect();
        let names: Vec<u64> = share.bodies.iter().map(|body| body.name).collect();
        check_names(transport, &names)?;
        check_shapes(transport, &share.shapes)?;
        let cuts = cut(transport, &boxes, &names, Exec::from(Par::Serial));
        let local = agree(transport, send_to_owners(transport, &cuts, share, &boxes))?;
        Ok(Self {
            transport,
            cuts,
            next_cuts: None,
            is_refreshed: false,
            local,
            exchange: Exchange::default(),
            pipeline,
            ordered,
            is_measured,
            grown,
            wasted: 0,
            left: u64::MAX,
        })
    }

    fn prepared(question: Question) -> Result<[AnyPipeline; 2], RankError> {
        if matches!(question, Question::Overlap { precision: Precision::Fast, .. }) {
            return Err(RankError::Unchecked);
        }
        let make = || AnyPipeline::new(question).map_err(RankError::Margin);
        Ok([make()?, make()?])
    }

    /// Derives what depends on the shapes alone: what a first step would do before anything else. Not
    /// collective.
    pub fn prepare_shapes(&mut self) {
        self.pipeline.prepare_shapes(self.local.scene());
    }

    /// How many bodies it owns. Not collective.
    pub fn owned_count(&self) -> usize {
        self.local.owned_count()
    }

    /// How many ghosts it has had since the last [`RankScene::refresh`]. Not collective.
    pub fn ghost_count(&self) -> usize {
        self.local.ghost_count()
    }

    /// The bodies that it owns, by name. Not collective.
    pub fn owned(&self) -> impl Iterator<Item = (u64, &Pose)> {
        let local = &self.local;
        local.owned().map(|slot| (local.names()[slot], &local.scene().poses()[slot]))
    }

    /// Moves a body that it owns. Not collective. It stays here until the next [`RankScene::refresh`], wherever
    /// it goes.
    ///
    /// # Errors
    /// Another rank owns it, or it would be out of range; nothing is changed then.
    pub fn set_pose(&mut self, name: u64, pose: Pose) -> Result<(), RankError> {
        let owned = |slot: &usize| matches!(self.local.roles()[*slot], Role::Owned { .. });
        let slot = self.local.slot(name).filter(owned).ok_or(RankError::NotOwned { body: name })?;
        self.local.set_pose(slot, pose)?;
        self.is_refreshed = false;
        Ok(())
    }

    /// Gives away the bodies that have left the region, and brings the ghosts up to date. Shapes are sent to
    /// those that did not have them in the step before.
    ///
    /// # Errors
    /// A message that is none. The other ranks do not know of it: the program must end.
    pub fn refresh<'e>(&mut self, exec: impl Into<Exec<'e>>) -> Result<(), RankError> {
        if let Some(cuts) = self.next_cuts.take() {
            self.cuts = cuts;
        }
        self.is_refreshed = false;
        let region = self.cuts.region(self.transport.rank());
        self.local.make_boxes((&self.cuts, &region), self.grown, exec.into());
        self.exchange.run(self.transport, &self.cuts, &mut self.local, self.grown)?;
        self.is_refreshed = true;
        Ok(())
    }

    /// Finds the touching pairs that are this rank's to report: all ranks together report each once. Not
    /// collective.
    ///
    /// # Errors
    /// A body of this rank has moved since the last [`RankScene::refresh`], or there was none. Of another rank's bodies nothing is
    /// known here: all ranks refresh where any has moved one.
    pub fn detect<'e>(&mut self, exec: impl Into<Exec<'e>>) -> Result<RankStep, RankError> {
        if !self.is_refreshed {
            return Err(RankError::NotRefreshed);
        }
        let exec = exec.into();
        let region = self.cuts.region(self.transport.rank());
        let (local, cuts) = (&self.local, &self.cuts);
        let is_inside = |slot: u32| local.roles()[slot as usize] == (Role::Owned { inside: true });
        // Of two boxes, one of them all inside, the corner is.
        let is_ours = |i: u32, j: u32| {
            let [a, b] = [i, j].map(|slot| &local.boxes()[slot as usize]);
            is_inside(i) || is_inside(j) || cuts.holds_corner(&region, a, b)
        };
        let step = self.pipeline.step_where(local.scene(), exec, is_ours);
        let mut found = RankStep {
            undecided: step.report().undecided().len(),
            load: Load {
                objects: local.owned_count() as u64,
                pairs: step.candidate_count() as u64,
            },
            ..RankStep::default()
        };
        if self.is_measured {
            let turned = list_measured(&step, local.names(), &mut found);
            measure_ordered(&turned, local, &mut self.ordered, &mut found);
        } else {
            found.contacts.extend(step.contacts().map(|(i, j)| named(local.names(), i, j)));
        }
        Ok(found)
    }

    /// Cuts anew if the imbalance since the last cuts has cost more than that takes; then the next
    /// [`RankScene::refresh`] moves the bodies. Whether it did, the same on all ranks. `load` is the last step's.
    pub fn balance(&mut self, load: Load) -> bool {
        let size = self.transport.size() as u64;
        let costs = self.transport.all_gather(&load.cost().to_le_bytes());
        let costs: Vec<u64> =
            costs.into_iter().map(|cost| Reader(&cost).number().unwrap_or(0)).collect();
        let (most, all) = (costs.iter().max().copied().unwrap_or(0), costs.iter().sum::<u64>());
        let waste = most - all / size;
        self.left = self.left.min(waste);
        self.wasted += waste - self.left;
        if self.wasted <= STEPS_A_CUT * (all / size) {
            return false;
        }
        (self.wasted, self.left) = (0, u64::MAX);
        let slots: Vec<usize> = self.local.owned().collect();
        let boxes: Vec<Aabb> = slots.iter().map(|&slot| self.local.boxes()[slot]).collect();
        let names: Vec<u64> = slots.iter().map(|&slot| self.local.names()[slot]).collect();
        self.next_cuts = Some(cut(self.transport, &boxes, &names, Exec::from(Par::Serial)));
        true
    }
}

/// By name, the smaller first.
fn named(names: &[u64], i: u32, j: u32) -> [u64; 2] {
    let [a, b] = [i, j].map(|slot| names[slot as usize]);
    [a.min(b), a.max(b)]
}

/// Lists contacts with their answers; those whose names are in the other order are returned, by slot, the
/// smaller name first.
fn list_measured(step: &AnyStep<'_>, names: &[u64], found: &mut RankStep) -> Vec<[u32; 2]> {
    let mut turned = Vec::new();
    for (Pair { i, j }, answer) in step.answers() {
        if names[i as usize] < names[j as usize] {
            found.contacts.push(named(names, i, j));
            found.answers.push(answer);
        } else {
            turned.push([j, i]);
        }
    }
    turned
}

/// Measures pairs in the order of their names, in a scene of their own: an answer is directed from the first to
/// the second, and may differ in its last bits with the order.
fn measure_ordered(
    pairs: &[[u32; 2]],
    local: &Local,
    pipeline: &mut AnyPipeline,
    found: &mut RankStep,
) {
    if pairs.is_empty() {
        return;
    }
    let mut slots: Vec<u32> = pairs.as_flattened().to_vec();
    slots.sort_unstable_by_key(|&slot| local.names()[slot as usize]);
    slots.dedup();
    let places: HashMap<u32, u32> = (0..).zip(&slots).map(|(place, &slot)| (slot, place)).collect();
    let wanted: HashSet<[u32; 2]> =
        pairs.iter().map(|pair| pair.map(|slot| places[&slot])).collect();
    let whole = local.scene();
    let mut scene = Scene::default();
    // A smaller scene holds what a larger one does. If not, these pairs are undecided.
    let shapes = slots.iter().map(|&slot| whole.shape(slot as usize).clone());
    let objects = (0..).zip(&slots);
    let mut objects =
        objects.map(|(shape, &slot)| Object::new(shape, whole.poses()[slot as usize]));
    let made = scene.add_shapes(shapes).map(drop);
    let made = made.and_then(|()| objects.try_for_each(|object| scene.insert(object).map(drop)));
    if made.is_err() {
        found.undecided += pairs.len();
        return;
    }
    let step = pipeline.step_where(&scene, Par::Serial, |i, j| wanted.contains(&[i, j]));
    let before = found.contacts.len();
    for (Pair { i, j }, answer) in step.answers() {
        let [a, b] = [i, j].map(|place| local.names()[slots[place as usize] as usize]);
        found.contacts.push([a, b]);
        found.answers.push(answer);
    }
    // They touch, as the other order has shown: what this one does not answer is not lost.
    found.undecided += pairs.len() - (found.contacts.len() - before);
}

/// Sends every body to its owner, in rounds; a shape is dropped with its last body.
fn send_to_owners(
    transport: &impl Transport,
    cuts: &Cuts,
    mut share: Share,
    boxes: &[Aabb],
) -> Result<Local, RankError> {
    let mut last_use = vec![0; share.shapes.len()];
    share.bodies.iter().enumerate().for_each(|(k, body)| last_use[body.shape as usize] = k);
    let mut shapes: Vec<(u64, Option<_>)> =
        share.shapes.drain(..).map(|(name, shape)| (name, Some(shape))).collect();
    let mut rounds = [share.bodies.len().div_ceil(BODIES_A_ROUND) as u64];
    let counts = transport.all_gather(&rounds[0].to_le_bytes());
    for (sender, count) in counts.iter().enumerate() {
        // Fewer rounds would lose bodies. All ranks have the same counts, and none goes on alone.
        let count = Reader(count).number().ok_or(RankError::Message { sender })?;
        rounds[0] = rounds[0].max(count);
    }
    let (mut bodies, mut known) = (Vec::new(), HashMap::new());
    let mut result = Ok(());
    for round in 0..rounds[0] as usize {
        let first = (round * BODIES_A_ROUND).min(share.bodies.len());
        let end = (first + BODIES_A_ROUND).min(share.bodies.len());
        let mut messages: Vec<(Writer, HashSet<u32>)> =
            (0..transport.size()).map(|_| Default::default()).collect();
        for k in first..end {
            let body = &share.bodies[k];
            let (name, shape) = &shapes[body.shape as usize];
            let (message, sent) = &mut messages[cuts.owner(&boxes[k])];
            message.number(body.name);
            message.number(*name);
            message.pose(&body.pose);
            let is_known = !sent.insert(body.shape);
            message.byte(is_known.into());
            if let Some(shape) = shape.as_ref().filter(|_| !is_known) {
                result = result.and(message.shape(*name, shape));
            }
        }
        for k in first..end {
            let shape = share.bodies[k].shape as usize;
            if last_use[shape] == k {
                shapes[shape].1 = None;
            }
        }
        let messages = messages.into_iter().map(|(message, _)| message.0).enumerate();
        let messages = messages.filter(|(_, message)| !message.is_empty()).collect();
        for (sender, message) in transport.exchange(messages) {
            let taken = take_in(&message, &mut known, &mut bodies);
            result = result.and(taken.ok_or(RankError::Message { sender }));
        }
    }
    result?;
    // Neighbours in space are neighbours in memory, they and their shapes.
    let grid = cuts.grid();
    bodies.sort_by_key(|(name, _, pose): &(u64, u64, Pose)| {
        (grid.key(pose.translation().as_vec3()), *name)
    });
    let mut local = Local::default();
    let in_order = bodies.iter().filter_map(|(_, shape, _)| Some((*shape, known.remove(shape)?)));
    local.learn(in_order)?;
    for (name, shape, pose) in bodies {
        local.put((name, shape), pose, Role::Owned { inside: false })?;
    }
    Ok(local)
}

/// Nothing where the message is none.
fn take_in(
    message: &[u8],
    known: &mut HashMap<u64, Shape>,
    bodies: &mut Vec<(u64, u64, Pose)>,
) -> Option<()> {
    let mut reader = Reader(message);
    while !reader.0.is_empty() {
        let (name, shape) = reader.number().zip(reader.number())?;
        bodies.push((name, shape, reader.pose()?));
        if reader.byte()? == 0 {
            let made = reader.shape()?;
            known.entry(shape).or_insert(made);
        }
    }
    Some(())
}
