//! Parameters of a directive: `"type name"` with its values.

use std::cell::Cell;
use std::rc::Rc;

use glam::{Vec2, Vec3};

use super::tokens::{Place, Token, Tokens, brief};
use crate::Result;

/// Most values of one parameter. No device can address so many vertices.
const MAX_VALUES: usize = 1 << 28;

/// Values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Booleans(Vec<bool>),
}

/// One parameter.
#[derive(Debug, Clone)]
pub(super) struct Parameter {
    /// Type as the file names it, such as `float` or `texture`.
    pub kind: String,
    pub name: String,
    pub values: Values,
    pub place: Place,
}

impl Parameter {
    pub fn error(&self, message: impl std::fmt::Display) -> crate::Error {
        self.place.error(format!("the parameter `{}` {message}", brief(&self.name)))
    }

    /// The values as numbers.
    pub fn numbers(&self) -> Result<&[f64]> {
        match &self.values {
            Values::Numbers(numbers) => Ok(numbers),
            _ => Err(self.error("should have numbers")),
        }
    }

    /// The only number.
    pub fn number(&self) -> Result<f64> {
        match self.numbers()? {
            [number] => Ok(*number),
            numbers => Err(self.error(format!("should have one number, not {}", numbers.len()))),
        }
    }

    /// The only text.
    pub fn text(&self) -> Result<&str> {
        match &self.values {
            Values::Texts(texts) if texts.len() == 1 => Ok(&texts[0]),
            _ => Err(self.error("should have one text between quotes")),
        }
    }

    /// Exactly three numbers.
    pub fn three(&self) -> Result<[f64; 3]> {
        let numbers = self.numbers()?;
        numbers.try_into().map_err(|_| self.error(format!("should have three numbers, not {}", numbers.len())))
    }
}

/// Most parameters of one directive, and of all `Attribute` directives for one kind. pbrt's plugins have up to 30.
pub(super) const MAX_PARAMETERS: usize = 256;

/// Parameters of one directive, and of the `Attribute` directives that apply to it.
#[derive(Debug, Clone)]
pub(super) struct Parameters {
    /// Place of the directive.
    pub place: Place,
    /// Directive with its type, for messages.
    pub owner: String,
    own: Vec<(Parameter, Cell<bool>)>,
    /// Parameters that hold where the directive does not give its own.
    defaults: Rc<Vec<Rc<Parameter>>>,
}

impl Parameters {
    /// Reads the parameters that follow a directive.
    pub fn read(tokens: &mut Tokens, place: Place, owner: String) -> Result<Self> {
        let mut own: Vec<(Parameter, Cell<bool>)> = Vec::new();
        while let Some(Token::Quoted(_)) = tokens.peek()? {
            let parameter = read_parameter(tokens)?;
            if own.iter().any(|(other, _)| other.name == parameter.name) {
                return Err(parameter.error(format!("of {owner} is given twice")));
            }
            if own.len() == MAX_PARAMETERS {
                return Err(place.error(format!("{owner} has more than {MAX_PARAMETERS} parameters; leave some out")));
            }
            own.push((parameter, Cell::new(false)));
        }
        Ok(Self { place, owner, own, defaults: Rc::default() })
    }

    /// The parameters with others that hold where these are silent.
    pub fn with_defaults(self, defaults: &Rc<Vec<Rc<Parameter>>>) -> Self {
        Self { defaults: Rc::clone(defaults), ..self }
    }

    /// Number of the directive's own parameters.
    pub fn count(&self) -> usize {
        self.own.len()
    }

    /// Takes one of the directive's own parameters away.
    pub fn remove(&mut self, name: &str) -> Option<Parameter> {
        let at = self.own.iter().position(|(parameter, _)| parameter.name == name)?;
        Some(self.own.remove(at).0)
    }

    /// Gives one of the directive's own parameters another name. Returns whether it is there.
    pub fn rename(&mut self, old: &str, new: &str) -> bool {
        let found = self.remove(old);
        let is_there = found.is_some();
        if let Some(parameter) = found {
            self.set(&parameter.kind, new, parameter.values);
        }
        is_there
    }

    /// Sets a parameter, at the place of the directive.
    pub fn set(&mut self, kind: &str, name: &str, values: Values) {
        self.remove(name);
        let parameter = Parameter { kind: kind.to_owned(), name: name.to_owned(), values, place: self.place.clone() };
        self.own.push((parameter, Cell::new(false)));
    }

    /// Sets a parameter that is not given.
    pub fn default(&mut self, kind: &str, name: &str, values: Values) {
        if !self.has(name) {
            self.set(kind, name, values);
        }
    }

    /// Whether the parameter is given by a texture.
    pub fn is_texture(&self, name: &str) -> bool {
        self.get(name).is_some_and(|parameter| parameter.kind == "texture")
    }

    /// The parameters alone, which many directives can share.
    pub fn into_list(self) -> Vec<Rc<Parameter>> {
        self.own.into_iter().map(|(parameter, _)| Rc::new(parameter)).collect()
    }

    pub fn error(&self, message: impl Into<String>) -> crate::Error {
        self.place.error(message)
    }

    /// Parameter of that name, which then counts as read.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        match self.own.iter().find(|(parameter, _)| parameter.name == name) {
            Some((parameter, is_read)) => {
                is_read.set(true);
                Some(parameter)
            }
            None => self.defaults.iter().find(|parameter| parameter.name == name).map(Rc::as_ref),
        }
    }

    /// Whether the parameter is given.
    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    pub fn number(&self, name: &str, default: f64) -> Result<f64> {
        self.get(name).map_or(Ok(default), Parameter::number)
    }

    pub fn numbers(&self, name: &str) -> Result<Option<&[f64]>> {
        self.get(name).map(Parameter::numbers).transpose()
    }

    /// A number greater than 0.
    pub fn positive(&self, name: &str, default: f64) -> Result<f64> {
        let value = self.number(name, default)?;
        match (self.get(name), value > 0.0) {
            (Some(parameter), false) => Err(parameter.error(format!("must be greater than 0, not {value}"))),
            _ => Ok(value),
        }
    }

    /// A whole number in a range.
    pub fn integer(&self, name: &str, range: std::ops::RangeInclusive<i64>) -> Result<Option<i64>> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        let value = parameter.number()?;
        if value.fract() == 0.0 && (*range.start() as f64..=*range.end() as f64).contains(&value) {
            return Ok(Some(value as i64));
        }
        Err(parameter.error(format!("must be a whole number in {}..{}, not {value}", range.start(), range.end())))
    }

    pub fn text(&self, name: &str) -> Result<Option<&str>> {
        self.get(name).map(Parameter::text).transpose()
    }

    pub fn boolean(&self, name: &str, default: bool) -> Result<bool> {
        let Some(parameter) = self.get(name) else { return Ok(default) };
        match &parameter.values {
            Values::Booleans(values) if values.len() == 1 => Ok(values[0]),
            // pbrt-v3 puts the word between quotes.
            Values::Texts(texts) if texts.len() == 1 && texts[0] == "true" => Ok(true),
            Values::Texts(texts) if texts.len() == 1 && texts[0] == "false" => Ok(false),
            _ => Err(parameter.error("should be true or false")),
        }
    }

    /// A point or a vector.
    pub fn point(&self, name: &str) -> Result<Option<[f64; 3]>> {
        self.get(name).map(Parameter::three).transpose()
    }

    /// Points, vectors or normals; empty where none are given.
    pub fn points(&self, name: &str) -> Result<Vec<Vec3>> {
        let rows = self.rows::<3>(name)?;
        Ok(rows.into_iter().map(|row| Vec3::from_array(row.map(|value| value as f32))).collect())
    }

    /// Points of the plane; empty where none are given.
    pub fn points_2d(&self, name: &str) -> Result<Vec<Vec2>> {
        let rows = self.rows::<2>(name)?;
        Ok(rows.into_iter().map(|row| Vec2::from_array(row.map(|value| value as f32))).collect())
    }

    fn rows<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>> {
        let Some(parameter) = self.get(name) else { return Ok(Vec::new()) };
        let (rows, rest) = parameter.numbers()?.as_chunks::<N>();
        match rest.is_empty() {
            true => Ok(rows.to_vec()),
            false => Err(parameter.error(format!("should have {N} numbers for each point: some are missing"))),
        }
    }

    /// Indices of vertices below `count`.
    pub fn indices(&self, name: &str, count: usize) -> Result<Option<Vec<u32>>> {
        let Some(parameter) = self.get(name) else { return Ok(None) };
        let index = |&value: &f64| match value.fract() == 0.0 && (0.0..count as f64).contains(&value) {
            true => Ok(value as u32),
            false => Err(parameter.error(format!("has the index {value}, but there are {count} vertices"))),
        };
        parameter.numbers()?.iter().map(index).collect::<Result<_>>().map(Some)
    }

    /// Warnings about the directive's own parameters that nobody has read. They come once.
    pub fn unread(&self) -> impl Iterator<Item = String> + '_ {
        let unread = self.own.iter().filter(|(_, is_read)| !is_read.replace(true));
        unread.map(|(parameter, _)| {
            format!(
                "{}: the parameter `{}` of {} is not known; ignored",
                parameter.place,
                brief(&parameter.name),
                self.owner
            )
        })
    }

    /// Drops all parameters but these.
    pub fn keep_only(&mut self, names: &[&str]) {
        self.own.retain(|(parameter, _)| names.contains(&parameter.name.as_str()));
    }

    /// Counts parameters as read that have no effect on the picture.
    pub fn ignore(&self, names: &[&str]) {
        names.iter().for_each(|name| _ = self.get(name));
    }
}

fn read_parameter(tokens: &mut Tokens) -> Result<Parameter> {
    let declaration = tokens.quoted("a parameter")?.into_owned();
    let place = tokens.place();
    let mut words = declaration.split_ascii_whitespace();
    let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
        return Err(
            place.error(format!("\"{}\" should be a type and a name, such as \"float fov\"", brief(&declaration)))
        );
    };
    let mut parameter =
        Parameter { kind: kind.to_owned(), name: name.to_owned(), values: Values::Numbers(Vec::new()), place };
    match tokens.require("the value of a parameter")? {
        Token::Open => {
            let mut count = 0;
            loop {
                match tokens.require("`]`")? {
                    Token::Close => break,
                    token => add(tokens, &mut parameter, &token, count)?,
                }
                count += 1;
            }
        }
        token => add(tokens, &mut parameter, &token, 0)?,
    }
    Ok(parameter)
}

/// Adds the value that a token writes.
fn add(tokens: &Tokens, parameter: &mut Parameter, token: &Token, count: usize) -> Result<()> {
    let wrong = |parameter: &Parameter| {
        let message = format!("{token} cannot be a value of the parameter `{}` here", brief(&parameter.name));
        tokens.place().error(message)
    };
    if count >= MAX_VALUES {
        return Err(parameter.error(format!("has more than {MAX_VALUES} values")));
    }
    if count == 0 {
        parameter.values = match token {
            Token::Quoted(_) => Values::Texts(Vec::new()),
            Token::Word("true" | "false") => Values::Booleans(Vec::new()),
            _ => Values::Numbers(Vec::new()),
        };
    }
    match (&mut parameter.values, token) {
        (Values::Texts(texts), Token::Quoted(text)) => texts.push(text.to_string()),
        (Values::Booleans(values), Token::Word(word @ ("true" | "false"))) => values.push(*word == "true"),
        (Values::Numbers(numbers), token) => match tokens.number(token) {
            Some(number) => numbers.push(number),
            None => return Err(wrong(parameter)),
        },
        _ => return Err(wrong(parameter)),
    }
    Ok(())
}
