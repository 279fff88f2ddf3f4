//! Reader of `<integrator>`. The picture is that of a path tracer, whatever the scene's author used to make it.

use super::properties::Properties;
use super::scope::Scope;
use crate::Result;
use crate::scene::IntegratorDescription;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;

/// Integrators that take their picture from another, which is nested in them.
const WRAPPERS: [&str; 6] = ["aov", "moment", "stokes", "multichannel", "adaptive", "irrcache"];

/// Integrators of emission and direct light.
const DIRECT: [&str; 3] = ["direct", "direct_projective", "direct_reparam"];

/// Integrators whose picture is that of a path tracer, with media where there are any.
const PATH: [&str; 2] = ["path", "volpath"];

/// Integrators that estimate what those of [`PATH`] estimate.
const LIKE_PATH: [&str; 28] = [
    "bdpt",
    "erpt",
    "guided_path",
    "mlt",
    "path_guiding",
    "path_simple",
    "pathguiding",
    "photonmapper",
    "ppg",
    "ppm",
    "prb",
    "prb_basic",
    "prb_projective",
    "prb_reparam",
    "prb_threepoint",
    "prbvolpath",
    "pssmlt",
    "ptracer",
    "sppm",
    "transient",
    "transient_path",
    "transient_prb_volpath",
    "transientpath",
    "transientvolpath",
    "voltransient",
    "volpath_simple",
    "volpathmis",
    "vpl",
];

/// `max_depth` of direct light: a path to a surface, and one edge more.
const DIRECT_DEPTH: i32 = 2;
/// Mitsuba's default `max_depth` of the differentiable integrators.
const DIFFERENTIABLE_DEPTH: i32 = 6;
/// Deepest nesting of wrappers.
const MAX_DEPTH: usize = 16;

/// Whether a plugin is an integrator that this reader knows.
pub(super) fn is_known(plugin: &str) -> bool {
    [&PATH[..], &WRAPPERS, &DIRECT, &LIKE_PATH].iter().any(|names| names.contains(&plugin))
}

/// Reads an `<integrator>`. One that is not of [`PATH`] gets a single warning, or is an error where its picture is another.
pub(super) fn parse<'a>(
    object: &'a Object,
    scope: &Scope<'a>,
    warnings: &mut Vec<String>,
) -> Result<IntegratorDescription> {
    let (names, mut properties) = unwrap(object, scope)?;
    let plugin = properties.plugin();
    let mut description = read(&mut properties)?;
    let mut left_out = None;
    if DIRECT.contains(&plugin) {
        left_out = no_samples(&mut properties)?;
        description.max_depth = Some(DIRECT_DEPTH);
    } else if plugin.starts_with("prb") {
        description.max_depth = description.max_depth.or(Some(DIFFERENTIABLE_DEPTH));
    } else if !PATH.contains(&plugin) && !LIKE_PATH.contains(&plugin) {
        let all = PATH.iter().chain(&WRAPPERS).chain(&DIRECT).chain(&LIKE_PATH);
        return Err(properties.owner().unsupported(&all.copied().collect::<Vec<_>>()));
    }
    if PATH.contains(&plugin) && names.is_empty() {
        properties.finish(warnings)?;
        return Ok(description);
    }
    let names: Vec<_> = names.into_iter().chain([plugin]).map(|name| format!("`{name}`")).collect();
    let depth = match description.max_depth {
        Some(depth) if depth >= 0 => format!(" with a `max_depth` of {depth}"),
        _ => String::new(),
    };
    warnings.push(format!(
        "{}: the integrator {} is rendered as `path`{depth}; its other parameters are ignored{}",
        object.origin,
        names.join(" around "),
        left_out.unwrap_or_default()
    ));
    Ok(description)
}

/// Names of the wrappers, from the outermost, and the properties of the integrator within.
fn unwrap<'a>(object: &'a Object, scope: &Scope<'a>) -> Result<(Vec<&'a str>, Properties<'a>)> {
    let mut names = Vec::new();
    let mut properties = Properties::new(object, scope)?;
    while WRAPPERS.contains(&properties.plugin()) {
        let (wrapper, plugin) = (properties.owner(), properties.plugin());
        let nested = properties.objects(Kind::Integrator);
        let [nested] = nested[..] else {
            let count = nested.len();
            let word = wrapper.origin.word("integrator");
            let message = format!("integrator plugin `{plugin}` needs one nested {word}, but has {count}");
            return Err(wrapper.error(message));
        };
        names.push(plugin);
        if names.len() > MAX_DEPTH {
            return Err(object.error("integrators are nested too deep: does one refer to itself?"));
        }
        properties = Properties::new(nested, scope)?;
    }
    Ok((names, properties))
}

fn read(properties: &mut Properties) -> Result<IntegratorDescription> {
    let depth = |depth: Option<i64>| depth.map(|depth| depth as i32);
    Ok(IntegratorDescription {
        max_depth: depth(properties.integer("max_depth", -1..=i32::MAX as i64)?),
        rr_depth: depth(properties.integer("rr_depth", 1..=i32::MAX as i64)?),
        hide_emitters: properties.boolean("hide_emitters")?.unwrap_or(false),
    })
}

/// Words about a direct integrator without samples of emitters or of BSDFs: some light is missing from Mitsuba's picture, and stands
/// in the picture here.
fn no_samples(properties: &mut Properties) -> Result<Option<&'static str>> {
    let location = properties.location("bsdf_samples");
    let mut is_none = |name: &str| Ok(properties.integer(name, 0..=i64::from(i32::MAX))? == Some(0));
    match (is_none("emitter_samples")?, is_none("bsdf_samples")?) {
        (true, true) => {
            Err(location
                .error("`emitter_samples` and `bsdf_samples` of 0 leave no light; give one of them another value"))
        }
        (true, false) => {
            Ok(Some(". Mitsuba leaves out the lights without a size (`emitter_samples` of 0); here they shine"))
        }
        (false, true) => {
            Ok(Some(". Mitsuba leaves out what smooth mirrors and glass show (`bsdf_samples` of 0); here it is shown"))
        }
        (false, false) => Ok(None),
    }
}
