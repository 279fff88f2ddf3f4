//! Materials that are bound to prims, by themselves, by their parents or by collections.

use std::rc::Rc;

use openusd::sdf;
use openusd::usd::{Collection, MembershipQuery};

use super::asset::Prim;
use super::values;
use crate::Result;

/// Relationships that bind a material, the preferred one first.
const DIRECT: [&str; 3] = ["material:binding:full", "material:binding", "material:binding:preview"];
/// Beginnings of the names of relationships that bind a material to a collection.
const COLLECTION: &str = "material:binding:collection:";

/// Bindings that hold at a prim.
#[derive(Clone, Default)]
pub(super) struct Bindings {
    direct: Option<(sdf::Path, bool)>,
    collections: Rc<Vec<Rc<Bound>>>,
}

/// A collection with its material.
struct Bound {
    members: MembershipQuery,
    material: sdf::Path,
}

impl Bindings {
    /// Bindings of a prim, whose parent has these.
    pub fn of(&self, prim: &Prim) -> Result<Self> {
        let mut own = self.clone();
        let has_any = prim.names().any(|name| name.starts_with("material:binding"));
        if !has_any {
            return Ok(own);
        }
        if !own.direct.as_ref().is_some_and(|(_, is_strong)| *is_strong) {
            for name in DIRECT {
                if let Some(material) = prim.targets(name)?.into_iter().next() {
                    let strength = prim.metadata(name, "bindMaterialAs")?;
                    let is_strong =
                        strength.as_ref().and_then(values::text).as_deref() == Some("strongerThanDescendants");
                    own.direct = Some((material, is_strong));
                    break;
                }
            }
        }
        let mut names: Vec<&str> = prim.names().filter(|name| name.starts_with(COLLECTION)).collect();
        names.sort_unstable();
        for name in names {
            let [collection, material] = &prim.targets(name)?[..] else { continue };
            let Some((holder, name)) = collection.split_property() else { continue };
            let Some(name) = name.strip_prefix("collection:") else { continue };
            let collection = Collection::new(holder, name);
            match collection.compute_membership_query(&prim.asset.stage) {
                Ok(members) => {
                    let bound = Rc::new(Bound { members, material: material.clone() });
                    // The nearest one comes first.
                    let mut all = vec![bound];
                    all.extend(own.collections.iter().cloned());
                    own.collections = Rc::new(all);
                }
                Err(error) => return Err(prim.asset.fault(&prim.path, &error)),
            }
        }
        Ok(own)
    }

    /// Material of the prim at a path.
    pub fn material(&self, path: &sdf::Path) -> Option<sdf::Path> {
        let bound = self.collections.iter().find(|bound| bound.members.is_path_included(path));
        bound.map(|bound| bound.material.clone()).or_else(|| self.direct.as_ref().map(|(material, _)| material.clone()))
    }

    /// Words that tell bindings apart.
    pub fn key(&self) -> String {
        let direct = self.direct.as_ref().map_or(String::new(), |(material, strong)| format!("{material} {strong}"));
        self.collections.iter().fold(direct, |key, bound| format!("{key} {:p}", Rc::as_ptr(bound)))
    }
}
