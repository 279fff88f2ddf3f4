//! Materials that are bound to prims, by themselves, by their parents or by collections.

use std::fmt::Write as _;
use std::rc::Rc;

use openusd::sdf;
use openusd::usd::{Collection, MembershipQuery};

use super::asset::Prim;
use super::values;
use crate::Result;

/// Relationships that bind a material, the purpose `full` first. Those of other purposes, such as `preview`, are for other pictures.
const DIRECT: [&str; 2] = ["material:binding:full", "material:binding"];
/// Beginnings of the names of relationships that bind a material to a collection, in the same order.
const COLLECTION: [&str; 2] = ["material:binding:collection:full:", "material:binding:collection:"];

/// Bindings that hold at a prim: its own and those of its parents.
#[derive(Clone, Default)]
pub(super) struct Bindings {
    nearest: Option<Rc<Level>>,
}

/// Bindings of one prim.
struct Level {
    parent: Bindings,
    /// Direct bindings by their purpose.
    direct: [Option<Strength>; 2],
    /// Bindings of collections by their purpose, in the order of their names.
    collections: [Vec<Bound>; 2],
}

/// A material, and whether it is stronger than what is bound below.
#[derive(Clone)]
struct Strength {
    material: sdf::Path,
    is_strong: bool,
}

/// A collection with its material.
struct Bound {
    members: MembershipQuery,
    material: Strength,
}

impl Bindings {
    /// Bindings of a prim, whose parent has these.
    pub fn of(&self, prim: &Prim) -> Result<Self> {
        if !prim.names().any(|name| name.starts_with(DIRECT[1])) {
            return Ok(self.clone());
        }
        let mut level = Level { parent: self.clone(), direct: [None, None], collections: [Vec::new(), Vec::new()] };
        for (purpose, name) in DIRECT.into_iter().enumerate() {
            if let Some(material) = prim.targets(name)?.into_iter().next() {
                level.direct[purpose] = Some(Strength { material, is_strong: is_strong(prim, name)? });
            }
        }
        for (purpose, prefix) in COLLECTION.into_iter().enumerate() {
            let is_own = |name: &&str| name.strip_prefix(prefix).is_some_and(|rest| !rest.contains(':'));
            let mut names: Vec<&str> = prim.names().filter(is_own).collect();
            names.sort_by_key(|name| (name.to_ascii_lowercase(), name.to_string()));
            for name in names {
                let [collection, material] = &prim.targets(name)?[..] else { continue };
                let Some((holder, property)) = collection.split_property() else { continue };
                let Some(collection) = property.strip_prefix("collection:") else { continue };
                let members = Collection::new(holder, collection).compute_membership_query(&prim.asset.stage);
                let members = members.map_err(|error| prim.asset.fault(&prim.path, &error))?;
                let material = Strength { material: material.clone(), is_strong: is_strong(prim, name)? };
                level.collections[purpose].push(Bound { members, material });
            }
        }
        Ok(Self { nearest: Some(Rc::new(level)) })
    }

    /// Material of the prim at a path.
    pub fn material(&self, path: &sdf::Path) -> Option<sdf::Path> {
        let purposes = 0..DIRECT.len();
        purposes.filter_map(|purpose| self.winner(purpose, path)).map(|winner| winner.material.clone()).next()
    }

    /// Binding of a purpose that holds for the prim at a path.
    fn winner(&self, purpose: usize, path: &sdf::Path) -> Option<&Strength> {
        let mut winner: Option<&Strength> = None;
        for level in self.levels() {
            let mut is_direct = false;
            if let Some(direct) = &level.direct[purpose]
                && (winner.is_none() || direct.is_strong)
            {
                (winner, is_direct) = (Some(direct), true);
            }
            // A collection of a prim goes before the direct binding of that prim.
            let mut own = level.collections[purpose].iter().filter(|bound| bound.members.is_path_included(path));
            let own = own.find(|bound| winner.is_none() || is_direct || bound.material.is_strong);
            winner = own.map(|bound| &bound.material).or(winner);
        }
        winner
    }

    /// Levels from the prim upwards.
    fn levels(&self) -> impl Iterator<Item = &Level> {
        std::iter::successors(self.nearest.as_deref(), |level| level.parent.nearest.as_deref())
    }

    /// Words that tell apart what is bound to prims below; `None` where that depends on their paths, by collections.
    pub fn key(&self) -> Option<String> {
        if self.levels().any(|level| level.collections.iter().any(|bound| !bound.is_empty())) {
            return None;
        }
        let mut key = String::new();
        for purpose in 0..DIRECT.len() {
            if let Some(winner) = self.winner(purpose, &sdf::Path::abs_root()) {
                let _ = write!(key, "{purpose} {} {} ", winner.material, winner.is_strong);
            }
        }
        Some(key)
    }
}

/// Whether a binding is stronger than those of the prims below.
fn is_strong(prim: &Prim, name: &str) -> Result<bool> {
    let strength = prim.metadata(name, "bindMaterialAs")?;
    Ok(strength.as_ref().and_then(values::text).as_deref() == Some("strongerThanDescendants"))
}
