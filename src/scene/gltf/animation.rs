//! Animations: the pose of a model's nodes at a moment.

use glam::DVec3;
use gltf::Accessor;
use serde_json::Value as Json;

use super::asset::Asset;
use super::pose::{Pose, quaternion};
use crate::Result;

/// Pose at the time that the user has chosen, of the first animation. Says what is not shown.
pub(super) fn pose(asset: &Asset, time: Option<f64>) -> Result<Pose> {
    let Some(first) = asset.animations.first() else {
        if time.is_some() {
            asset.warn("it has no animation, so --scene-time changes nothing");
        }
        return Ok(Pose::default());
    };
    let Some(time) = time else {
        asset.warn(
            "its animations are not played; nodes stand where the file puts them (--scene-time SECONDS chooses a moment)",
        );
        return Ok(Pose::default());
    };
    if asset.animations.len() > 1 {
        asset.warn(format!("it has {} animations, of which the first is played", asset.animations.len()));
    }
    at(asset, first, time)
}

/// Pose at a time in seconds. Before the first key of a channel and after the last one, it stays.
fn at(asset: &Asset, animation: &Json, time: f64) -> Result<Pose> {
    let mut pose = Pose::default();
    let list = |name: &str| animation.get(name).and_then(Json::as_array).map_or(&[][..], Vec::as_slice);
    let samplers = list("samplers");
    for (index, channel) in list("channels").iter().enumerate() {
        let fault = |what: &str| asset.error(format!("channel {index} of its animation {what}"));
        let Some((node, path)) = target(channel) else {
            asset.warn("its animation changes other things than nodes, which stay as they are");
            continue;
        };
        let width = match path {
            "translation" | "scale" => 3,
            "rotation" => 4,
            "weights" => 1,
            _ => continue,
        };
        let sampler = channel.get("sampler").and_then(Json::as_u64).and_then(|at| samplers.get(at as usize));
        let sampler = sampler.ok_or_else(|| fault("has no sampler"))?;
        let accessor = |name: &str| {
            let index = sampler.get(name).and_then(Json::as_u64);
            let found = index.and_then(|index| asset.document.accessors().nth(index as usize));
            found.ok_or_else(|| fault(&format!("lacks the accessor of its `{name}`")))
        };
        let times = flat(asset, &accessor("input")?, 1)?;
        let values = flat(asset, &accessor("output")?, width)?;
        let mode = Mode::named(sampler.get("interpolation").and_then(Json::as_str).unwrap_or("LINEAR"));
        let curve = Curve { times, values, mode, is_rotation: path == "rotation" };
        let value = curve.at(time, (path != "weights").then_some(width)).map_err(|what| fault(&what))?;
        let moved = pose.moved(node);
        let vector = |value: &[f64]| Some(DVec3::new(value[0], value[1], value[2]));
        match path {
            "translation" => moved.translation = vector(&value),
            "scale" => moved.scale = vector(&value),
            "rotation" => moved.rotation = Some(quaternion(&value)),
            _ => moved.weights = Some(value),
        }
    }
    Ok(pose)
}

/// Node that a channel moves, and which part of it; `None` for other things.
fn target(channel: &Json) -> Option<(usize, &str)> {
    let target = channel.get("target")?;
    let path = target.get("path")?.as_str()?;
    if path != "pointer" {
        return Some((target.get("node")?.as_u64()? as usize, path));
    }
    let pointer = target.get("extensions")?.get("KHR_animation_pointer")?.get("pointer")?.as_str()?;
    let (node, path) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    ["translation", "rotation", "scale", "weights"].contains(&path).then_some(())?;
    Some((node.parse().ok()?, path))
}

fn flat(asset: &Asset, accessor: &Accessor, width: usize) -> Result<Vec<f64>> {
    Ok(match width {
        1 => asset.elements::<1>(accessor)?.into_flattened(),
        3 => asset.elements::<3>(accessor)?.into_flattened(),
        _ => asset.elements::<4>(accessor)?.into_flattened(),
    })
}

/// Interpolations between keys.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Linear,
    Step,
    /// Hermite splines: each key has an incoming tangent, a value and an outgoing tangent.
    Cubic,
}

impl Mode {
    fn named(name: &str) -> Self {
        match name {
            "STEP" => Self::Step,
            "CUBICSPLINE" => Self::Cubic,
            _ => Self::Linear,
        }
    }
}

/// Values over time.
struct Curve {
    times: Vec<f64>,
    values: Vec<f64>,
    mode: Mode,
    is_rotation: bool,
}

impl Curve {
    /// Value at a time, of `width` numbers, or of as many as each key has. The error says what is wrong with the curve.
    fn at(&self, time: f64, width: Option<usize>) -> Result<Vec<f64>, String> {
        let (keys, parts) = (self.times.len(), if self.mode == Mode::Cubic { 3 } else { 1 });
        if keys == 0 {
            return Err("has no keys".to_owned());
        }
        if !self.times.is_sorted_by(|a, b| a < b) {
            return Err("has times that do not increase".to_owned());
        }
        let width = width.unwrap_or(self.values.len() / (keys * parts));
        if width == 0 || self.values.len() != keys * parts * width {
            return Err(format!("has {} numbers for {keys} keys", self.values.len()));
        }
        let part = |key: usize, part: usize| &self.values[(key * parts + part) * width..][..width];
        let value = |key: usize| part(key, parts / 2);
        let before = self.times.partition_point(|&own| own <= time);
        if before == 0 || before == keys || self.mode == Mode::Step {
            return Ok(value(before.saturating_sub(1)).to_vec());
        }
        let (first, second) = (before - 1, before);
        let step = self.times[second] - self.times[first];
        let u = (time - self.times[first]) / step;
        if self.mode == Mode::Cubic {
            let hermite = |at: usize| {
                let (u2, u3) = (u * u, u * u * u);
                (2.0 * u3 - 3.0 * u2 + 1.0) * value(first)[at]
                    + step * (u3 - 2.0 * u2 + u) * part(first, 2)[at]
                    + (3.0 * u2 - 2.0 * u3) * value(second)[at]
                    + step * (u3 - u2) * part(second, 0)[at]
            };
            return Ok((0..width).map(hermite).collect());
        }
        if self.is_rotation {
            return Ok(quaternion(value(first)).slerp(quaternion(value(second)), u).to_array().to_vec());
        }
        Ok((0..width).map(|at| value(first)[at] + u * (value(second)[at] - value(first)[at])).collect())
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    fn curve(times: &[f64], values: &[f64], mode: Mode) -> Curve {
        Curve { times: times.to_vec(), values: values.to_vec(), mode, is_rotation: false }
    }

    #[test]
    fn values_lie_between_their_keys() {
        let linear = curve(&[1.0, 3.0, 4.0], &[0.0, 10.0, 2.0, 20.0, 5.0, 0.0], Mode::Linear);
        for (time, right) in [(0.0, [0.0, 10.0]), (1.5, [0.5, 12.5]), (3.0, [2.0, 20.0]), (9.0, [5.0, 0.0])] {
            assert_eq!(linear.at(time, Some(2)).unwrap(), right, "{time}");
            assert_eq!(linear.at(time, None).unwrap(), right, "{time}");
        }
        let step = curve(&[0.0, 1.0], &[3.0, 4.0], Mode::Step);
        assert_eq!([0.0, 0.99, 1.0].map(|time| step.at(time, Some(1)).unwrap()[0]), [3.0, 3.0, 4.0]);
        // t^3 has the slope 0 at 0 and 3 at 1.
        let cubic = curve(&[0.0, 2.0], &[9.0, 0.0, 0.0, 6.0, 8.0, 9.0], Mode::Cubic);
        assert_eq!(cubic.at(1.0, Some(1)).unwrap(), [2.5]);
        assert_eq!(curve(&[0.0, 1.0], &[9.0, 0.0, 0.0, 3.0, 1.0, 9.0], Mode::Cubic).at(0.5, Some(1)).unwrap(), [0.125]);
    }

    #[test]
    fn rotations_take_the_shorter_way_at_even_speed() {
        let quarter = DQuat::from_rotation_y(1.2).to_array().map(|x| -x);
        let values = [DQuat::IDENTITY.to_array(), quarter].concat();
        let turn = Curve { is_rotation: true, ..curve(&[0.0, 3.0], &values, Mode::Linear) };
        let third = quaternion(&turn.at(1.0, Some(4)).unwrap());
        assert!(third.angle_between(DQuat::from_rotation_y(0.4)) < 1e-6, "{third}");
    }

    #[test]
    fn wrong_curves_get_a_sentence() {
        for (wrong, says) in [
            (curve(&[], &[], Mode::Linear), "no keys"),
            (curve(&[1.0, 1.0], &[0.0, 1.0], Mode::Linear), "do not increase"),
            (curve(&[0.0, f64::NAN], &[0.0, 1.0], Mode::Linear), "do not increase"),
            (curve(&[0.0, 1.0], &[0.0, 1.0, 2.0], Mode::Linear), "3 numbers for 2 keys"),
            (curve(&[0.0, 1.0], &[0.0, 1.0], Mode::Cubic), "2 numbers for 2 keys"),
        ] {
            assert!(wrong.at(0.5, Some(1)).unwrap_err().contains(says), "{says}");
        }
        assert!(curve(&[0.0, 1.0], &[], Mode::Linear).at(0.5, None).is_err());
    }
}
