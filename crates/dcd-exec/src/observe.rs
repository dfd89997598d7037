//! Observers of when work begins and ends.

/// The stages of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// World AABBs, and whatever else depends on one object's pose alone.
    Boxes,
    /// The structure of the broad phase.
    Build,
    /// Candidate pairs.
    Pairs,
    /// Answers.
    Narrow,
}

impl Stage {
    /// All, in the order of a step.
    pub const ALL: [Self; 4] = [Self::Boxes, Self::Build, Self::Pairs, Self::Narrow];
}

/// Notified when stages and tasks begin and end, on the thread where they do. Whoever times brings the
/// clock here.
pub trait Observer: Sync {
    /// A stage begins.
    fn stage_begins(&self, _stage: Stage) {}
    /// A stage ends.
    fn stage_ends(&self, _stage: Stage) {}
    /// A section of so many tasks begins, on the thread that waits for all of them. Work of a
    /// stage outside of its sections is serial.
    fn section_begins(&self, _tasks: usize) {}
    /// The same section ends, on the same thread.
    fn section_ends(&self) {}
    /// A sort of so many items begins, on the thread that waits for it; on a pool it is parallel
    /// inside, and none of its parts is a task.
    fn sort_begins(&self, _items: usize) {}
    /// The same sort ends, on the same thread.
    fn sort_ends(&self) {}
    /// Task `task` of a section begins.
    fn task_begins(&self, _task: usize) {}
    /// The same task ends, on the same thread.
    fn task_ends(&self, _task: usize) {}
}
