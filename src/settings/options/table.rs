//! Every option of `lodestar render`, one entry each, in the order of the help.

use super::entry::{Audience, Category, Keyword, Needs, OptionEntry, Resume, Rule, Setting, When};
use super::form::Form;
use crate::settings::value::{Choice, Value, Word};
use crate::settings::{AUTO_GRID, Learner, MAX_DEPTH_LIMIT, MAX_FILM_SIDE, Mix, Sampler, UNLIMITED_DEPTH};

use Audience::{Curious, Everyone};
use Category::{Device, Guiding, Length, Output, Paths, Scene};

/// Address that only the local machine can reach, with a free port.
pub const LOCAL: &str = "127.0.0.1:0";

const PRODUCT: &[Sampler] = &[Sampler::Product];
const REJECTION_MIX: &[Sampler] = &[Sampler::RejectionMix];
const WITH_REJECTION: &[Sampler] = &[Sampler::Rejection, Sampler::RejectionMix];
const WITH_EPSILON: &[Sampler] = &[Sampler::RejectionMix, Sampler::Product];
const WITH_UNIFORM: &[Sampler] =
    &[Sampler::Rejection, Sampler::RejectionMix, Sampler::SphereInversion, Sampler::HemisphereInversion];
const WITH_NORMALS: &[Sampler] =
    &[Sampler::Product, Sampler::Rejection, Sampler::RejectionMix, Sampler::HemisphereInversion];
const WITH_CELLS: &[Sampler] = &[
    Sampler::Product,
    Sampler::Rejection,
    Sampler::RejectionMix,
    Sampler::SphereInversion,
    Sampler::HemisphereInversion,
];
const GUIDED: &[Sampler] = &[
    Sampler::Product,
    Sampler::Rejection,
    Sampler::RejectionMix,
    Sampler::SphereInversion,
    Sampler::HemisphereInversion,
    Sampler::Quadtree,
];

/// Access to the setting in a field.
macro_rules! setting {
    ($field:ident) => {
        Some(Setting {
            get: |settings| settings.$field.value(),
            set: Some(|settings, text| Choice::read(text).map(|value| settings.$field = value)),
            words: words_of(|settings| &settings.$field),
            python: type_of(|settings| &settings.$field),
        })
    };
}

/// Access to the setting in a field, for checks only. The command line reads the option itself.
macro_rules! checked {
    ($field:ident) => {
        Some(Setting {
            get: |settings| settings.$field.value(),
            set: None,
            words: words_of(|settings| &settings.$field),
            python: type_of(|settings| &settings.$field),
        })
    };
}

/// Words of the field's type.
const fn words_of<T: Choice>(_: fn(&crate::settings::Settings) -> &T) -> fn() -> Vec<Word> {
    T::words
}

/// Type in Python of the field's type.
const fn type_of<T: Choice>(_: fn(&crate::settings::Settings) -> &T) -> &'static str {
    T::PYTHON
}

/// Rule that holds for all settings.
const fn always(when: When, needs: Needs, reason: &'static str) -> Rule {
    Rule { when, needs, reason, always: true }
}

/// Rule on an option that was written down.
const fn if_given(when: When, needs: Needs) -> Rule {
    Rule { when, needs, reason: "", always: false }
}

const WITHOUT_QUADTREE: Needs = Needs::Without("--sampler quadtree", |settings| settings.sampler == Sampler::Quadtree);
const HOLDS_FLUX: &str = "a quadtree holds flux, not radiance, so it learns by monte-carlo only";
const MONTE_CARLO: &str = "--learner monte-carlo";

/// Entry without help, of an option for a new render that takes a value of its setting.
const fn option(category: Category, audience: Audience, name: &'static str, value_name: &'static str) -> OptionEntry {
    OptionEntry {
        name,
        value_name,
        category,
        audience,
        short: "",
        long: "",
        default: "",
        form: Form::Setting,
        letter: None,
        repeats: false,
        bare: "",
        requires: &[],
        excludes: &[],
        variable: "",
        resume: Resume::Fixed,
        keyword: Keyword::Render,
        range: None,
        rules: &[],
        setting: None,
    }
}

/// Entry for a file or a message. A resumed render has it, too, and Python has not.
const fn of_files(audience: Audience, name: &'static str, value_name: &'static str) -> OptionEntry {
    OptionEntry { resume: Resume::Free, keyword: Keyword::Nowhere, ..option(Output, audience, name, value_name) }
}

/// Entry of the device. A resumed render has it, too.
const fn of_device(audience: Audience, name: &'static str, value_name: &'static str) -> OptionEntry {
    OptionEntry {
        resume: Resume::Free,
        keyword: Keyword::RenderAndResume,
        ..option(Device, audience, name, value_name)
    }
}

const fn common(category: Category, name: &'static str, value_name: &'static str) -> OptionEntry {
    option(category, Audience::Everyone, name, value_name)
}

const fn further(category: Category, name: &'static str, value_name: &'static str) -> OptionEntry {
    option(category, Audience::Curious, name, value_name)
}

const fn research(category: Category, name: &'static str, value_name: &'static str) -> OptionEntry {
    option(category, Audience::Researchers, name, value_name)
}

/// Every option, in the order of the help. Options that set settings are applied in this order.
pub static OPTIONS: &[OptionEntry] = &[
    OptionEntry {
        short: "Set a `<default>` of the scene; may be given several times",
        form: Form::DEFINE,
        letter: Some('D'),
        repeats: true,
        keyword: Keyword::Nowhere,
        ..common(Scene, "D", "NAME=VALUE")
    },
    OptionEntry {
        short: "Camera of the scene",
        long: "`fit` places a camera that shows the whole scene. Others are chosen by name, or by index, counted from 0. `all` renders a \
               picture with each: out.exr becomes out.NAME.exr, or out.INDEX.exr for a camera without a name.",
        default: "the scene's first",
        form: Form::TEXT,
        keyword: Keyword::Nowhere,
        ..common(Scene, "camera", "fit|all|NAME|INDEX")
    },
    OptionEntry {
        short: "Moment of a glTF or USD animation",
        long: "The first animation of a glTF model, or a USD stage, is shown at that time in seconds. With --frames, $frame stands for the frame's number, as in '$frame/24'. It is \
               short for -D time=SECONDS.",
        default: "no animation",
        form: Form::MOMENT,
        keyword: Keyword::Nowhere,
        ..further(Scene, "scene-time", "SECONDS")
    },
    OptionEntry {
        short: "Variant of a glTF model's materials",
        long: "A model may name variants of its materials. It is short for -D variant=NAME.",
        default: "the model's default",
        form: Form::TEXT,
        keyword: Keyword::Nowhere,
        ..further(Scene, "variant", "NAME")
    },
    OptionEntry {
        short: "Environment in place of the scene's",
        long: "`constant` has the radiance 1 in all directions. An image (.exr, .hdr) covers the sphere as an `envmap` does, with \
               +y up.",
        default: "the scene's",
        form: Form::TEXT,
        keyword: Keyword::Nowhere,
        ..common(Scene, "environment", "FILE|constant")
    },
    OptionEntry {
        short: "Width of the film in pixels",
        long: "Without --height, the height keeps the scene's aspect ratio.",
        default: "the scene's",
        range: Some((1.0, MAX_FILM_SIDE as f64)),
        setting: checked!(width),
        form: Form::COUNT,
        ..common(Scene, "width", "W")
    },
    OptionEntry {
        short: "Height of the film in pixels",
        long: "Without --width, the width keeps the scene's aspect ratio.",
        default: "the scene's",
        range: Some((1.0, MAX_FILM_SIDE as f64)),
        setting: checked!(height),
        form: Form::COUNT,
        ..common(Scene, "height", "H")
    },
    OptionEntry {
        short: "Size of the film relative to the scene's",
        long: "It cannot be combined with --width and --height.",
        form: Form::ABOVE_ZERO,
        excludes: &["width", "height"],
        ..common(Scene, "scale", "F")
    },
    OptionEntry {
        short: "Render this window of the film only",
        long: "Position and size are in pixels from the film's top left corner, or in shares of the film with percent signs: \
               25%,25%,50%,50% is its middle.",
        default: "the scene's",
        form: Form::CROP,
        ..further(Scene, "crop", "X,Y,W,H")
    },
    OptionEntry {
        short: "Reconstruction filter",
        long: "A tent has radius 1, a gaussian standard deviation 0.5 pixels.",
        default: "the scene's",
        form: Form::OneOf(&["box", "tent", "gaussian"]),
        ..further(Scene, "rfilter", "box|tent|gaussian")
    },
    OptionEntry {
        short: "Picture file, such as a.exr",
        long: "It may be given several times. The name ends in .exr, .png, .jpg, .tif or .hdr. An .exr file holds every layer. --tone and --exposure make a .png or .jpg file (8 bits per channel) \
               and a .tif file (16 bits). A .hdr file (RGBE) holds linear values. The folder must exist.",
        default: "the scene's name with .exr",
        form: Form::PICTURE,
        letter: Some('o'),
        repeats: true,
        resume: Resume::Kept,
        ..of_files(Everyone, "output", "FILE")
    },
    OptionEntry {
        short: "Tone curve: srgb, paper, agx, filmic or aces",
        long: "PNG, JPEG and TIFF files have it. srgb is the sRGB transfer function; values above 1 are white. paper compresses highlights by luminance. agx is Troy \
               Sobotka's AgX in Benjamin Wrensch's form, filmic is John Hable's curve, and aces is Stephen Hill's fit.",
        default: "srgb",
        form: Form::OneOf(&["srgb", "paper", "agx", "filmic", "aces"]),
        resume: Resume::Kept,
        ..of_files(Everyone, "tone", "CURVE")
    },
    OptionEntry {
        short: "Brighten pictures by 2^STOPS",
        long: "`auto` makes 95 % of the pixels that show a surface darker than 0.8. The stops are printed. EXR and HDR files keep their values.",
        default: "auto for glTF, otherwise 0",
        form: Form::EXPOSURE,
        resume: Resume::Kept,
        ..of_files(Everyone, "exposure", "STOPS|auto")
    },
    OptionEntry {
        short: "Write the colors of EXR files as 16-bit floats",
        long: "R, G, B, A and albedo then end at 65504 and have 11 bits; the other layers keep 32 bits. `lodestar merge` refuses \
               such a picture, unless it was rendered with --sample-offset.",
        form: Form::Switch,
        ..of_files(Curious, "half", "")
    },
    OptionEntry {
        short: "Denoise the last picture by Open Image Denoise",
        long: "An .exr file has it as a layer of its own, denoised, beside the unbiased radiance; other files show it. A denoised \
               picture is biased. The library is not part of Lodestar.",
        form: Form::Switch,
        ..of_files(Everyone, "denoise", "")
    },
    OptionEntry {
        short: "Folder of Open Image Denoise 2.x",
        long: "Without it, the folder that LODESTAR_OIDN names counts, then the program's own folder, oidn within and beside that, and \
               lib beside it, and then the system's libraries.",
        form: Form::Path,
        requires: &["denoise", "view"],
        ..of_files(Curious, "oidn", "DIR")
    },
    OptionEntry {
        short: "Device that denoises",
        long: "On the processor, the bits are the same in each run.",
        default: "cpu",
        form: Form::OneOf(&["cpu", "sycl", "cuda", "hip", "metal"]),
        requires: &["denoise", "view"],
        ..of_files(Curious, "oidn-device", "cpu|sycl|cuda|hip|metal")
    },
    OptionEntry {
        short: "Replace a picture of another scene, too",
        long: "Without it, an .exr file that names another scene is an error. A picture of the same scene is always replaced.",
        form: Form::Switch,
        ..of_files(Curious, "overwrite", "")
    },
    OptionEntry {
        short: "Time between two writings of the unfinished picture",
        long: "It is in seconds, or has units, such as 1m30s.",
        form: Form::TIME,
        ..of_files(Everyone, "write-every", "TIME")
    },
    OptionEntry {
        short: "Watch the render in a browser",
        long: "The address of a page is printed. The page shows the picture, its layers and what the guide learns, and can pause or end \
               the render. The address ends in a token, without which nobody sees anything; LODESTAR_VIEW_TOKEN sets one. Without \
               a port the page has a free one, and without an address only this machine can reach it.",
        form: Form::PAGE,
        bare: LOCAL,
        ..of_files(Everyone, "view", "ADDRESS:PORT")
    },
    OptionEntry {
        short: "Send the picture to a display server such as tev",
        long: "The server has tev's protocol; tev listens at 127.0.0.1:14158. All layers are sent. The render goes on without the server.",
        form: Form::SERVER,
        ..of_files(Curious, "display-server", "HOST:PORT")
    },
    OptionEntry {
        short: "File to resume the render from after an interruption",
        long: "`lodestar resume FILE`, or the same command again, continues the render after a signal, a fault or a power cut. The \
               checkpoint of another render is refused.",
        form: Form::Path,
        ..common(Output, "checkpoint", "FILE")
    },
    OptionEntry {
        short: "Time between two writings of the checkpoint",
        long: "The checkpoint is also written when the render ends.",
        default: "60s",
        form: Form::TIME,
        requires: &["checkpoint"],
        keyword: Keyword::RenderAndResume,
        ..of_files(Curious, "checkpoint-every", "TIME")
    },
    OptionEntry {
        short: "Render several frames, such as 1-250, 1-250:2 or 1,5,9",
        long: "The frame's number stands for #### in the names of the scene and of the pictures, and for $frame in values of -D, which stand in \
               single quotes; $frame*N and $frame/N are its product and quotient with a number. The seed of a frame is --seed plus its number. Each frame begins with the \
               guide of the frame before.",
        form: Form::FRAMES,
        resume: Resume::Fixed,
        ..of_files(Everyone, "frames", "FRAMES")
    },
    OptionEntry {
        short: "Begin no frame with the guide of the frame before",
        long: "Each frame then begins without a guide, or with that of --guide.",
        form: Form::Switch,
        requires: &["frames"],
        resume: Resume::Fixed,
        ..of_files(Curious, "fresh-guide", "")
    },
    OptionEntry {
        short: "Begin with a guide that another render has learned",
        long: "FILE comes from --guide-out, or is a checkpoint. The guide learns on. Camera, size and length may differ. The other render must \
               have the same settings of the guide, and another --seed or samples before --sample-offset only. A file of --guide-out may be of \
               another scene, about which Lodestar warns.",
        form: Form::Path,
        ..further(Output, "guide", "FILE")
    },
    OptionEntry {
        short: "Write what the guide has learned when the render ends",
        long: "The name must end in .guide. Other renders begin with it (--guide). `lodestar info` tells what it knows, and `lodestar merge` \
               merges guides.",
        form: Form::GUIDE,
        ..of_files(Curious, "guide-out", "FILE.guide")
    },
    OptionEntry {
        short: "Form of the messages on standard error",
        long: "json is one object per line, for programs.",
        default: "text",
        form: Form::OneOf(&["text", "json"]),
        ..of_files(Curious, "log", "text|json")
    },
    OptionEntry { short: "Show no progress", form: Form::Switch, letter: Some('q'), ..of_files(Everyone, "quiet", "") },
    OptionEntry {
        short: "Measure the error against this picture during the render",
        long: "The errors are written to --stats.",
        form: Form::Path,
        ..of_files(Curious, "reference", "REF.exr")
    },
    OptionEntry {
        short: "Write settings, times and counts of every step as JSON",
        form: Form::Path,
        ..of_files(Curious, "stats", "STATS.json")
    },
    OptionEntry {
        short: "Time every dispatch, and write a trace to this file",
        long: "A table of the times is printed at the end. ui.perfetto.dev and chrome://tracing open the trace.",
        form: Form::Path,
        ..of_files(Curious, "profile", "TRACE.json")
    },
    OptionEntry {
        short: "Samples per pixel",
        long: "With --time or --noise there is no default: these end the render.",
        default: "the scene's, or 64",
        form: Form::COUNT,
        resume: Resume::Kept,
        keyword: Keyword::RenderAndResume,
        ..common(Length, "spp", "N")
    },
    OptionEntry {
        short: "Stop after this time of rendering, such as 90, 1m30s or 2h",
        long: "A number without a unit is in seconds. Loading the scene does not count.",
        form: Form::TIME,
        resume: Resume::Free,
        keyword: Keyword::RenderAndResume,
        ..common(Length, "time", "TIME")
    },
    OptionEntry {
        short: "Stop each tile at this relative error, such as 0.05",
        long: "A tile of 8 x 8 pixels is sampled until its estimated relative error, and that of its neighbors, is at most TARGET. \
               The picture is then consistent, not unbiased. --spp and --time still end the render.",
        range: Some((1.0e-4, 1.0)),
        setting: setting!(noise),
        rules: &[always(
            When::Any,
            Needs::Without("--sample-offset", |settings| settings.sample_offset.is_some()),
            "it would end each part of a picture at another sample, so give every part an --spp",
        )],
        ..common(Length, "noise", "TARGET")
    },
    OptionEntry {
        short: "How directions are sampled, such as product or bsdf",
        setting: Some(Setting {
            get: |settings| settings.sampler.value(),
            set: Some(|settings, text| {
                settings.sampler = Choice::read(text)?;
                settings.learner = settings.sampler.default_learner();
                settings.min_uniform = settings.sampler.default_min_uniform();
                Ok(())
            }),
            words: <Sampler as Choice>::words,
            python: "str",
        }),
        ..common(Guiding, "sampler", "SAMPLER")
    },
    OptionEntry {
        short: "Longest path in edges; 1 shows emission only",
        long: "With unlimited, Russian roulette ends every path and no light is lost: a path has more than 1024 edges less than \
               once in 10^19 times. A number cuts light off that travels further.",
        default: "the scene's, or unlimited",
        range: Some((1.0, MAX_DEPTH_LIMIT as f64)),
        setting: Some(Setting {
            get: |settings| match settings.max_depth {
                UNLIMITED_DEPTH => Value::Word("unlimited".into()),
                number => number.value(),
            },
            set: None,
            words: Vec::new,
            python: "int",
        }),
        form: Form::DEPTH,
        ..common(Paths, "max-depth", "N|unlimited")
    },
    OptionEntry {
        short: "Number of edges after which Russian roulette may end a path",
        long: "Roulette ends dim paths by chance and weights the survivors, so the picture's mean stays. The number counts with \
               --roulette throughput. With --roulette contribution it counts on surfaces without a guide only.",
        default: "the scene's, or 8",
        range: Some((1.0, u32::MAX as f64)),
        setting: checked!(rr_depth),
        form: Form::NUMBER,
        ..further(Paths, "rr-depth", "N")
    },
    OptionEntry {
        short: "Sample emitters at every vertex of a path",
        long: "This is next event estimation.",
        setting: setting!(nee),
        ..common(Paths, "nee", "on|off")
    },
    OptionEntry {
        short: "Seed of the random numbers",
        long: "The same seed gives the same pixels.",
        setting: setting!(seed),
        ..common(Paths, "seed", "N")
    },
    OptionEntry {
        short: "How the samples of a pixel are distributed",
        setting: setting!(pattern),
        ..further(Paths, "pattern", "PATTERN")
    },
    OptionEntry {
        short: "Begin with sample K of every pixel; the first is 0",
        long: "It is for a part of a picture; `lodestar merge` puts the parts together.",
        setting: setting!(sample_offset),
        ..further(Paths, "sample-offset", "K")
    },
    OptionEntry {
        short: "Surfaces that are guided",
        setting: setting!(guide_set),
        rules: &[if_given(When::Any, Needs::Samplers(GUIDED))],
        ..research(Guiding, "guide-set", "SET")
    },
    OptionEntry {
        short: "How the guide learns",
        default: "monte-carlo with the sampler quadtree, else sarsa",
        setting: setting!(learner),
        rules: &[
            always(When::Word("sarsa"), WITHOUT_QUADTREE, HOLDS_FLUX),
            always(When::Word("expected-sarsa"), WITHOUT_QUADTREE, HOLDS_FLUX),
            always(When::Word("expected-sarsa"), Needs::Samplers(WITH_CELLS), ""),
            always(When::Word("monte-carlo"), Needs::Samplers(GUIDED), ""),
            if_given(When::Any, Needs::Samplers(GUIDED)),
        ],
        ..research(Guiding, "learner", "LEARNER")
    },
    OptionEntry {
        short: "Directions over which expected-sarsa takes its mean",
        range: Some((1.0, 4096.0)),
        setting: setting!(expected_directions),
        rules: &[if_given(When::Any, Needs::Learners(&[Learner::ExpectedSarsa]))],
        ..research(Guiding, "expected-directions", "N")
    },
    OptionEntry {
        short: "Quantities that rejection-mix mixes with the uniform share",
        setting: setting!(mix),
        rules: &[
            always(When::Word("acceptance"), Needs::Samplers(REJECTION_MIX), ""),
            if_given(When::Any, Needs::Samplers(REJECTION_MIX)),
        ],
        ..research(Guiding, "mix", "MIX")
    },
    OptionEntry {
        short: "Share that is mixed with the guide",
        long: "With the sampler rejection-mix it is the share of uniform directions, by default the optimal one (Eq. 8). With the \
               sampler product it is the share of the surface's BSDF, by default the share that each cell learns.",
        range: Some((1.0e-4, 1.0)),
        setting: setting!(epsilon),
        rules: &[always(When::Any, Needs::Samplers(WITH_EPSILON), "")],
        ..research(Guiding, "epsilon", "E")
    },
    OptionEntry {
        short: "Share of product's samples that the BSDF draws",
        long: "This share is also known as the BSDF sampling fraction.",
        default: "fixed with --epsilon or the learner monte-carlo, else learned",
        setting: setting!(bsdf_share),
        rules: &[
            always(When::Any, Needs::Samplers(PRODUCT), ""),
            always(
                When::Word("learned"),
                Needs::Without("--epsilon", |settings| settings.epsilon.is_some()),
                "--epsilon fixes the share",
            ),
            always(
                When::Word("learned"),
                Needs::Without(MONTE_CARLO, |settings| settings.learner == Learner::MonteCarlo),
                "this learner keeps no statistics of the share",
            ),
        ],
        ..research(Guiding, "bsdf-share", "SHARE")
    },
    OptionEntry {
        short: "Probabilities with which emitter sampling draws lights",
        default: "learned with the sampler product, else power",
        setting: setting!(light_selection),
        rules: &[always(When::Word("learned"), Needs::Samplers(PRODUCT), "")],
        ..research(Guiding, "light-selection", "SELECTION")
    },
    OptionEntry {
        short: "Quantity that Russian roulette compares with",
        default: "contribution with the sampler product if --rr-depth is less than --max-depth, else throughput",
        setting: setting!(roulette),
        rules: &[always(When::Word("contribution"), Needs::Samplers(PRODUCT), "")],
        ..research(Guiding, "roulette", "ROULETTE")
    },
    OptionEntry {
        short: "Map between directions and their bins",
        setting: setting!(map),
        rules: &[if_given(When::Any, Needs::Samplers(GUIDED))],
        ..research(Guiding, "map", "MAP")
    },
    OptionEntry {
        short: "Cells of the guide along each axis, or auto",
        long: "auto takes the finest cubes whose guide fits 8, 16, 32 or 64 MiB: the first of these that has 128 bytes for each \
               pixel of the whole picture, or the last. The trees of the sampler quadtree have at most as many nodes as a grid of \
               this size has bins.",
        default: "auto with the sampler product, unless --fallback is 0; else 8",
        range: Some((1.0, 32.0)),
        setting: Some(Setting {
            get: |s| if s.grid == Some(AUTO_GRID) { Value::Word("auto".into()) } else { s.grid.value() },
            set: Some(|settings, text| {
                let number = || text.parse().map_err(|_| "give a whole number or auto".to_owned());
                settings.grid = Some(if text == "auto" { AUTO_GRID } else { number()? });
                Ok(())
            }),
            words: Vec::new,
            python: "int | Literal[\"auto\"]",
        }),
        rules: &[
            always(When::Word("auto"), WITHOUT_QUADTREE, "quadtrees have no cells"),
            if_given(When::Any, Needs::Samplers(GUIDED)),
        ],
        ..research(Guiding, "grid", "N|auto")
    },
    OptionEntry {
        short: "How much a cell borrows from larger cells around it",
        long: "A bin mixes its own mean with the estimate of its parent cell, as if that estimate were the mean of K targets. So \
               the parent counts for much in a bin with few targets, and for little in a bin with many. The parent's estimate \
               is first scaled by how bright the cell has found the directions around the bin. With 0 a cell uses its own \
               targets only.",
        default: "16 with the sampler product, else 0",
        range: Some((0.0, 1.0e6)),
        setting: setting!(fallback),
        rules: &[
            always(When::AboveZero, WITHOUT_QUADTREE, "quadtrees have no cells"),
            if_given(When::AboveZero, Needs::Samplers(WITH_CELLS)),
        ],
        ..research(Guiding, "fallback", "K")
    },
    OptionEntry {
        short: "Direction bins of a cell along each axis",
        range: Some((4.0, 64.0)),
        setting: setting!(directions),
        rules: &[
            always(
                When::Any,
                Needs::Value("16, 32 or 64 with the sampler product", |settings| {
                    settings.sampler != Sampler::Product || matches!(settings.directions, 16 | 32 | 64)
                }),
                "this sampler descends in steps of four",
            ),
            if_given(When::Any, Needs::Samplers(GUIDED)),
        ],
        ..research(Guiding, "directions", "N")
    },
    OptionEntry {
        short: "Normal bins of a cell along each axis",
        range: Some((4.0, 32.0)),
        setting: setting!(normals),
        rules: &[if_given(When::Any, Needs::Samplers(WITH_NORMALS))],
        ..research(Guiding, "normals", "N")
    },
    OptionEntry {
        short: "Most samples per pixel between two updates of the guide",
        range: Some((1.0, 65_536.0)),
        setting: setting!(spp_per_step),
        ..research(Guiding, "spp-per-step", "N")
    },
    OptionEntry {
        short: "Number of samples per pixel between updates of the guide",
        setting: setting!(steps),
        rules: &[if_given(When::Word("growing"), Needs::Samplers(WITH_CELLS))],
        ..research(Guiding, "steps", "STEPS")
    },
    OptionEntry {
        short: "Weights of the samples in the picture",
        default: "growing with the sampler product, without --noise and --sample-offset; else even",
        setting: setting!(sample_weights),
        rules: &[
            always(When::Word("growing"), Needs::Samplers(GUIDED), "without a guide, no sample is better than another"),
            always(
                When::Word("growing"),
                Needs::Without("--noise", |settings| settings.noise.is_some()),
                "the error is estimated from samples of equal weight",
            ),
            always(
                When::Word("growing"),
                Needs::Without("--sample-offset", |settings| settings.sample_offset.is_some()),
                "parts of a picture are averaged by their numbers of samples",
            ),
        ],
        ..research(Guiding, "sample-weights", "WEIGHTS")
    },
    OptionEntry {
        short: "How much of its past a bin of the guide keeps at each step",
        long: "A bin's mean runs over all of its targets. Before each update the number of its earlier targets is multiplied by D, \
               so that later ones, which a better guide found, count for more. With 1 all count the same, as in the paper.",
        range: Some((0.0, 1.0)),
        setting: setting!(decay),
        rules: &[if_given(When::Any, Needs::Samplers(WITH_CELLS))],
        ..research(Guiding, "decay", "D")
    },
    OptionEntry {
        short: "Tries of rejection before it takes a uniform direction",
        range: Some((1.0, 1024.0)),
        setting: setting!(max_tries),
        rules: &[if_given(When::Any, Needs::Samplers(WITH_REJECTION))],
        ..research(Guiding, "max-tries", "K")
    },
    OptionEntry {
        short: "Least share of uniform directions in the guide",
        long: "The inversion samplers seldom sample light that the guide does not know yet, and such a sample is weighted by up to \
               2/E at every edge. So they have 0.5 where no share is given, and the default below is that of the rejection samplers. With \
               0.0625, most of their picture is too dark, and a few pixels are far too bright.",
        range: Some((1.0e-4, 1.0)),
        setting: setting!(min_uniform),
        rules: &[
            if_given(When::Any, Needs::Samplers(WITH_UNIFORM)),
            if_given(
                When::Any,
                Needs::Without("--epsilon, which fixes the share of mixed densities", |settings| {
                    settings.epsilon.is_some() && settings.mix == Mix::Density
                }),
            ),
        ],
        ..research(Guiding, "min-uniform", "E")
    },
    OptionEntry {
        short: "Vulkan device by index or part of its name, a list, or all",
        long: "`lodestar devices` lists the devices. The environment variable LODESTAR_DEVICE sets the default. Several \
               devices of one kind render the picture together, with the bits of one device.",
        form: Form::TEXT,
        variable: "LODESTAR_DEVICE",
        ..of_device(Everyone, "device", "INDEX|NAME|LIST|all")
    },
    OptionEntry {
        short: "Deal out tiles to several devices by measured speed",
        long: "Otherwise all devices get equally many tiles, so the slowest one sets the pace. Devices of different kinds then \
               render the picture with last bits that depend on what was measured.",
        form: Form::Switch,
        ..of_device(Curious, "deal-by-speed", "")
    },
    OptionEntry {
        short: "Wanted duration of a dispatch in milliseconds",
        default: "50 on a GPU, 150 on a CPU",
        range: Some((0.001, 60_000.0)),
        setting: checked!(slice_milliseconds),
        form: Form::MILLISECONDS,
        ..of_device(Curious, "slice-ms", "MS")
    },
    OptionEntry {
        short: "Kernels that trace the paths",
        long: "With --kernel-dir, auto is megakernel.",
        setting: checked!(execution),
        rules: &[
            always(
                When::Word("wavefront"),
                Needs::Without("--noise", |settings| settings.noise.is_some()),
                "take --execution megakernel",
            ),
            always(
                When::Word("wavefront"),
                Needs::Without("--sampler quadtree", |settings| settings.sampler == Sampler::Quadtree),
                "a quadtree keeps all vertices of a path, so take --execution megakernel",
            ),
            always(
                When::Word("wavefront"),
                Needs::Without(MONTE_CARLO, |settings| {
                    settings.sampler != Sampler::Bsdf && settings.learner == Learner::MonteCarlo
                }),
                "that learner keeps all vertices of a path, so take --execution megakernel",
            ),
        ],
        form: Form::OneOf(&["auto", "megakernel", "wavefront"]),
        ..of_device(Curious, "execution", "EXECUTION")
    },
    OptionEntry {
        short: "What finds the surface that a ray hits",
        setting: checked!(traversal),
        form: Form::OneOf(&["compute", "query", "auto"]),
        resume: Resume::Kept,
        ..of_device(Curious, "traversal", "TRAVERSAL")
    },
    OptionEntry {
        short: "Most samples per pixel that one kernel call takes",
        long: "Where the driver cuts a loop short, as old versions of lavapipe do, the render begins again with half as \
               many. Take more on a fast GPU.",
        range: Some((1.0, 64.0)),
        setting: setting!(samples_per_dispatch),
        ..further(Device, "samples-per-dispatch", "N")
    },
    OptionEntry {
        short: "Take edited kernels from the .spv files of this folder",
        long: "`lodestar inspect --out` writes the kernels as files.",
        form: Form::Path,
        ..of_device(Curious, "kernel-dir", "DIR")
    },
    OptionEntry {
        short: "Turn Vulkan's validation layer on",
        form: Form::Switch,
        keyword: Keyword::Render,
        ..of_device(Curious, "validate", "")
    },
];
