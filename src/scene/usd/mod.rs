//! USD: `.usd`, `.usda`, `.usdc` and `.usdz` files to a description.
//!
//! The crate `openusd` parses layers and composes the stage. Lengths stay as they are, and a stage whose axis is z is turned to +y.

mod archive;
mod asset;
mod bindings;
mod budget;
mod cameras;
mod crates;
mod curves;
mod files;
mod instancers;
mod layers;
mod lights;
mod materials;
mod meshes;
mod names;
mod primvars;
mod solids;
mod surfaces;
mod textures;
mod transforms;
mod values;
mod walk;

use std::any::Any;
use std::cell::RefCell;
use std::panic;
use std::path::Path;
use std::sync::Once;
use std::thread;

use super::description::Description;
use crate::{Error, Result, quoted};
use asset::Asset;
use walk::Walk;

/// Bytes of the stack on which a stage is read: the parser and the walk over prims recurse.
const STACK: usize = 256 << 20;

/// Reads the file at `path`. The definitions may choose a `time` in seconds.
///
/// # Errors
/// Where the file cannot be read, or it is damaged.
pub(super) fn read(path: &Path, defines: &[(String, String)]) -> Result<Description> {
    let time = time(defines).map_err(|message| Error::scene(path, None, message))?;
    let result = thread::scope(|scope| {
        let thread = thread::Builder::new().name("USD".to_owned()).stack_size(STACK);
        let work = || {
            quiet();
            let work = panic::AssertUnwindSafe(|| describe(path, time));
            panic::catch_unwind(work).unwrap_or_else(|fault| Err(Error::scene(path, None, failure(&*fault))))
        };
        thread.spawn_scoped(scope, work).map(|handle| handle.join())
    });
    match result {
        Ok(joined) => joined.unwrap_or_else(|fault| panic::resume_unwind(fault)),
        Err(error) => Err(Error::scene(path, None, format!("no thread to read it can be started: {error}"))),
    }
}

thread_local! {
    /// Where the reader failed; `None` on threads that read no USD.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Keeps the place where this thread panics, in place of a message. The parser panics at some files that it does not expect.
fn quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            let is_kept = PLACE.with_borrow_mut(|place| match (place, info.location()) {
                (Some(place), Some(location)) => {
                    *place = format!("{}:{}", place_of(location.file()), location.line());
                    true
                }
                (place, _) => place.is_some(),
            });
            if !is_kept {
                usual(info);
            }
        }));
    });
    PLACE.set(Some("a place that is not known".to_owned()));
}

/// Path of a source file from the folder of its crate.
fn place_of(file: &str) -> &str {
    let start = file.rfind("/src/").and_then(|end| file[..end].rfind('/'));
    start.map_or(file, |start| &file[start + 1..])
}

/// Sentence about a panic.
fn failure(fault: &(dyn Any + Send)) -> String {
    let text = fault.downcast_ref::<String>().map(String::as_str).or_else(|| fault.downcast_ref::<&str>().copied());
    let text = quoted::message(&text.unwrap_or("it does not say why"));
    let place = PLACE.take().unwrap_or_else(|| "a place that is not known".to_owned());
    format!("the reader of USD failed at {place} ({text}); the file may be damaged: save it again")
}

fn describe(path: &Path, time: Option<f64>) -> Result<Description> {
    let asset = Asset::open(path, time)?;
    let axis = asset.stage.stage_metadata("upAxis").ok().flatten();
    let is_z_up = axis.as_ref().and_then(values::text).as_deref() == Some("Z");
    let mut walk = Walk::new(&asset, is_z_up);
    walk.all()?;
    let Walk { materials, cameras, shapes, lights, groups, .. } = walk;
    if shapes.is_empty() && cameras.is_empty() {
        return Err(asset.error("its stage shows neither shapes nor a camera"));
    }
    let objects = materials.take_objects().into_iter().chain(groups).chain(lights).chain(shapes).collect::<Vec<_>>();
    let ids = objects.iter().map(|(id, _)| id.clone()).collect();
    let objects = cameras.into_objects(ids).into_iter().chain(objects).collect();
    Ok(Description::of_objects(path, objects, asset.into_warnings()))
}

/// Moment that the definitions choose, in seconds.
fn time(defines: &[(String, String)]) -> Result<Option<f64>, String> {
    let mut time = None;
    for (name, value) in defines {
        if name != "time" {
            let option = if name == "variant" { "--variant, or " } else { "" };
            return Err(format!("{option}-D {name}: a USD file has only the value `time`; leave it out"));
        }
        let seconds = value.trim().parse().ok().filter(|seconds: &f64| seconds.is_finite());
        let word = quoted::word(value);
        time = Some(seconds.ok_or_else(|| format!("the time {word} should be a number of seconds"))?);
    }
    Ok(time)
}
