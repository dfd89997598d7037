//! What the grid tells, beside the plainest judge.

use super::*;
use dcd_geom::glam::{Vec3, Vec3Swizzles};
use dcd_geom::lanes::{IndexRow, Kernel, Lanes, Path, dispatch_on};
use dcd_geom::{Bound, Bounds, Pose, Shape};

fn outline(centre: Vec3, half: Vec3) -> Outline {
    let aabb = Aabb { min: centre - half, max: centre + half };
    let ball = LooseBall { centre, radius: half.length() * 0.8 };
    Outline { aabb, ball, inner: SnugBall { centre, radius: half.min_element() } }
}

/// Centres on a spiral of that size, and radii of some of its hundredths.
fn balls(count: usize, size: f32) -> Vec<LooseBall> {
    let ball = |k: usize| {
        let t = k as f32;
        let centre = Vec3::new(t.sin(), (t * 0.73).cos(), (t * 0.37).sin() * 0.6) * size;
        LooseBall { centre, radius: size * (1.0 + t % 7.0) * 0.02 }
    };
    (0..count).map(ball).collect()
}

fn outlines(count: usize, size: f32) -> Vec<Outline> {
    let half = Vec3::new(1.0, 0.6, 0.3);
    let all = balls(count, size).into_iter();
    all.map(|LooseBall { centre, radius }| outline(-centre.zxy() * 0.9, half * radius)).collect()
}

/// By how much a ball ends short of both, metres, in f64: negative where it reaches both.
fn gap(outline: &Outline, ball: &LooseBall) -> f64 {
    let Outline { aabb, ball: other, .. } = outline;
    let (centre, radius) = (ball.centre.as_dvec3(), f64::from(ball.radius));
    let nearest = centre.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3());
    let between = centre.distance(other.centre.as_dvec3()) - f64::from(other.radius);
    centre.distance(nearest).max(between) - radius
}

/// Finds the cells of all balls.
struct Cells<'a>(&'a Vicinity, &'a [BallRow], &'a mut Vec<IndexRow>);

impl Kernel for Cells<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self(vicinity, balls, cells) = self;
        cells.resize(balls.len(), IndexRow::default());
        for (balls, cells) in balls.iter().zip(cells) {
            l.store_u(vicinity.cells(l, balls), cells);
        }
    }
}

fn rows(balls: &[LooseBall]) -> Vec<BallRow> {
    let row = |balls: &[LooseBall]| {
        let mut row = BallRow::default();
        for (k, ball) in balls.iter().enumerate() {
            for (axis, x) in ball.centre.to_array().into_iter().enumerate() {
                row.centre.0[axis].0[k] = x;
            }
            row.radius.0[k] = ball.radius;
        }
        row
    };
    balls.chunks(WIDTH).map(row).collect()
}

/// Notes the balls as [`Vicinity::look_up`] does.
fn note(vicinity: &Vicinity, balls: &[LooseBall], path: Path, reached: &mut Reached) {
    reached.clear();
    dispatch_on(path, Cells(vicinity, &rows(balls), &mut reached.cells));
    vicinity.note(0..balls.len(), &[], reached);
}

fn reached(vicinity: &Vicinity, balls: &[LooseBall]) -> Vec<Vec<u32>> {
    let told = |path| {
        let mut reached = Reached::default();
        // The second time in memory that was used before, by more.
        for balls in [&[balls, balls].concat(), balls] {
            note(vicinity, balls, path, &mut reached);
            vicinity.reach(&rows(balls), &mut reached);
        }
        let mut all = vec![Vec::new(); balls.len()];
        for (ball, [start, end]) in reached.spans() {
            all[ball] = reached.numbers()[start as usize..end as usize].to_vec();
        }
        all
    };
    let all = told(Path::Portable);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(told(path), all, "{path:?}");
    }
    all
}

/// How many balls it knew nothing of.
fn must_agree_with_the_plainest_judge(outlines: &[Outline], balls: &[LooseBall]) -> usize {
    let largest = balls.iter().map(|ball| ball.radius).fold(0.0, f32::max);
    let vicinity = Vicinity::new(outlines, largest);
    let mut unknown = 0;
    for (ball, told) in balls.iter().zip(reached(&vicinity, balls)) {
        if told == [vicinity.unknown()] {
            unknown += 1;
            continue;
        }
        assert!(told.is_sorted());
        for (number, outline) in (0..).zip(outlines) {
            // What balls allow for is far more than this.
            let (gap, rounding) = (gap(outline, ball), 1e-6 * f64::from(largest));
            assert!(told.contains(&number) || gap > -rounding, "{number} is lost: {gap}");
            assert!(!told.contains(&number) || gap <= rounding, "{number} is told: {gap}");
        }
    }
    unknown
}

#[test]
fn all_that_a_ball_reaches_is_told_and_nothing_else_at_every_size() {
    for size in [1e-9, 1e-3, 1.0, 1e6, 1e15] {
        for count in [0, 1, 30, 500] {
            let balls = balls(400, size);
            let unknown = must_agree_with_the_plainest_judge(&outlines(count, size), &balls);
            assert!(unknown < 40, "{unknown} of 400 are not known");
        }
    }
}

#[test]
fn far_from_the_origin_where_a_cell_is_few_steps_of_f32_all_is_told_too() {
    for far in [1e3, 1e5, 3e6] {
        let shift = Vec3::new(far, -0.7 * far, 0.3 * far);
        let mut balls = balls(400, 1.0);
        balls.iter_mut().for_each(|ball| ball.centre += shift);
        let shifted = |o: &Outline| outline(o.ball.centre + shift, Vec3::splat(o.ball.radius));
        let outlines: Vec<Outline> = outlines(200, 1.0).iter().map(shifted).collect();
        must_agree_with_the_plainest_judge(&outlines, &balls);
    }
}

#[test]
fn what_has_no_end_or_lies_far_off_is_reached_too() {
    let mut outlines = outlines(40, 1.0);
    outlines.push(Outline::EVERYTHING);
    let floor = Aabb { max: Vec3::new(1e37, 1e37, -0.3), ..Aabb::EVERYTHING };
    outlines.push(Outline { aabb: floor, ..Outline::EVERYTHING });
    must_agree_with_the_plainest_judge(&outlines, &balls(400, 1.0));
    outlines.push(outline(Vec3::splat(1e9), Vec3::ONE));
    must_agree_with_the_plainest_judge(&outlines, &balls(400, 1.0));
    let one_point = vec![outline(Vec3::ZERO, Vec3::ZERO); 3];
    must_agree_with_the_plainest_judge(
        &one_point,
        &[LooseBall { radius: 0.0, ..balls(1, 0.0)[0] }],
    );
    must_agree_with_the_plainest_judge(&one_point, &balls(50, 1e-3));
}

#[test]
fn of_a_crowd_and_of_a_larger_ball_than_foreseen_nothing_is_known() {
    let crowd = vec![outline(Vec3::ZERO, Vec3::ONE); LONGEST + 1];
    let vicinity = Vicinity::new(&crowd, 0.5);
    let at = |x: f32, radius| LooseBall { centre: Vec3::X * x, radius };
    let asked = [at(0.0, 0.5), at(9.0, 0.5), at(9.0, 0.6), LooseBall::EVERYTHING];
    let unknown = vec![vicinity.unknown()];
    assert_eq!(reached(&vicinity, &asked), [unknown.clone(), vec![], unknown.clone(), unknown]);
    let vicinity = Vicinity::new(&crowd[..LONGEST], 0.5);
    assert_eq!(reached(&vicinity, &asked[..1]), [(0..LONGEST as u32).collect::<Vec<_>>()]);
}

#[test]
fn pairs_are_those_of_the_boxes_that_overlap_and_are_kept() {
    let outlines = outlines(60, 1.0);
    let vicinity = Vicinity::new(&outlines, 0.1);
    let numbers: Vec<u32> = (0..60).collect();
    let asked = Aabb { min: Vec3::splat(-0.7), max: Vec3::splat(0.4) };
    let mut pairs = vec![Pair::new(1, 2)];
    vicinity.append_pairs(
        (99, &asked),
        &numbers,
        |i, j| !i.is_multiple_of(3) && j == 99,
        &mut pairs,
    );
    let overlaps = |i: &u32| outlines[*i as usize].aabb.overlaps(&asked) && !i.is_multiple_of(3);
    let due: Vec<Pair> = numbers.into_iter().filter(overlaps).map(|i| Pair::new(i, 99)).collect();
    assert!(due.len() > 3);
    assert_eq!(pairs[1..], due);
}

#[test]
fn the_likeliest_is_told_with_what_it_is_short_of_and_most_contacts_are_its() {
    let mut outlines = outlines(200, 1.0);
    outlines.iter_mut().for_each(|outline| outline.inner.radius *= 4.0);
    let balls = balls(2000, 1.0);
    let vicinity = Vicinity::new(&outlines, 0.2);
    let mut reached = Reached::default();
    note(&vicinity, &balls, Path::best(), &mut reached);
    let inner = |ball: &LooseBall| SnugBall { centre: ball.centre, radius: ball.radius * 0.7 };
    let mut noted = vec![(vicinity.unknown(), f32::INFINITY); balls.len()];
    reached.sift(0, 1, |ball, listing| {
        assert_eq!(ball, listing.ball as usize);
        noted[ball] = (listing.likeliest, vicinity.short_of(listing, &inner(&balls[ball])));
        false
    });
    let (mut touching, mut told) = (0, 0);
    for (ball, &(likeliest, short_of)) in balls.iter().zip(&noted) {
        let due = |outline: &Outline| outline.inner.short_of(&inner(ball));
        let least = outlines.iter().map(due).fold(f32::INFINITY, f32::min);
        match outlines.get(likeliest as usize) {
            Some(outline) => assert_eq!(short_of, due(outline)),
            None => assert!(likeliest == vicinity.unknown() && short_of == f32::INFINITY),
        }
        touching += usize::from(least <= 0.0);
        told += usize::from(short_of <= 0.0);
    }
    assert!(touching > 100 && 5 * told > 4 * touching, "{told} of {touching}");
}

#[test]
fn posed_bounds_are_looked_up_by_their_balls_row_after_row() {
    let outlines = outlines(60, 1.0);
    let vicinity = Vicinity::new(&outlines, 0.3);
    let shapes = [0.1, 0.2, 0.05].map(|radius| Shape::sphere(radius).unwrap());
    let bounds = Bounds::new(shapes.iter().map(Bound::of).collect());
    let centres = balls(100, 1.0).into_iter().map(|ball| ball.centre.as_dvec3());
    let poses: Vec<Pose> = centres.map(|t| Pose::from_translation(t).unwrap()).collect();
    let mut found = vec![BallRow::default(); poses.len().div_ceil(WIDTH)];
    let mut reached = Reached::default();
    let posed = Posed { bounds: &bounds, poses: &poses };
    // Rows that are not there are none.
    for rows in [0..3, 3..4, 4..9, 8..9] {
        vicinity.look_up(posed, rows, &mut found, &mut reached);
    }
    let mut due = Vec::new();
    for (k, (pose, shape)) in poses.iter().zip(shapes.iter().cycle()).enumerate() {
        let (ball, plain) = (found[k / WIDTH].get(k % WIDTH), Bound::of(shape).unwrap().ball(pose));
        assert!(ball.centre.distance(plain.centre) < 1e-6, "{k}: {ball:?}, {plain:?}");
        assert!((ball.radius - plain.radius).abs() < 1e-6, "{k}: {ball:?}, {plain:?}");
        due.push(ball);
    }
    let mut again = Reached::default();
    note(&vicinity, &due, Path::best(), &mut again);
    assert!(reached.noted() > 20 && reached.noted() == again.noted());
    vicinity.reach(&found, &mut reached);
    vicinity.reach(&rows(&due), &mut again);
    assert!(reached.spans().eq(again.spans()) && reached.numbers() == again.numbers());
}

#[test]
fn a_run_that_has_ended_is_told_no_more_and_none_of_it_is_noted() {
    let crowd = [outline(Vec3::ZERO, Vec3::ONE)];
    let vicinity = Vicinity::new(&crowd, 0.5);
    // Near it are all but the 3rd and all of the run that is third.
    let far = |k: usize| k == 3 || (8..12).contains(&k);
    let ball =
        |k: usize| LooseBall { centre: Vec3::X * [0.0, 9.0][usize::from(far(k))], radius: 0.5 };
    let balls: Vec<LooseBall> = (0..18).map(ball).collect();
    let mut reached = Reached::default();
    note(&vicinity, &balls, Path::best(), &mut reached);
    let mut told = Vec::new();
    reached.sift(2, 4, |run, listing| {
        told.push((run, listing.ball));
        listing.ball == 5 || listing.ball == 17
    });
    assert_eq!(told, [2, 4, 5, 12, 13, 14, 15, 16, 17].map(|ball| (ball as usize / 4, ball)));
    vicinity.reach(&rows(&balls), &mut reached);
    let left: Vec<usize> = reached.spans().map(|(ball, _)| ball).collect();
    assert_eq!(left, [0, 1, 2, 12, 13, 14, 15]);
}
