//! Transforms that depend on time.
//!
//! A key is taken apart into a translation, a rotation and a stretch (Shoemake and Duff 1992, "Matrix Animation and Polar
//! Decomposition"). Between two keys, the translation and the stretch change evenly, and the rotation turns evenly by the shorter way.
//! pbrt's `AnimatedTransform` and that of Mitsuba 0.6 do the same.

use glam::{DMat3, DMat4, DQuat, DVec3, Vec3};

/// Most segments of a motion while the shutter is open.
pub const MOST_SEGMENTS: usize = 16;

/// Most that an instance's transform may amplify roundings: the largest element of |M| |M^-1| (Skeel 1979). Rotations and any
/// scales along orthogonal axes have at most 3, a shear by the factor 10 has 21.
const MOST_AMPLIFICATION: f64 = 1000.0;

/// Places of a segment at which its transform is checked.
const CHECKS: u32 = 8;

/// Volumes that a motion may give a unit cube. Kernels divide by them in single precision.
const VOLUMES: std::ops::Range<f64> = 1.0e-30..1.0e30;

/// Transform while the shutter is open.
#[derive(Debug, Clone, PartialEq)]
pub enum Course {
    /// Transform that does not change.
    Still(DMat4),
    /// Transform that changes.
    Moving(Motion),
}

/// Transform that depends on time, from 0 where the shutter opens to 1 where it closes.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Motion {
    segments: Vec<Segment>,
}

/// Part of a motion between two keys, in the numbers that kernels read.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Segment {
    /// Time at which the segment starts.
    pub start: f32,
    /// One over its duration.
    pub per_time: f32,
    /// Place of the origin at the start.
    pub origin: Vec3,
    /// Way of the origin.
    pub travel: Vec3,
    /// Unit axis of the rotation.
    pub axis: Vec3,
    /// Angle of the rotation, in whole turns.
    pub turns: f32,
    /// Matrix at the start, which the rotation turns.
    pub stretch: [Vec3; 3],
    /// Growth of that matrix.
    pub growth: [Vec3; 3],
}

/// Key, taken apart.
#[derive(Clone, Copy)]
struct Key {
    time: f64,
    translation: DVec3,
    rotation: DQuat,
    /// Symmetric matrix; its determinant is negative where the transform is a mirror.
    stretch: DMat3,
}

impl Motion {
    /// Transform of keys, pairs of a time and a matrix, while the shutter is open from `shutter[0]` to `shutter[1]`. Before the first key and
    /// after the last one, nothing changes.
    ///
    /// # Errors
    /// What is wrong with the keys, as the end of a sentence that names them.
    pub fn of_keys(keys: &[(f64, DMat4)], shutter: [f64; 2]) -> Result<Course, String> {
        let mut sorted: Vec<Key> = Vec::with_capacity(keys.len());
        for &(time, matrix) in keys {
            sorted.push(Key::new(time, &matrix).ok_or_else(|| {
                format!("the transform at the time {time} has no inverse, or shears too much for a motion")
            })?);
        }
        sorted.sort_by(|a, b| a.time.total_cmp(&b.time));
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].time == pair[1].time) {
            return Err(format!("two keys have the time {}; give each a time of its own", pair[0].time));
        }
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].is_mirrored() != pair[1].is_mirrored()) {
            return Err(format!(
                "the transform is a mirror at one of the times {} and {}, so that it flattens everything between them",
                pair[0].time, pair[1].time
            ));
        }
        let Some(first) = sorted.first() else { return Err("an animation needs a key".to_owned()) };
        let [open, close] = shutter;
        let is_still = keys.iter().all(|(_, matrix)| *matrix == keys[0].1);
        if is_still || open >= close || sorted.last().is_some_and(|last| last.time <= open) || first.time >= close {
            let exact = |&&(time, _): &&(f64, DMat4)| is_still || time == open;
            let still = keys.iter().find(exact).map_or_else(|| at(&sorted, open).matrix(), |(_, matrix)| *matrix);
            return Ok(Course::Still(still));
        }
        let within = sorted.iter().map(|key| key.time).filter(|&time| open < time && time < close);
        let times: Vec<f64> = [open].into_iter().chain(within).chain([close]).collect();
        if times.len() > MOST_SEGMENTS + 1 {
            let most = MOST_SEGMENTS - 1;
            return Err(format!("more than {most} keys lie in the time in which the shutter is open; leave some out"));
        }
        let part = |time: f64| ((time - open) / (close - open), at(&sorted, time));
        let segments = times.windows(2).map(|pair| Segment::new(part(pair[0]), part(pair[1]))).collect();
        let motion = Self { segments };
        match motion.is_usable() {
            true => Ok(Course::Moving(motion)),
            false => Err("the transform leaves the range of single-precision numbers on its way".to_owned()),
        }
    }

    /// The segments, in the order of time.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Transform at a time, as the kernels compute it but for rounding.
    pub fn at(&self, time: f64) -> DMat4 {
        let after = self.segments.iter().skip(1).take_while(|segment| f64::from(segment.start) <= time).count();
        let (matrix, origin) = self.segments[after].at(time);
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.extend(0.0));
        DMat4::from_cols(x, y, z, origin.extend(1.0))
    }

    /// Boxes, as (minimum, maximum), that together hold a box of the group's space at all times. Each segment has `steps` of them.
    pub fn swept(&self, of_group: (Vec3, Vec3), steps: u32) -> impl Iterator<Item = (DVec3, DVec3)> {
        self.segments.iter().flat_map(move |segment| segment.swept(of_group, steps))
    }

    /// Whether an instance can have the transform at all times.
    fn is_usable(&self) -> bool {
        let mut times = self.segments.iter().flat_map(|segment| {
            let duration = 1.0 / f64::from(segment.per_time);
            (0..=CHECKS).map(move |i| f64::from(segment.start) + duration * f64::from(i) / f64::from(CHECKS))
        });
        times.all(|time| {
            let transform = self.at(time);
            let matrix = DMat3::from_mat4(transform);
            let is_finite = transform.w_axis.as_vec4().is_finite();
            is_finite && usable_inverse(&matrix).is_some() && VOLUMES.contains(&matrix.determinant().abs())
        })
    }
}

impl Segment {
    fn new((start, from): (f64, Key), (end, to): (f64, Key)) -> Self {
        let (axis, angle) = turn(from.rotation, to.rotation);
        let columns = |matrix: DMat3| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.as_vec3());
        let rotation = DMat3::from_quat(from.rotation);
        Self {
            start: start as f32,
            per_time: (1.0 / (end - start)) as f32,
            origin: from.translation.as_vec3(),
            travel: (to.translation - from.translation).as_vec3(),
            axis: axis.as_vec3(),
            turns: (angle / std::f64::consts::TAU) as f32,
            stretch: columns(rotation * from.stretch),
            growth: columns(rotation * (to.stretch - from.stretch)),
        }
    }

    /// Matrix and place of the origin at a time.
    fn at(&self, time: f64) -> (DMat3, DVec3) {
        let s = (time - f64::from(self.start)) * f64::from(self.per_time);
        let columns = |columns: [Vec3; 3]| {
            let [x, y, z] = columns.map(Vec3::as_dvec3);
            DMat3::from_cols(x, y, z)
        };
        let angle = s * std::f64::consts::TAU * f64::from(self.turns);
        let rotation = DMat3::from_axis_angle(self.axis.as_dvec3().normalize_or(DVec3::Z), angle);
        let matrix = rotation * (columns(self.stretch) + s * columns(self.growth));
        (matrix, self.origin.as_dvec3() + s * self.travel.as_dvec3())
    }

    /// Boxes that hold a box of the group's space, each for a part of the segment. A point's way leaves the line between two of its places by
    /// at most an eighth of the squared time between them, times its largest acceleration.
    fn swept(&self, (min, max): (Vec3, Vec3), steps: u32) -> impl Iterator<Item = (DVec3, DVec3)> {
        let corners: Vec<DVec3> = (0..8)
            .map(|i| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), max, min).as_dvec3())
            .collect();
        let angle = std::f64::consts::TAU * f64::from(self.turns).abs();
        let [stretch, growth] = [self.stretch, self.growth].map(|columns| {
            let [x, y, z] = columns.map(Vec3::as_dvec3);
            DMat3::from_cols(x, y, z)
        });
        let reach = |corner: &DVec3| (stretch * *corner).length().max(((stretch + growth) * *corner).length());
        let largest = |of: &dyn Fn(&DVec3) -> f64| corners.iter().map(of).fold(0.0, f64::max);
        let acceleration =
            angle * angle * largest(&reach) + 2.0 * angle * largest(&|corner| (growth * *corner).length());
        let (start, duration) = (f64::from(self.start), 1.0 / f64::from(self.per_time));
        let margin = acceleration / (8.0 * f64::from(steps).powi(2));
        let own = *self;
        let placed = move |i: u32| {
            let (matrix, origin) = own.at(start + duration * f64::from(i) / f64::from(steps));
            let places = corners.iter().map(|corner| origin + matrix * *corner);
            places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
        };
        (0..steps).map(move |i| {
            let ((a, b), (c, d)) = (placed(i), placed(i + 1));
            (a.min(c) - margin, b.max(d) + margin)
        })
    }
}

impl Key {
    /// The key, taken apart; `None` where its transform has no inverse.
    fn new(time: f64, matrix: &DMat4) -> Option<Self> {
        let linear = DMat3::from_mat4(*matrix);
        usable_inverse(&linear)?;
        let (orthogonal, mut stretch) = polar(&linear)?;
        let sign = orthogonal.determinant().signum();
        stretch *= sign;
        Some(Self {
            time,
            translation: matrix.w_axis.truncate(),
            rotation: DQuat::from_mat3(&(orthogonal * sign)).normalize(),
            stretch,
        })
    }

    fn is_mirrored(&self) -> bool {
        self.stretch.determinant() < 0.0
    }

    fn matrix(&self) -> DMat4 {
        DMat4::from_translation(self.translation) * DMat4::from_mat3(DMat3::from_quat(self.rotation) * self.stretch)
    }
}

/// Inverse of a transform of directions; `None` where the transform is no number, flattens, or shears so much that roundings would show.
pub(super) fn usable_inverse(matrix: &DMat3) -> Option<DMat3> {
    let inverse = matrix.inverse();
    let amplification = matrix.abs() * inverse.abs();
    let largest = amplification.to_cols_array().into_iter().fold(0.0, f64::max);
    let fits = |matrix: &DMat3| matrix.to_cols_array().iter().all(|x| (*x as f32).is_finite());
    // A comparison with NaN is false, but `max` drops it.
    let is_usable = fits(&inverse) && fits(matrix) && largest <= MOST_AMPLIFICATION && amplification.is_finite();
    is_usable.then_some(inverse)
}

/// Whether the matrix scales evenly, to the precision of printed scene files, so that spheres stay spheres.
pub(super) fn is_even(matrix: &DMat3) -> bool {
    let square = matrix.transpose() * *matrix;
    let scale = square.x_axis.x;
    (square - DMat3::from_diagonal(DVec3::splat(scale))).to_cols_array().iter().all(|x| x.abs() <= 2.0e-3 * scale)
}

/// Orthogonal factor of a matrix, and the symmetric factor that is applied before it (Higham 1986).
fn polar(matrix: &DMat3) -> Option<(DMat3, DMat3)> {
    let mut orthogonal = *matrix;
    for _ in 0..100 {
        let next = 0.5 * (orthogonal + orthogonal.inverse().transpose());
        let change = (next - orthogonal).to_cols_array().iter().map(|x| x.abs()).fold(0.0, f64::max);
        orthogonal = next;
        if change < 1.0e-15 {
            break;
        }
    }
    let stretch = orthogonal.transpose() * *matrix;
    let symmetric = 0.5 * (stretch + stretch.transpose());
    (orthogonal.is_finite() && symmetric.is_finite()).then_some((orthogonal, symmetric))
}

/// Axis and angle of the turn from one rotation to another, by the shorter way.
fn turn(from: DQuat, to: DQuat) -> (DVec3, f64) {
    let relative = to * from.conjugate();
    let relative = if relative.w < 0.0 { -relative } else { relative };
    let (sine, cosine) = (relative.xyz().length(), relative.w);
    let axis = relative.xyz().try_normalize().unwrap_or(DVec3::Z);
    (axis, 2.0 * sine.atan2(cosine))
}

/// Transform of sorted keys at a time.
fn at(keys: &[Key], time: f64) -> Key {
    let after = keys.partition_point(|key| key.time <= time);
    let (Some(from), Some(to)) = (keys.get(after.wrapping_sub(1)), keys.get(after)) else {
        let nearest = keys[after.min(keys.len() - 1)];
        return Key { time, ..nearest };
    };
    let s = (time - from.time) / (to.time - from.time);
    let (axis, angle) = turn(from.rotation, to.rotation);
    Key {
        time,
        translation: from.translation.lerp(to.translation, s),
        rotation: DQuat::from_axis_angle(axis, s * angle) * from.rotation,
        stretch: from.stretch * (1.0 - s) + to.stretch * s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving(keys: &[(f64, DMat4)], shutter: [f64; 2]) -> Motion {
        match Motion::of_keys(keys, shutter) {
            Ok(Course::Moving(motion)) => motion,
            other => panic!("{other:?}"),
        }
    }

    fn near(a: DMat4, b: DMat4) {
        assert!(a.abs_diff_eq(b, 2.0e-6), "{a}, not {b}");
    }

    fn keys() -> [(f64, DMat4); 3] {
        let stretched = DMat4::from_rotation_x(0.3) * DMat4::from_scale(DVec3::new(1.0, 2.0, 0.5));
        [
            (0.0, DMat4::IDENTITY),
            (1.0, DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)) * DMat4::from_rotation_y(1.2) * stretched),
            (3.0, DMat4::from_translation(DVec3::X) * DMat4::from_rotation_z(-2.5)),
        ]
    }

    #[test]
    fn keys_are_met_and_the_way_between_them_is_even() {
        let keys = keys();
        let whole = moving(&keys, [0.0, 3.0]);
        assert_eq!(whole.segments().len(), 2);
        keys.iter().for_each(|(time, matrix)| near(whole.at(time / 3.0), *matrix));
        // A part of the time gives the same way.
        let part = moving(&keys, [0.4, 2.2]);
        (0..=9).map(|i| f64::from(i) / 9.0).for_each(|s| near(part.at(s), whole.at((0.4 + 1.8 * s) / 3.0)));
        // Turns go by the shorter way, and evenly.
        let turned = |angle: f64| DMat4::from_rotation_z(angle.to_radians());
        let motion = moving(&[(0.0, turned(10.0)), (1.0, turned(310.0))], [0.0, 1.0]);
        near(motion.at(0.25), turned(-5.0));
        // Mirrors stay mirrors.
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let motion = moving(&[(0.0, mirror), (1.0, turned(90.0) * mirror)], [0.0, 1.0]);
        near(motion.at(0.5), turned(45.0) * mirror);
    }

    #[test]
    fn what_does_not_change_is_still() {
        let keys = keys();
        let still = |keys: &[(f64, DMat4)], shutter| match Motion::of_keys(keys, shutter) {
            Ok(Course::Still(matrix)) => matrix,
            other => panic!("{other:?}"),
        };
        assert_eq!(still(&keys, [1.0, 1.0]), keys[1].1);
        near(still(&keys, [0.5, 0.5]), moving(&keys, [0.0, 1.0]).at(0.5));
        near(still(&keys, [3.0, 4.0]), keys[2].1);
        near(still(&keys, [-2.0, 0.0]), keys[0].1);
        assert_eq!(still(&[keys[1], (2.0, keys[1].1)], [0.0, 3.0]), keys[1].1);
        assert_eq!(still(&keys[1..2], [0.0, 3.0]), keys[1].1);
    }

    #[test]
    fn impossible_motions_are_refused() {
        let refused = |keys: &[(f64, DMat4)], words: &str| {
            let message = Motion::of_keys(keys, [0.0, 1.0]).unwrap_err();
            assert!(message.contains(words), "{message}");
        };
        let [first, second, _] = keys();
        refused(&[], "needs a key");
        refused(&[first, (0.0, second.1)], "two keys have the time 0");
        refused(
            &[first, (1.0, DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)))],
            "is a mirror at one of the times 0 and 1",
        );
        refused(&[first, (1.0, DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0)))], "at the time 1 has no inverse");
        let many: Vec<_> =
            (0..=16).map(|i| (f64::from(i) / 16.0, DMat4::from_rotation_z(0.1 * f64::from(i)))).collect();
        assert_eq!(moving(&many, [0.0, 1.0]).segments().len(), 16);
        let more: Vec<_> = many.iter().copied().chain([(0.01, DMat4::IDENTITY)]).collect();
        refused(&more, "more than 15 keys");
    }

    #[test]
    fn swept_boxes_hold_every_point_at_every_time() {
        let motion = moving(&keys(), [0.0, 3.0]);
        let of_group = (Vec3::new(-0.5, 0.2, -1.0), Vec3::new(0.7, 0.9, 2.0));
        for steps in [1, 4, 32] {
            let boxes: Vec<_> = motion.swept(of_group, steps).collect();
            assert_eq!(boxes.len(), 2 * steps as usize);
            for i in 0..1000 {
                let time = f64::from(i) / 999.0;
                let corner = |axis: usize| if i >> axis & 1 == 0 { of_group.0[axis] } else { of_group.1[axis] };
                let point = motion.at(time).transform_point3(DVec3::from([0, 1, 2].map(|axis| corner(axis).into())));
                let segment = if time * 3.0 < 1.0 { 0 } else { steps as usize };
                let holds = |(low, high): &(DVec3, DVec3)| point.cmpge(*low).all() && point.cmple(*high).all();
                assert!(boxes[segment..segment + steps as usize].iter().any(holds), "{steps} {time}");
            }
        }
        // Many boxes are hardly larger than what they must hold.
        let steps = 32;
        for (at, (low, high)) in motion.swept(of_group, steps).enumerate() {
            let (from, length) = if at < steps as usize { (0.0, 1.0 / 3.0) } else { (1.0 / 3.0, 2.0 / 3.0) };
            let times = (0..=16)
                .map(|i| from + length * ((at % steps as usize) as f64 + f64::from(i) / 16.0) / f64::from(steps));
            let corners = times.flat_map(|time| {
                let transform = motion.at(time.min(1.0));
                (0..8).map(move |i: u32| {
                    let corner = |axis: usize| if i >> axis & 1 == 0 { of_group.0[axis] } else { of_group.1[axis] };
                    transform.transform_point3(DVec3::from([0, 1, 2].map(|axis| corner(axis).into())))
                })
            });
            let needed =
                corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
            let (given, needed) = ((high - low).length(), (needed.1 - needed.0).length());
            assert!(given < 1.05 * needed, "{at}: {given} for {needed}");
        }
    }
}
