//! Values of settings as text, as the command line and the pictures' attributes spell them.

use strum::{EnumMessage, VariantArray};

use super::{
    BsdfShare, DirectionMap, Execution, GuideSet, Learner, LightSelection, Mix, Roulette, SamplePattern, SampleWeights,
    Sampler, StepSchedule, Traversal,
};

/// Value of one setting.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// No value was chosen.
    Nothing,
    /// A number.
    Number(f64),
    /// A word among several.
    Word(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Nothing => f.write_str("nothing"),
            Self::Number(number) => number.fmt(f),
            Self::Word(word) => f.write_str(word),
        }
    }
}

/// A word that an option takes, and its meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Word {
    /// Spelling of the word.
    pub name: String,
    /// Meaning of the word, one sentence or two.
    pub help: String,
}

/// Type whose values are words: the variants' names in kebab case. Their doc comments are the words' meanings.
pub trait Words: Copy + EnumMessage + Into<&'static str> + VariantArray {
    /// Words of all values, in the order of the declaration.
    fn all_words() -> Vec<Word> {
        Self::VARIANTS.iter().map(|value| Word { name: value.word().to_owned(), help: value.help() }).collect()
    }

    /// Value that a word stands for.
    fn of_word(word: &str) -> Option<Self> {
        Self::VARIANTS.iter().copied().find(|value| value.word() == word)
    }

    /// Word that stands for the value.
    fn word(self) -> &'static str {
        self.into()
    }

    /// Meaning of the word: the first paragraph of the doc comment, without the last period.
    fn help(&self) -> String {
        let lines = self.get_documentation().unwrap_or_default().lines().map(str::trim);
        let paragraph = lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        paragraph.strip_suffix('.').map_or_else(|| paragraph.clone(), str::to_owned)
    }
}

impl<T: Copy + EnumMessage + Into<&'static str> + VariantArray> Words for T {}

/// A type that an option's value may have.
pub(super) trait Choice: Sized {
    /// Type of the value in Python; `str` where it takes words.
    const PYTHON: &'static str = "str";

    /// Words that can be written; none where numbers are.
    fn words() -> Vec<Word> {
        Vec::new()
    }

    /// Value that `text` stands for.
    fn read(text: &str) -> Result<Self, String>;

    /// Value as a number or a word.
    fn value(&self) -> Value;
}

macro_rules! numbers {
    ($($number:ty: $expected:literal, $python:literal,)*) => {$(
        impl Choice for $number {
            const PYTHON: &'static str = $python;

            fn read(text: &str) -> Result<Self, String> {
                text.parse().map_err(|_| concat!("give ", $expected).to_owned())
            }

            fn value(&self) -> Value {
                // By way of its text, an `f32` of 0.1 stays 0.1.
                Value::Number(self.to_string().parse().unwrap_or(f64::NAN))
            }
        }
    )*};
}

numbers! {
    u32: "a whole number of at least 0", "int",
    f32: "a number", "float",
    f64: "a number", "float",
}

macro_rules! words {
    ($($words:ty),*) => {$(
        impl Choice for $words {
            fn words() -> Vec<Word> {
                Self::all_words()
            }

            fn read(text: &str) -> Result<Self, String> {
                Self::of_word(text).ok_or_else(|| one_of(&Self::all_words(), text))
            }

            fn value(&self) -> Value {
                Value::Word(self.word().to_owned())
            }
        }
    )*};
}

words!(BsdfShare, DirectionMap, Execution, GuideSet, Learner, LightSelection, Mix, Roulette, SamplePattern);
words!(SampleWeights, Sampler, StepSchedule, Traversal);

/// Least similarity of a word to a text that may mean it.
const SIMILAR: f64 = 0.7;

/// Request for one of `words` in place of `text`, with the word that is most similar to `text`.
fn one_of(words: &[Word], text: &str) -> String {
    let names: Vec<_> = words.iter().map(|word| &word.name[..]).collect();
    let similarity = |name: &str| strsim::jaro_winkler(&text.to_lowercase(), name);
    let closest = names.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    match closest.filter(|name| similarity(name) >= SIMILAR) {
        Some(name) => format!("give one of {} (did you mean {name}?)", names.join(", ")),
        None => format!("give one of {}", names.join(", ")),
    }
}

impl Choice for bool {
    const PYTHON: &'static str = "bool";

    fn words() -> Vec<Word> {
        ["on", "off"].map(|name| Word { name: name.into(), help: String::new() }).into()
    }

    fn read(text: &str) -> Result<Self, String> {
        match text {
            "on" => Ok(true),
            "off" => Ok(false),
            _ => Err("give on or off".into()),
        }
    }

    fn value(&self) -> Value {
        Value::Word(if *self { "on" } else { "off" }.into())
    }
}

impl<T: Choice> Choice for Option<T> {
    const PYTHON: &'static str = T::PYTHON;

    fn words() -> Vec<Word> {
        T::words()
    }

    fn read(text: &str) -> Result<Self, String> {
        T::read(text).map(Some)
    }

    fn value(&self) -> Value {
        self.as_ref().map_or(Value::Nothing, T::value)
    }
}
