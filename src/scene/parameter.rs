//! Parameters of scattering functions, with their numbers in the record of a material.

use glam::Vec3;

use super::texture::Textured;

/// Value of a parameter.
#[derive(Debug)]
pub enum Value<'a> {
    /// Color that a texture may multiply.
    Color(&'a mut Textured<Vec3>),
    /// Number that a texture may multiply.
    Scalar(&'a mut Textured<f32>),
    /// Three numbers.
    Triple(Vec3),
    /// Number.
    Number(f32),
    /// Bit of a material's flags. The parameter's number is the mask.
    Flag(bool),
}

/// One parameter, or a struct of several.
pub trait Parameter {
    /// Shows the value of each parameter with its number. `number` is that of a single one.
    fn visit<'a>(&'a mut self, number: u32, see: &mut dyn FnMut(u32, Value<'a>));
}

/// Implements [`Parameter`] for the type of a value.
macro_rules! value {
    ($type:ty, $self:ident => $value:expr) => {
        impl Parameter for $type {
            fn visit<'a>(&'a mut $self, number: u32, see: &mut dyn FnMut(u32, Value<'a>)) {
                see(number, $value);
            }
        }
    };
}

value!(Textured<Vec3>, self => Value::Color(self));
value!(Textured<f32>, self => Value::Scalar(self));
value!(Vec3, self => Value::Triple(*self));
value!(f32, self => Value::Number(*self));
value!(bool, self => Value::Flag(*self));

/// Declares a struct of parameters: `name: Type => NUMBER`, without a number where the type is itself such a struct.
macro_rules! parameters {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident { $( $(#[$doc:meta])* $field:ident: $type:ty $(=> $number:ident)?, )* }
    ) => {
        $(#[$attribute])*
        pub struct $name { $( $(#[$doc])* pub $field: $type, )* }

        impl Parameter for $name {
            fn visit<'a>(&'a mut self, _number: u32, see: &mut dyn FnMut(u32, Value<'a>)) {
                $( self.$field.visit(number!($($number)?), see); )*
            }
        }
    };
}

/// Declares the kinds of scattering functions: a variant, its plugin, its number with the flags that it always has, and its
/// parameters as in [`parameters!`].
macro_rules! kinds {
    (
        $(#[$attribute:meta])*
        pub enum $name:ident {
            $(
                $(#[$variant_doc:meta])*
                $variant:ident $(($inner:ident: $struct:ty))? = $plugin:literal, $($kind:ident)|+ $({
                    $( $(#[$doc:meta])* $field:ident: $type:ty $(=> $number:ident)?, )*
                })?;
            )*
        }
    ) => {
        $(#[$attribute])*
        pub enum $name {
            $( $(#[$variant_doc])* $variant $(($struct))? $({ $( $(#[$doc])* $field: $type, )* })?, )*
        }

        impl $name {
            /// Plugin of the function.
            pub fn plugin(&self) -> &'static str {
                match self { $( Self::$variant { .. } => $plugin, )* }
            }

            /// Number of the function (`BSDF_*`), and the flags that it always has.
            pub fn kind_and_flags(&self) -> u32 {
                match self { $( Self::$variant { .. } => $($kind)|+, )* }
            }

            /// Shows the value of each parameter with its number.
            pub fn visit<'a>(&'a mut self, see: &mut dyn FnMut(u32, Value<'a>)) {
                match self {
                    $( Self::$variant $(($inner))? $({ $($field),* })? => {
                        $( $inner.visit(0, see); )?
                        $($( $field.visit(number!($($number)?), see); )*)?
                    } )*
                }
            }
        }
    };
}

/// Number of a parameter; 0 for a struct, which needs none.
macro_rules! number {
    () => {
        0
    };
    ($number:ident) => {
        $number
    };
}

pub(super) use {kinds, number, parameters, value};
