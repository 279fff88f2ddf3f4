//! Point instancers.

use std::collections::HashSet;

use glam::{DMat4, DQuat, DVec3};
use openusd::sdf;

use super::asset::Prim;
use super::budget::Made;
use super::transforms::quaternion;
use super::values;
use crate::Result;

/// Prototypes of a point instancer, each as often as it is shown, with its place in the instancer's space.
pub(super) fn placed(prim: &Prim, made: &mut Made) -> Result<Vec<(sdf::Path, DMat4)>> {
    let fault = |message: String| prim.asset.prim_error(&prim.path, message);
    let prototypes = prim.targets("prototypes")?;
    let chosen = prim.read("protoIndices", values::indices)?.unwrap_or_default();
    let positions = prim.read("positions", values::triples)?.unwrap_or_default();
    let mut turns = prim.read("orientationsf", values::quaternions)?.unwrap_or_default();
    if turns.is_empty() {
        turns = prim.read("orientations", values::quaternions)?.unwrap_or_default();
    }
    let scales = prim.read("scales", values::triples)?.unwrap_or_default();
    let ids = prim.read("ids", values::indices)?.unwrap_or_default();
    let mut hidden: HashSet<usize> =
        prim.read("invisibleIds", values::indices)?.unwrap_or_default().into_iter().collect();
    hidden.extend(inactive(prim)?);
    if positions.len() < chosen.len() {
        return Err(fault("it has more `protoIndices` than `positions`".to_owned()));
    }
    made.prims(chosen.len()).map_err(fault)?;
    let mut placed = Vec::new();
    for (at, &index) in chosen.iter().enumerate() {
        if hidden.contains(ids.get(at).unwrap_or(&at)) {
            continue;
        }
        let prototype = prototypes.get(index).ok_or_else(|| fault(format!("it has no prototype {index}")))?;
        let turn = turns.get(at).map_or(DQuat::IDENTITY, |&elements| quaternion(elements));
        let scale = scales.get(at).map_or(DVec3::ONE, |&scale| DVec3::from_array(scale));
        let own = DMat4::from_scale_rotation_translation(scale, turn, DVec3::from_array(positions[at]));
        if !own.is_finite() {
            return Err(fault(format!("the place of instance {at} is not finite")));
        }
        placed.push((prototype.clone(), own));
    }
    Ok(placed)
}

/// Instances that the metadata `inactiveIds` leaves out.
fn inactive(prim: &Prim) -> Result<Vec<usize>> {
    let list = prim.asset.stage.attribute(prim.path.clone()).get_metadata::<sdf::Value>("inactiveIds");
    let list = list.map_err(|error| prim.asset.fault(&prim.path, &error))?;
    Ok(match list {
        Some(sdf::Value::Int64ListOp(list)) => {
            list.flatten().into_iter().filter_map(|id| usize::try_from(id).ok()).collect()
        }
        Some(value) => values::indices(&value).unwrap_or_default(),
        None => Vec::new(),
    })
}
