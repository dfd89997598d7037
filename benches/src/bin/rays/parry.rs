//! Parry's queries of a scene, its shapes, poses and tree made outside of any timer.

macro_rules! rival {
    ($name:ident, $parry:ident, $real:ty) => {
        pub(crate) mod $name {
            use anyhow::{Context, Result};
            use dcd_geom::Scene;
            use dcd_geom::glam::DVec3;
            use dcd_gjk::motion::RigidMotion;
            use dcd_parry::Library;
            use $parry::math::{Pose, Vector};
            use $parry::partitioning::{Bvh, BvhBuildStrategy};
            use $parry::query::cast_shapes_nonlinear;
            use $parry::query::{NonlinearRigidMotion, Ray, ShapeCastOptions, cast_shapes};
            use $parry::shape::SharedShape;

            pub(crate) struct Rival {
                tree: Bvh,
                objects: Vec<(SharedShape, Pose)>,
            }

            fn vector(v: DVec3) -> Vector {
                Vector::from(v.to_array().map(|x| x as $real))
            }

            impl Rival {
                pub(crate) fn new(scene: &Scene) -> Result<Self> {
                    let forms: Vec<SharedShape> = scene
                        .shapes()
                        .iter()
                        .map(|s| <$real as Library>::form(s).context("Parry has no such shape"))
                        .collect::<Result<_>>()?;
                    let objects: Vec<(SharedShape, Pose)> = (0..scene.len())
                        .map(|i| {
                            let form = forms[scene.shape_index(i) as usize].clone();
                            (form, <$real as Library>::pose(&scene.poses()[i]))
                        })
                        .collect();
                    let boxes = objects.iter().map(|(form, pose)| form.compute_aabb(pose));
                    let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.enumerate());
                    Ok(Self { tree, objects })
                }

                pub(crate) fn ray(&self, origin: DVec3, direction: DVec3) -> Option<(u32, f64)> {
                    let ray = Ray::new(vector(origin), vector(direction));
                    let hit = self.tree.cast_ray(&ray, <$real>::MAX, |k, most| {
                        let (form, pose) = &self.objects[k as usize];
                        form.cast_ray(pose, &ray, most, true)
                    });
                    hit.map(|(k, t)| (k, f64::from(t)))
                }

                pub(crate) fn nearest(&self, point: DVec3) -> Option<(u32, f64)> {
                    let point = vector(point);
                    let found = self.tree.project_point(point, <$real>::MAX, |k, _| {
                        let (form, pose) = &self.objects[k as usize];
                        Some(form.project_point(pose, point, true))
                    });
                    found.map(|(k, (_, projection))| {
                        (k, f64::from((projection.point - point).length()))
                    })
                }

                fn motion(&self, k: usize, motion: &RigidMotion) -> NonlinearRigidMotion {
                    NonlinearRigidMotion {
                        start: self.objects[k].1,
                        local_center: vector(motion.centre),
                        linvel: vector(motion.linear),
                        angvel: vector(motion.angular),
                    }
                }

                pub(crate) fn impact(
                    &self,
                    [i, j]: [usize; 2],
                    motions: [&RigidMotion; 2],
                ) -> Option<f64> {
                    let (a, b) = (&self.objects[i].0, &self.objects[j].0);
                    let [first, second] = [self.motion(i, motions[0]), self.motion(j, motions[1])];
                    let hit = cast_shapes_nonlinear(&first, &**a, &second, &**b, 0.0, 1.0, true);
                    hit.ok().flatten().map(|hit| f64::from(hit.time_of_impact))
                }

                pub(crate) fn cast(
                    &self,
                    [i, j]: [usize; 2],
                    motions: [&RigidMotion; 2],
                ) -> Option<f64> {
                    let ((a, at_a), (b, at_b)) = (&self.objects[i], &self.objects[j]);
                    let options = ShapeCastOptions::with_max_time_of_impact(1.0);
                    let [u, v] = motions.map(|motion| vector(motion.linear));
                    let hit = cast_shapes(at_a, u, &**a, at_b, v, &**b, options);
                    hit.ok().flatten().map(|hit| f64::from(hit.time_of_impact))
                }
            }
        }
    };
}

rival!(single, parry3d, f32);
rival!(double, parry3d_f64, f64);
