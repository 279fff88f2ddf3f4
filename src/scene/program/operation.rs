//! Operations of programs: their numbers in kernels, their names as texture plugins, their inputs, and their values where these
//! can be computed before a render.

use glam::{Vec3, Vec4};

use crate::generated::constants::*;
use crate::math::srgb::luminance;

/// Kinds of values. All have three components; a number stands in all three.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Number,
    /// Point or direction.
    Vector,
    /// Color, linear sRGB.
    Color,
}

/// Kinds that an input takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Takes {
    /// Number. A color is taken for its luminance, a vector for its mean.
    Number,
    /// Anything, as it is.
    Any,
    /// Coordinates: without a texture, those of the surface.
    Coordinates,
}

/// Kind of an operation's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gives {
    /// One kind, whatever the inputs are.
    One(Kind),
    /// Number where the inputs of any kind are numbers, else the kind of the first that is none.
    AsInputs,
}

/// Input of an operation: a constant, or a nested texture of that name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Name of the parameter.
    pub name: &'static str,
    /// Kinds that it takes.
    pub takes: Takes,
    /// Value where the parameter is not given; `None` where it must be given.
    pub default: Option<f32>,
}

/// Number of an operation that is the same everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parameter {
    /// Whole number: its name, its default, and the largest that is allowed. The least is 0.
    Whole(&'static str, u32, u32),
    /// Number: its name and its default.
    Number(&'static str, f32),
    /// Affine map of a point: twelve numbers, row by row.
    Matrix(&'static str),
    /// One of these words, whose index is the number: the parameter's name, and the words. The first is the default.
    Choice(&'static str, &'static [&'static str]),
    /// Entries of three numbers each, as a string of numbers. They follow the operation's other numbers.
    Table(&'static str),
    /// Index into `Scene::textures`: an image or a pattern.
    Texture,
}

/// Facts of an operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Texture plugin of the operation.
    pub plugin: &'static str,
    /// Its number in kernels: `OPERATION_*`.
    pub code: u32,
    /// Inputs. Where they are more than three, all but the first are numbers, of which each three make one vector.
    pub inputs: &'static [Input],
    /// Numbers that are the same everywhere.
    pub parameters: &'static [Parameter],
    /// Kind of its value.
    pub gives: Gives,
    /// Mean value where it does not follow from those of the inputs.
    pub mean: Option<f32>,
}

const fn any(name: &'static str) -> Input {
    Input { name, takes: Takes::Any, default: None }
}

const fn number(name: &'static str, default: f32) -> Input {
    Input { name, takes: Takes::Number, default: Some(default) }
}

const COORDINATES: Input = Input { name: "coordinates", takes: Takes::Coordinates, default: None };
const W: Input = number("w", 0.0);
const FRACTALS: Parameter =
    Parameter::Choice("kind", &["fbm", "multifractal", "hybrid_multifractal", "ridged_multifractal", "hetero_terrain"]);
const FEATURES: Parameter =
    Parameter::Choice("feature", &["f1", "f2", "smooth_f1", "distance_to_edge", "n_sphere_radius"]);
const METRICS: Parameter = Parameter::Choice("metric", &["euclidean", "manhattan", "chebychev", "minkowski"]);
const OUTPUTS: Parameter = Parameter::Choice("output", &["distance", "color", "position", "w"]);
const NORMALIZE: Parameter = Parameter::Whole("normalize", 1, 1);
const NUMBER: Gives = Gives::One(Kind::Number);
const VECTOR: Gives = Gives::One(Kind::Vector);
const COLOR: Gives = Gives::One(Kind::Color);

/// Declares the operations: a variant, its plugin, its number, its inputs, its parameters, what it gives and its mean.
macro_rules! operations {
    ($( $(#[$doc:meta])* $name:ident = $plugin:literal, $code:ident, [$($input:expr),*], [$($parameter:expr),*], $gives:expr,
        $mean:expr; )*) => {
        /// Operation of a program.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
        pub enum Operation { $( $(#[$doc])* $name, )* }

        impl Operation {
            /// All operations.
            pub const ALL: &[Self] = &[$( Self::$name, )*];

            /// Facts of the operation.
            pub fn row(self) -> Row {
                match self {
                    $( Self::$name => Row {
                        plugin: $plugin, code: $code, inputs: const { &[$($input),*] },
                        parameters: const { &[$($parameter),*] }, gives: $gives,
                        mean: $mean,
                    }, )*
                }
            }
        }
    };
}

operations! {
    /// Affine map of a point.
    Transform = "transformed", OPERATION_TRANSFORM, [COORDINATES], [Parameter::Matrix("to_texture")], VECTOR, None;
    /// Angle from the z-axis in half turns, and the azimuth in turns.
    Spherical = "spherical", OPERATION_SPHERICAL, [COORDINATES], [], VECTOR, Some(0.5);
    /// Azimuth in turns from the negative x-axis, and the height.
    Cylindrical = "cylindrical", OPERATION_CYLINDRICAL, [COORDINATES], [], VECTOR, Some(0.5);
    /// One component: 0, 1 or 2.
    Component = "component", OPERATION_COMPONENT, [any("value")], [Parameter::Whole("index", 0, 2)], NUMBER, None;
    /// Sum.
    Add = "add", OPERATION_ADD, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Difference.
    Subtract = "subtract", OPERATION_SUBTRACT, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Product.
    Multiply = "multiply", OPERATION_MULTIPLY, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Quotient; 0 where the divisor is 0.
    Divide = "divide", OPERATION_DIVIDE, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Smaller of two.
    Minimum = "minimum", OPERATION_MINIMUM, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Larger of two.
    Maximum = "maximum", OPERATION_MAXIMUM, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Power; 1 where the exponent is 0, else 0 where the base is 0, or negative and the exponent no whole number.
    Power = "power", OPERATION_POWER, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Absolute value.
    Absolute = "absolute", OPERATION_ABSOLUTE, [any("value")], [], Gives::AsInputs, None;
    /// Sine of an angle in radians.
    Sine = "sine", OPERATION_SINE, [any("value")], [], Gives::AsInputs, None;
    /// Square root; 0 where the value is negative.
    SquareRoot = "square_root", OPERATION_SQUARE_ROOT, [any("value")], [], Gives::AsInputs, None;
    /// Mix: (1 - weight) a + weight b.
    Mix = "mix", OPERATION_MIX, [any("a"), any("b"), number("weight", 0.5)], [], Gives::AsInputs, None;
    /// Dot product.
    Dot = "dot", OPERATION_DOT, [any("a"), any("b")], [], NUMBER, None;
    /// Relative luminance of a color.
    Luminance = "luminance", OPERATION_LUMINANCE, [any("value")], [], NUMBER, None;
    /// Image or pattern at coordinates. Its plugin is `bitmap`.
    Image = "bitmap", OPERATION_IMAGE, [COORDINATES], [Parameter::Texture], COLOR, Some(0.5);
    /// 0 where the whole parts of the coordinates have an even sum, and 1 elsewhere.
    Checker = "checker", OPERATION_CHECKER, [COORDINATES], [], NUMBER, Some(0.5);
    /// 1 in dots of radius 0.35, of which every second unit square has one, and 0 elsewhere.
    Dots = "dots", OPERATION_DOTS, [COORDINATES], [], NUMBER, Some(0.19);
    /// Sum of octaves of Perlin's noise.
    Fbm = "fbm", OPERATION_FBM, [COORDINATES],
        [Parameter::Whole("octaves", 8, MAX_OCTAVES), Parameter::Number("roughness", 0.5)], NUMBER, Some(0.0);
    /// Sum of the absolute values of octaves of Perlin's noise.
    Wrinkled = "wrinkled", OPERATION_WRINKLED, [COORDINATES],
        [Parameter::Whole("octaves", 8, MAX_OCTAVES), Parameter::Number("roughness", 0.5)], NUMBER, Some(0.4);
    /// Color of pbrt's marble for a number in [0, 1].
    Marble = "marble_color", OPERATION_MARBLE, [number("value", 0.0)], [], COLOR, Some(0.8);
    /// Largest whole number that is not above the value.
    Floor = "floor", OPERATION_FLOOR, [any("value")], [], Gives::AsInputs, None;
    /// 1 where the first is less than the second, else 0.
    Less = "less", OPERATION_LESS, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Power of Euler's number.
    Exponential = "exponential", OPERATION_EXPONENTIAL, [any("value")], [], Gives::AsInputs, None;
    /// Natural logarithm; 0 where the value is not positive.
    Logarithm = "logarithm", OPERATION_LOGARITHM, [any("value")], [], Gives::AsInputs, None;
    /// Angle of the point (b, a) in radians; 0 where both are 0.
    Arctangent = "arctangent", OPERATION_ARCTANGENT, [any("a"), any("b")], [], Gives::AsInputs, None;
    /// Vector of three numbers.
    Combine = "combine", OPERATION_COMBINE, [number("x", 0.0), number("y", 0.0), number("z", 0.0)], [], VECTOR, None;
    /// Hue in turns, saturation and value of a color.
    HsvFromRgb = "hsv_from_rgb", OPERATION_HSV_FROM_RGB, [any("value")], [], VECTOR, Some(0.5);
    /// Color of a hue in turns, a saturation and a value.
    RgbFromHsv = "rgb_from_hsv", OPERATION_RGB_FROM_HSV, [any("value")], [], COLOR, Some(0.5);
    /// Hue in turns, saturation and lightness of a color.
    HslFromRgb = "hsl_from_rgb", OPERATION_HSL_FROM_RGB, [any("value")], [], VECTOR, Some(0.5);
    /// Color of a hue in turns, a saturation and a lightness.
    RgbFromHsl = "rgb_from_hsl", OPERATION_RGB_FROM_HSL, [any("value")], [], COLOR, Some(0.5);
    /// Entry of a table, channel by channel.
    Table = "table", OPERATION_TABLE, [any("value")],
        [Parameter::Whole("extrapolate", 0, 1), Parameter::Whole("steps", 0, 1), Parameter::Table("values")], COLOR, Some(0.5);
    /// Three numbers in [0, 1] that depend on each bit of the coordinates.
    WhiteNoise = "white_noise", OPERATION_WHITE_NOISE, [COORDINATES, W], [Parameter::Whole("dimensions", 3, 4)], COLOR, Some(0.5);
    /// Sum of octaves of Blender's noise in one dimension.
    Noise1d = "noise_1d", OPERATION_NOISE_1D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("offset", 0.0),
         number("gain", 1.0)],
        [FRACTALS, NORMALIZE], NUMBER, Some(0.5);
    /// Sum of octaves of Blender's noise in two dimensions.
    Noise2d = "noise_2d", OPERATION_NOISE_2D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("offset", 0.0),
         number("gain", 1.0)],
        [FRACTALS, NORMALIZE], NUMBER, Some(0.5);
    /// Sum of octaves of Blender's noise in three dimensions.
    Noise3d = "noise_3d", OPERATION_NOISE_3D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("offset", 0.0),
         number("gain", 1.0)],
        [FRACTALS, NORMALIZE], NUMBER, Some(0.5);
    /// Sum of octaves of Blender's noise in four dimensions.
    Noise4d = "noise_4d", OPERATION_NOISE_4D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("offset", 0.0),
         number("gain", 1.0)],
        [FRACTALS, NORMALIZE], NUMBER, Some(0.5);
    /// Voronoi diagram of Blender in one dimension.
    Voronoi1d = "voronoi_1d", OPERATION_VORONOI_1D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("smoothness", 1.0),
         number("randomness", 1.0)],
        [FEATURES, METRICS, OUTPUTS, Parameter::Whole("normalize", 0, 1), Parameter::Number("exponent", 0.5)], VECTOR, Some(0.5);
    /// Voronoi diagram of Blender in two dimensions.
    Voronoi2d = "voronoi_2d", OPERATION_VORONOI_2D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("smoothness", 1.0),
         number("randomness", 1.0)],
        [FEATURES, METRICS, OUTPUTS, Parameter::Whole("normalize", 0, 1), Parameter::Number("exponent", 0.5)], VECTOR, Some(0.5);
    /// Voronoi diagram of Blender in three dimensions.
    Voronoi3d = "voronoi_3d", OPERATION_VORONOI_3D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("smoothness", 1.0),
         number("randomness", 1.0)],
        [FEATURES, METRICS, OUTPUTS, Parameter::Whole("normalize", 0, 1), Parameter::Number("exponent", 0.5)], VECTOR, Some(0.5);
    /// Voronoi diagram of Blender in four dimensions.
    Voronoi4d = "voronoi_4d", OPERATION_VORONOI_4D,
        [COORDINATES, W, number("detail", 0.0), number("roughness", 0.5), number("lacunarity", 2.0), number("smoothness", 1.0),
         number("randomness", 1.0)],
        [FEATURES, METRICS, OUTPUTS, Parameter::Whole("normalize", 0, 1), Parameter::Number("exponent", 0.5)], VECTOR, Some(0.5);
    /// Number of the brick of a wall, and the share of mortar.
    Bricks = "bricks", OPERATION_BRICKS,
        [COORDINATES, number("mortar", 0.02), number("smoothness", 0.1), number("bias", 0.0), number("width", 0.5),
         number("height", 0.25)],
        [Parameter::Number("offset", 0.5), Parameter::Number("squash", 1.0), Parameter::Whole("offset_rows", 2, 99),
         Parameter::Whole("squash_rows", 2, 99)], VECTOR, Some(0.5);
}

impl Operation {
    /// Whether the operation looks up the permutation of Perlin's noise, whose address follows its parameters in kernels.
    pub fn needs_noise_table(self) -> bool {
        matches!(self, Self::Dots | Self::Fbm | Self::Wrinkled)
    }

    /// Value for constant inputs; `None` for operations that kernels alone compute. Floats of `numbers` are bits.
    pub fn value(self, inputs: &[Vec3], numbers: &[u32]) -> Option<Vec3> {
        let input = |index: usize| inputs.get(index).copied().unwrap_or(Vec3::ZERO);
        let (a, b) = (input(0), input(1));
        let each = |function: fn(f32, f32) -> f32| Vec3::from_array([0, 1, 2].map(|i| function(a[i], b[i])));
        Some(match self {
            Self::Transform => {
                let row = |row: usize| {
                    let number =
                        |column: usize| numbers.get(4 * row + column).map_or(0.0, |&bits| f32::from_bits(bits));
                    Vec4::from_array([0, 1, 2, 3].map(number)).dot(a.extend(1.0))
                };
                Vec3::new(row(0), row(1), row(2))
            }
            Self::Component => Vec3::splat(a[numbers.first().map_or(0, |&index| index.min(2) as usize)]),
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => each(|a, b| if b == 0.0 { 0.0 } else { a / b }),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Power => each(|a, b| match (a, b) {
                (_, 0.0) => 1.0,
                (0.0, _) => 0.0,
                (a, b) if a < 0.0 && b.fract() != 0.0 => 0.0,
                (a, b) => a.powf(b),
            }),
            Self::Floor => a.floor(),
            Self::Less => each(|a, b| f32::from(u8::from(a < b))),
            Self::Exponential => a.map(f32::exp),
            Self::Logarithm => a.map(|value| if value > 0.0 { value.ln() } else { 0.0 }),
            Self::Arctangent => each(|a, b| if a == 0.0 && b == 0.0 { 0.0 } else { a.atan2(b) }),
            Self::Combine => Vec3::new(a.x, b.x, input(2).x),
            Self::Absolute => a.abs(),
            Self::Sine => a.map(f32::sin),
            Self::SquareRoot => a.map(|value| value.max(0.0).sqrt()),
            Self::Mix => (Vec3::ONE - input(2)) * a + input(2) * b,
            Self::Dot => Vec3::splat(a.dot(b)),
            Self::Luminance => Vec3::splat(luminance(a.to_array().map(f64::from)) as f32),
            _ => return None,
        })
    }
}
