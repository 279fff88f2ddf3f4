//! Words of the settings and of other choices as values of the command line's arguments.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use lodestar::denoise::DeviceKind;
use lodestar::generated::kernels::BackEnd;
use lodestar::image::ToneCurve;
use lodestar::reproduce::Target;
use lodestar::settings::{Execution, SamplePattern, Sampler, Traversal, Words};
use strum::VariantArray;

macro_rules! values {
    ($($choice:ty),*) => {$(
        impl ValueEnum for $choice {
            fn value_variants<'a>() -> &'a [Self] {
                Self::VARIANTS
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(PossibleValue::new(self.word()).help(self.help()))
            }
        }
    )*};
}

values!(BackEnd, DeviceKind, Execution, SamplePattern, Sampler, Target, ToneCurve, Traversal);
