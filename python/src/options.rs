//! Keyword arguments as options of the command line. A keyword is an option's name with underscores.

use lodestar::session::Options;
use lodestar::settings::options::{Form, Keyword, OPTIONS, OptionEntry, find, meaning};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList};

use crate::errors::raised;

/// Options of a new render.
pub fn of_render(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Options> {
    parsed("render", keywords, |option| option.keyword != Keyword::Nowhere)
}

/// Options of a resumed render.
pub fn of_resumed(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Options> {
    parsed("resume", keywords, |option| option.keyword == Keyword::RenderAndResume)
}

fn parsed(
    subcommand: &str,
    keywords: Option<&Bound<'_, PyDict>>,
    is_known: impl Fn(&OptionEntry) -> bool,
) -> PyResult<Options> {
    let mut arguments = Vec::new();
    for (keyword, value) in keywords.into_iter().flat_map(|keywords| keywords.iter()) {
        let keyword: String = keyword.extract()?;
        let name = keyword.replace('_', "-");
        let option = OPTIONS.iter().find(|option| option.name == name && !keyword.contains('-') && is_known(option));
        let Some(option) = option else {
            let known = OPTIONS.iter().filter(|option| is_known(option)).map(|option| option.name.replace('-', "_"));
            return Err(unknown(value.py(), subcommand, &keyword, known.collect()));
        };
        arguments.extend(argument(option, &keyword, &value)?);
    }
    lodestar::cli::options(subcommand, arguments).map_err(raised)
}

fn unknown(py: Python<'_>, subcommand: &str, keyword: &str, known: Vec<String>) -> PyErr {
    let similar = || -> PyResult<Vec<String>> {
        py.import("difflib")?.call_method1("get_close_matches", (keyword, known.clone(), 1))?.extract()
    };
    let hint = similar().ok().and_then(|names| names.into_iter().next());
    let name = keyword.replace('_', "-");
    let spell = |option: &str| match known.contains(&option.replace('-', "_")) {
        true => format!("`{}`", option.replace('-', "_")),
        false => format!("--{option} of the command line"),
    };
    let hint = match (find(&name), meaning(&name, spell), hint) {
        (Some(option), ..) => format!("; only the command line has the option --{}", option.name),
        (None, Some(meaning), _) => format!("; {meaning}"),
        (None, None, Some(name)) => format!("; did you mean `{name}`?"),
        (None, None, None) => String::new(),
    };
    PyTypeError::new_err(format!("`{keyword}` is no keyword of a {subcommand}{hint}"))
}

/// The argument that the command line would take; `None` for an option that is not given.
fn argument(option: &OptionEntry, keyword: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<String>> {
    if value.is_none() {
        return Ok(None);
    }
    let name = option.name;
    let is_switch = matches!(option.form, Form::Switch);
    if let (true, Ok(switch)) = (is_switch, value.cast::<PyBool>()) {
        return Ok(switch.is_true().then(|| format!("--{name}")));
    }
    let text = match text(value)? {
        Some(text) if !is_switch => text,
        _ => {
            let kind = value.get_type().name()?.to_string();
            return Err(PyTypeError::new_err(format!("`{keyword}` cannot be a value of the type `{kind}`")));
        }
    };
    Ok(Some(format!("--{name}={text}")))
}

/// Value as the command line spells it; `None` for a value of another kind.
fn text(value: &Bound<'_, PyAny>) -> PyResult<Option<String>> {
    if let Ok(switch) = value.extract::<bool>() {
        return Ok(Some(if switch { "on" } else { "off" }.to_owned()));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(Some(text));
    }
    if let Ok(whole) = value.extract::<i128>() {
        return Ok(Some(whole.to_string()));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Some(number.to_string()));
    }
    if value.hasattr("__fspath__")? {
        return text(&value.call_method0("__fspath__")?);
    }
    let Ok(items) = value.extract::<Vec<Bound<'_, PyAny>>>() else { return Ok(None) };
    let texts = items.iter().map(|item| Ok(item.extract::<i128>().ok().map(|number| number.to_string())));
    let texts: PyResult<Option<Vec<String>>> = texts.collect();
    Ok(texts?.map(|texts| texts.join(",")))
}

/// Every keyword of `render` and `Renderer`, one dictionary each: `name`, `help`, `words` (those that it takes, or an empty list),
/// `default` (a text, empty where there is none), `subject`, and `type` (of the keyword, as the stub writes it).
#[pyfunction]
pub fn options(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for option in OPTIONS.iter().filter(|option| option.keyword != Keyword::Nowhere) {
        let entry = PyDict::new(py);
        entry.set_item("name", option.name.replace('-', "_"))?;
        entry.set_item("help", option.long_help(None))?;
        entry.set_item("words", option.words().into_iter().map(|word| word.name).collect::<Vec<_>>())?;
        entry.set_item("default", option.default_text())?;
        entry.set_item("subject", option.category.heading())?;
        entry.set_item("type", option.python_type())?;
        list.append(entry)?;
    }
    Ok(list)
}
