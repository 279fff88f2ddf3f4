//! Names that options have in other renderers, with what is meant by them here.

/// Names, and what people mean by them: an option and what it sets, or a sentence without an option.
struct OtherNames {
    names: &'static [&'static str],
    option: &'static str,
    what: &'static str,
}

const fn other(names: &'static [&'static str], option: &'static str, what: &'static str) -> OtherNames {
    OtherNames { names, option, what }
}

const OTHER_NAMES: &[OtherNames] = &[
    other(&["samples", "sample-count", "pixelsamples", "render-samples"], "spp", "the samples per pixel"),
    other(&["resolution", "res", "size"], "width", "the width of the picture in pixels; its height is another option"),
    other(&["bounces", "max-bounces", "depth"], "max-depth", "the longest path in edges"),
    other(&["integrator", "renderer"], "sampler", "how directions are drawn: product is guided, bsdf is not"),
    other(
        &["noise-threshold", "adaptive-threshold", "error", "quality"],
        "noise",
        "the noise at which the render ends",
    ),
    other(&["time-limit", "max-time", "timeout", "seconds"], "time", "the time after which the render ends"),
    other(&["guide-from"], "guide", "the guide that the render begins with"),
    other(&["out", "outfile", "output-file", "filename"], "output", "the picture's file"),
    other(&["denoiser", "oidn-denoise"], "denoise", "that the picture is denoised"),
    other(&["gpu", "gpus", "cpu", "backend"], "device", "the device; `lodestar devices` lists them"),
    other(&["interactive", "gui", "preview", "display"], "view", "that a browser shows the render"),
    other(
        &["threads", "nthreads", "num-threads", "jobs"],
        "",
        "the device uses all its cores; the variable LP_NUM_THREADS sets the threads of lavapipe, RAYON_NUM_THREADS those of reading scenes",
    ),
    other(&["frame", "animation", "frame-start", "frame-range"], "frames", "the frames to render"),
];

/// Meaning of the option `name` of another renderer, as a clause; `None` if it is not known. `spell` writes the name of an option of Lodestar.
pub fn meaning(name: &str, spell: impl Fn(&str) -> String) -> Option<String> {
    let OtherNames { option, what, .. } = OTHER_NAMES.iter().find(|other| other.names.contains(&name))?;
    Some(if option.is_empty() { (*what).to_owned() } else { format!("{} sets {what}", spell(option)) })
}

#[cfg(test)]
mod tests {
    use super::super::find;
    use super::*;

    #[test]
    fn other_names_are_no_options_and_mean_one() {
        for OtherNames { names, option, .. } in OTHER_NAMES {
            assert!(option.is_empty() || find(option).is_some(), "{option}");
            assert!(names.iter().all(|name| find(name).is_none()), "{names:?}");
        }
        let spell = |name: &str| format!("--{name}");
        assert_eq!(meaning("samples", spell).as_deref(), Some("--spp sets the samples per pixel"));
        assert_eq!(meaning("sample", spell), None);
    }
}
