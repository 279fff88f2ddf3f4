//! Parts of scenes, as text.

pub fn element(tag: &str, plugin: &str, inside: &str) -> String {
    format!("<{tag} type='{plugin}'>{inside}</{tag}>")
}

pub fn bsdf(plugin: &str, inside: &str) -> String {
    element("bsdf", plugin, inside)
}

pub fn shape(plugin: &str, inside: &str) -> String {
    element("shape", plugin, inside)
}

pub fn rgb(name: &str, value: &str) -> String {
    format!("<rgb name='{name}' value='{value}'/>")
}

pub fn float(name: &str, value: &str) -> String {
    format!("<float name='{name}' value='{value}'/>")
}

pub fn string(name: &str, value: &str) -> String {
    format!("<string name='{name}' value='{value}'/>")
}

pub fn integer(name: &str, value: i32) -> String {
    format!("<integer name='{name}' value='{value}'/>")
}

pub fn on(name: &str) -> String {
    format!("<boolean name='{name}' value='true'/>")
}

pub fn placed(steps: &str) -> String {
    format!("<transform name='to_world'>{steps}</transform>")
}

/// Texture for the parameter `name`.
pub fn texture(name: &str, plugin: &str, inside: &str) -> String {
    format!("<texture type='{plugin}' name='{name}'>{inside}</texture>")
}

/// Image `file` for the parameter `name`. The tests write it beside the scene.
pub fn bitmap(name: &str, file: &str, inside: &str) -> String {
    texture(name, "bitmap", &(string("filename", file) + inside))
}

/// Image of numbers, for a parameter that is no color.
pub fn numbers(name: &str, file: &str) -> String {
    bitmap(name, file, &on("raw"))
}

pub fn checkerboard(name: &str, color0: &str, color1: &str) -> String {
    let turns = "<transform name='to_uv'><scale x='4' y='3'/></transform>";
    texture(name, "checkerboard", &(rgb("color0", color0) + &rgb("color1", color1) + turns))
}

pub fn diffuse(albedo: &str) -> String {
    bsdf("diffuse", &rgb("reflectance", albedo))
}

/// Diffuse surface with an image, dark on its back.
pub fn printed() -> String {
    bsdf("diffuse", &bitmap("reflectance", "colors.png", ""))
}

pub fn two_sided(inside: &str) -> String {
    bsdf("twosided", inside)
}

pub fn path(depth: impl std::fmt::Display) -> String {
    element("integrator", "path", &(format!("<integer name='max_depth' value='{depth}'/>") + &integer("rr_depth", 5)))
}

pub fn film(inside: &str) -> String {
    sized_film(24, 18, inside)
}

pub fn sized_film(width: i32, height: i32, inside: &str) -> String {
    let size = integer("width", width) + &integer("height", height) + &string("pixel_format", "rgb");
    element("film", "hdrfilm", &(size + inside))
}

/// Where the camera stands, and where it looks.
pub const EYE: &str = "<lookat origin='0.3,1.7,5.2' target='0,0.8,0' up='0,1,0'/>";

pub fn perspective(inside: &str, film: &str) -> String {
    sensor("perspective", EYE, inside, film)
}

pub fn sensor(plugin: &str, place: &str, inside: &str, film: &str) -> String {
    element("sensor", plugin, &[inside, &placed(place), film].concat())
}

/// A square of side 6.
pub fn wall(steps: &str, albedo: &str) -> String {
    shape("rectangle", &(placed(&format!("<scale value='3'/>{steps}")) + &diffuse(albedo)))
}

pub fn area(radiance: &str) -> String {
    element("emitter", "area", &rgb("radiance", radiance))
}

/// Where the lamp above hangs.
pub const ABOVE: &str = "<scale x='0.9' y='0.7'/><rotate x='1' angle='90'/><rotate z='1' angle='15'/>\
                         <translate y='3' x='0.5' z='0.6'/>";

/// The lamp above.
pub fn lamp(radiance: &str) -> String {
    shape("rectangle", &(placed(ABOVE) + &area(radiance)))
}

/// A ball on the left.
pub fn ball(inside: &str) -> String {
    shape(
        "sphere",
        &("<point name='center' x='-0.8' y='0.75' z='0'/><float name='radius' value='0.7'/>".to_owned() + inside),
    )
}

/// A turned cube on the right.
pub fn block(inside: &str) -> String {
    let steps =
        "<scale value='0.5'/><rotate y='1' angle='30'/><rotate x='1' angle='20'/><translate x='0.9' y='0.8' z='0.3'/>";
    shape("cube", &(placed(steps) + inside))
}

/// A turned sheet on the right.
pub fn sheet(inside: &str) -> String {
    let steps = "<scale x='0.6' y='0.75'/><rotate y='1' angle='-20'/><rotate x='1' angle='-25'/><translate x='0.8' y='0.8' z='0.5'/>";
    shape("rectangle", &(placed(steps) + inside))
}

/// A value that a twin replaces.
pub fn default(name: &str, value: &str) -> String {
    format!("<default name='{name}' value='{value}'/>")
}
