//! Shapes that are posed together.

use dcd_geom::{Filter, SceneError, Shape};

/// Shapes that are posed together, each by a pose of its own: a robot's links, a compound's parts,
/// or one shape alone.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// use dcd_pipeline::{LinkSet, StaticWorld};
/// let shelf = Scene::one_each(vec![Shape::cuboid(DVec3::new(1.0, 1.0, 0.1))?], vec![Pose::IDENTITY])?;
/// let world = StaticWorld::new(&shelf, Overlap::default(), Par::Pool)?;
/// // Three links of a chain; neighbours always touch.
/// let chain = LinkSet::new(vec![Shape::sphere(0.2)?; 3]).against_itself(&[(0, 1), (1, 2)])?;
/// let mut checker = world.checker(chain)?;
/// let folded = [1.0, 1.3, 1.1].map(|z| Pose::from_translation(DVec3::Z * z));
/// let folded = folded.into_iter().collect::<Result<Vec<_>, _>>()?;
/// assert!(checker.first(&folded, Par::Serial)?[0].is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LinkSet {
    pub(super) shapes: Vec<Shape>,
    pub(super) filters: Vec<Filter>,
    /// The pairs of links (k, l), k < l, that are tested too, by l.
    pub(super) self_pairs: Vec<(u32, u32)>,
}

impl LinkSet {
    /// Links that are tested against the world, not against each other.
    pub fn new(shapes: Vec<Shape>) -> Self {
        let filters = vec![Filter::ALL; shapes.len()];
        Self { shapes, filters, self_pairs: Vec::new() }
    }

    /// Sets which obstacles a link may touch, by the groups that both are in.
    ///
    /// # Errors
    /// There is no such link.
    pub fn with_filter(mut self, link: usize, filter: Filter) -> Result<Self, SceneError> {
        let links = self.shapes.len();
        let slot = self.filters.get_mut(link);
        *slot.ok_or(SceneError::NoSuchObject { object: link, objects: links })? = filter;
        Ok(self)
    }

    /// Also tests the links against each other (self-collision), except for these pairs, in either order: adjacent
    /// links, which always touch. The links' filters do not apply here.
    ///
    /// # Errors
    /// A pair names a link that is not there.
    pub fn against_itself(mut self, except: &[(usize, usize)]) -> Result<Self, SceneError> {
        let links = self.shapes.len();
        if let Some(&(a, b)) = except.iter().find(|(a, b)| a.max(b) >= &links) {
            return Err(SceneError::NoSuchObject { object: a.max(b), objects: links });
        }
        let mut except: Vec<_> = except.iter().map(|&(a, b)| (a.min(b), a.max(b))).collect();
        except.sort_unstable();
        self.self_pairs.clear();
        for l in 0..links {
            let below = (0..l).filter(|&k| except.binary_search(&(k, l)).is_err());
            self.self_pairs.extend(below.map(|k| (k as u32, l as u32)));
        }
        Ok(self)
    }

    /// How many links there are.
    pub fn len(&self) -> usize {
        self.shapes.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }
}
