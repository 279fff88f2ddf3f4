//! The page in headless Chromium.

use serde_json::{Value, json};

use crate::browser::{Browser, Tab, program};
use crate::program::{Program, endless, layers};

/// Corners of the light of `cornell-box`.
const LIGHT: [[f64; 3]; 2] = [[213.0, 548.3, 227.0], [343.0, 548.3, 332.0]];
/// Pixels of the floor, of the wall to the left and of the wall to the right.
const PIXELS: [[u32; 2]; 3] = [[22, 87], [6, 40], [90, 56]];
/// Largest angle between the brightest bin's center and the light, in degrees: most of a bin's diagonal.
const MOST_DEGREES: f64 = 14.0;

/// Browser, or `None` with one sentence where there is none.
pub fn browser() -> Option<Browser> {
    let program = program();
    if program.is_none() {
        println!(
            "skipped: there is no Chromium; `setup.sh --chromium` installs it, and LODESTAR_CHROMIUM names another one"
        );
    }
    program.as_ref().map(Browser::start)
}

fn numbers(value: &Value) -> [f64; 3] {
    let numbers: Vec<f64> = value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect();
    numbers.try_into().unwrap()
}

/// Angle in degrees between `direction` and the nearest of many points of the light, seen from `position`.
fn degrees_from_light(position: [f64; 3], direction: [f64; 3]) -> f64 {
    let on_light = |i: u32| {
        let share = [f64::from(i % 9) / 8.0, 0.0, f64::from(i / 9) / 8.0];
        std::array::from_fn::<f64, 3, _>(|c| LIGHT[0][c] + (LIGHT[1][c] - LIGHT[0][c]) * share[c] - position[c])
    };
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
    let cosine = |to: [f64; 3]| dot(to, direction) / (dot(to, to) * dot(direction, direction)).sqrt();
    let most = (0..81).map(|i| cosine(on_light(i))).fold(-1.0, f64::max);
    most.min(1.0).acos().to_degrees()
}

/// Clicks a pixel of the picture and waits for its map. Returns the point and the direction that the drawn map is brightest in.
fn click(browser: &mut Browser, tab: &Tab, [x, y]: [u32; 2]) -> ([f64; 3], [f64; 3]) {
    let point = browser.value(tab, &format!("lodestar.pointOf([{x}, {y}])"));
    browser.click(tab, [point[0].as_f64().unwrap(), point[1].as_f64().unwrap()]);
    let is_shown = format!("document.getElementById('guide-part').dataset.pixel === '{x},{y}'");
    browser.wait(tab, &format!("{is_shown} && document.getElementById('guide').dataset.brightest"));
    // The brightest color of the drawn disk, as a direction. The ring around the brightest bin is left out.
    let seen = browser.value(
        tab,
        &format!(
            "(async () => {{
                const {{ diskDirection, diskPoint }} = await import('/guide.js');
                const {{ surface }} = await (await lodestar.ask('/pixel?x={x}&y={y}')).json();
                const canvas = document.getElementById('hemisphere'), {{ width }} = canvas;
                const data = canvas.getContext('2d').getImageData(0, 0, width, width).data;
                const named = document.getElementById('guide').dataset.brightest.split(',').map(Number);
                const ring = diskPoint(surface, named);
                let sum = [0, 0, 0], most = 0;
                for (let i = 0; i < width * width; i++) {{
                    const [x, y] = [((i % width) + 0.5) / (width / 2) - 1, 1 - (Math.floor(i / width) + 0.5) / (width / 2)];
                    const light = data[4 * i] + data[4 * i + 1] + data[4 * i + 2];
                    const from = Math.hypot(x - ring[0], y - ring[1]) * width / 2;
                    if (x * x + y * y > 0.97 || data[4 * i + 3] < 255 || (from > 5 && from < 12)) continue;
                    if (light > most + 2) [sum, most] = [[0, 0, 0], light];
                    if (light > most - 2) sum = diskDirection(surface, x, y).map((value, c) => sum[c] + value);
                }}
                return {{ position: surface.position, drawn: sum, named }};
            }})()"
        ),
    );
    let [position, drawn, named] = ["position", "drawn", "named"].map(|name| numbers(&seen[name]));
    let apart = |a: [f64; 3], b: [f64; 3]| {
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
        (dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()).min(1.0).acos().to_degrees()
    };
    println!("pixel {x},{y}: at {position:?}, brightest bin {named:?}, drawn {drawn:?}");
    assert!(apart(drawn, named) < 2.0 * MOST_DEGREES, "the drawn map is brightest at {drawn:?}, not at {named:?}");
    (position, named)
}

fn samples(browser: &mut Browser, tab: &Tab) -> u64 {
    browser.value(tab, "Number(document.getElementById('picture').dataset.samples ?? 0)").as_u64().unwrap()
}

/// Expression that is true in a phase.
pub fn phase(name: &str) -> String {
    format!("document.getElementById('phase').dataset.phase === '{name}'")
}

#[test]
fn the_page_shows_steers_and_ends_a_render() {
    let Some(mut browser) = browser() else { return };
    let mut program = Program::start(&endless());
    let tab = browser.open(&program.url, [1280, 800]);

    // The page renders: the canvas has the colors of a picture.
    browser.wait(&tab, "document.getElementById('picture').dataset.shot > 0");
    let colors = "(() => {
        const canvas = document.getElementById('picture');
        const data = new Uint32Array(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        return new Set(data).size;
    })()";
    browser.wait(&tab, &format!("{colors} > 200"));
    // It updates.
    let before = samples(&mut browser, &tab);
    browser.wait(&tab, &format!("document.getElementById('picture').dataset.samples > {before}"));
    // A second client does no harm, nor does one that never reads.
    let second = browser.open(&program.url, [390, 844]);
    let _hung = program.listen();
    browser.wait(&second, "document.getElementById('picture').dataset.shot > 0");

    // A click shows what the guide has learned: the light.
    program.wait_for(|state| state["samples"].as_u64() >= Some(64));
    let maps = PIXELS.map(|pixel| {
        browser.wait(&tab, "document.getElementById('picture').dataset.samples >= 64");
        click(&mut browser, &tab, pixel)
    });
    for (index, (position, brightest)) in maps.iter().enumerate() {
        let degrees = degrees_from_light(*position, *brightest);
        assert!(degrees < MOST_DEGREES, "pixel {:?}: {degrees} degrees from the light", PIXELS[index]);
        // The test tells maps apart: another pixel's map would be wrong here.
        let other = degrees_from_light(*position, maps[(index + 1) % 3].1);
        assert!(other > MOST_DEGREES, "the maps of two pixels are the same");
    }
    // The line under the picture moves on with the picture.
    let line = "document.getElementById('readout').textContent";
    let before = browser.value(&tab, line);
    assert!(before.as_str().is_some_and(|line| line.starts_with("Pixel ")), "{before}");
    browser.wait(&tab, &format!("{line} !== {before}"));
    // Both sizes and both schemes. Nothing is wider than the window.
    browser.value(&second, "document.getElementById('cells').click()");
    click(&mut browser, &second, PIXELS[0]);
    for (tab, name) in [(&tab, "1280"), (&second, "390")] {
        for scheme in ["light", "dark"] {
            browser.choose_colors(tab, scheme);
            browser.photograph(tab, &format!("view-{name}-{scheme}"));
            let fits = "document.documentElement.scrollWidth <= window.innerWidth";
            assert_eq!(browser.value(tab, fits), json!(true), "{name} {scheme}");
        }
    }
    // Cells are drawn over the picture.
    browser.value(&tab, "document.getElementById('cells').click()");
    let plain = browser.value(&tab, colors);
    browser.wait(&tab, &format!("{colors} !== {plain}"));

    // Keys move the mark and look at the pixel.
    browser.value(&tab, "document.getElementById('cells').click(); document.getElementById('picture').focus()");
    browser.press(&tab, "ArrowLeft", 37);
    browser.press(&tab, "Enter", 13);
    let [x, y] = [PIXELS[2][0] - 1, PIXELS[2][1]];
    browser.wait(&tab, &format!("document.getElementById('guide-part').dataset.pixel === '{x},{y}'"));
    browser.wait(&tab, &format!("document.getElementById('said').textContent.startsWith('Pixel {x}, {y}')"));

    // A pause holds the render, and it goes on.
    browser.value(&tab, "document.getElementById('pause').click()");
    browser.wait(&tab, &phase("paused"));
    browser.wait(&second, &phase("paused"));
    let held = program.state()["samples"].clone();
    std::thread::sleep(std::time::Duration::from_millis(400));
    assert_eq!(program.state()["samples"], held);
    browser.value(&tab, "document.getElementById('pause').click()");
    program.wait_for(|state| state["samples"].as_u64() > held.as_u64());

    // A foreign page can neither look nor steer.
    let foreign = browser.open("data:text/html,<title>foreign</title>", [400, 300]);
    let (address, token) = program.address();
    let reach = |path: &str, options: Value| {
        format!("fetch('http://{address}{path}', {options}).then((a) => a.type, () => 'refused')")
    };
    let headers = json!({ "method": "POST", "headers": { "X-Lodestar-Token": token } });
    let own = json!({ "headers": { "X-Lodestar-Token": token } });
    assert_eq!(browser.value(&foreign, &reach("/pixel?x=1&y=1", own)), "refused");
    assert_eq!(browser.value(&foreign, &reach("/page.js", json!({}))), "refused");
    assert_eq!(browser.value(&foreign, &reach("/stop", headers)), "refused");
    browser.value(&foreign, &reach("/stop", json!({ "method": "POST", "mode": "no-cors" })));
    assert!(program.is_running() && program.state()["phase"] == "rendering");

    // Stopping takes two clicks and writes the picture.
    browser.value(&tab, "document.getElementById('stop').click()");
    assert!(program.state()["phase"] == "rendering");
    browser.value(&tab, "document.getElementById('stop').click()");
    assert_eq!(program.wait(), Some(0));
    browser.wait(&tab, &phase("ended"));
    let counts = layers(&program.path("a.exr")).words("samples.N").unwrap().to_vec();
    assert!(u64::from(counts[0]) >= 64);

    // The written picture can be looked at.
    let path = program.path("a.exr").display().to_string();
    let file = Program::start(&["view", &path]);
    let tab = browser.open(&file.url, [1280, 800]);
    browser.wait(&tab, "document.getElementById('picture').dataset.shot > 0");
    let names =
        browser.value(&tab, "[...document.getElementById('layer').options].map((option) => option.value).join()");
    for name in ["radiance", "variance", "samples", "albedo", "normal", "depth"] {
        assert!(names.as_str().unwrap().split(',').any(|found| found == name), "{names} lacks {name}");
    }
    assert_eq!(browser.value(&tab, "document.getElementById('orders').hidden"), json!(true));
}

/// The token stays in the address when the page is loaded again or its links are used. Without it, the page says what is missing.
#[test]
fn the_page_says_where_its_token_is() {
    let Some(mut browser) = browser() else { return };
    let program = Program::start_view();
    let shown = "document.getElementById('picture').dataset.shot > 0";
    let tab = browser.open(&program.url, [1280, 800]);
    browser.wait(&tab, shown);
    browser.value(&tab, "document.querySelector('.skip').click()");
    assert_eq!(browser.value(&tab, "document.activeElement.id"), json!("picture"));
    assert_eq!(browser.value(&tab, "location.hash.slice(1)"), json!(program.address().1));
    browser.value(&tab, "window.isOld = true; location.reload()");
    browser.wait(&tab, &format!("!window.isOld && {shown}"));
    assert_eq!(browser.value(&tab, "document.cookie + localStorage.length + sessionStorage.length"), json!("00"));

    let bare = format!("http://{}/", program.address().0);
    let message = "document.getElementById('message').textContent";
    let printed = "printed on its terminal";
    for (hash, sentences) in [
        ("", ["This address lacks", printed]),
        ("#0123", ["token of another render", printed]),
        ("#LODESTAR_VIEW_TOKEN", ["Write the value of LODESTAR_VIEW_TOKEN", "in this address"]),
    ] {
        let url = format!("{bare}{hash}");
        let tab = browser.open(&url, [1280, 800]);
        browser.wait(&tab, &phase("locked"));
        let said = browser.value(&tab, message).to_string();
        assert!(sentences.iter().all(|sentence| said.contains(sentence)), "{said}");
        let enabled = "['pause', 'write', 'stop'].some((id) => !document.getElementById(id).disabled)";
        assert_eq!(browser.value(&tab, enabled), json!(false));
        browser.photograph(&tab, &format!("view-locked-{}", hash.len()));
        // The right address in the same tab opens the page.
        browser.value(&tab, &format!("location.hash = '{}'", program.address().1));
        browser.wait(&tab, shown);
    }
}
