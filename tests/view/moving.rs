//! The page of a scene whose camera moves.

use std::time::{Duration, Instant};

use lodestar::image::exr;
use lodestar::{Options, Scene, Session};
use serde_json::{Value, json};

use crate::page::{browser, phase};
use crate::program::{Program, SCENE};

/// Samples per pixel of a camera at rest.
const SPP: u64 = 40;

/// Arguments of a page of a small Cornell box. Emitters are not sampled, so that the guide finds the light.
fn view<'a>() -> Vec<&'a str> {
    vec!["view", SCENE, "--nee", "off", "--width", "96", "--height", "96", "--spp", "40", "-o", "seen.exr"]
}

/// Query of a pose, with some of its values replaced.
fn query(pose: &Value, changes: &[(&str, &str)]) -> String {
    let text = |value: &Value| match value {
        Value::Array(numbers) => numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(","),
        number => number.to_string(),
    };
    let pairs = pose.as_object().unwrap().iter().map(|(name, value)| {
        let change = changes.iter().find(|(changed, _)| changed == name);
        format!("{name}={}", change.map_or_else(|| text(value), |(_, to)| (*to).to_owned()))
    });
    pairs.collect::<Vec<_>>().join("&")
}

fn at_rest(program: &Program) -> Value {
    program.wait_for(|state| state["phase"] == "resting" && state["samples"] == SPP && state["shot"].as_u64() > Some(0))
}

/// The camera moves to where a page wants it, its first picture is guided already, and it then rests until all samples are taken.
#[test]
fn a_camera_moves_and_the_guide_stays() {
    let denoiser = support::denoiser_folder();
    let mut program = match &denoiser {
        Some(folder) => Program::start_with_denoiser(&view(), folder),
        None => Program::start(&view()),
    };
    let before = at_rest(&program);
    let pose = &before["view"]["pose"];
    let eye =
        [pose["eye"][0].as_f64().unwrap() + 90.0, pose["eye"][1].as_f64().unwrap(), pose["eye"][2].as_f64().unwrap()];
    let eye = eye.map(|number| number.to_string()).join(",");
    let moved = query(pose, &[("eye", &eye), ("aperture", "20"), ("focus", "900")]);
    let (status, layer) = program.ask_as_page(&format!("POST /move?{moved}&moving=1&name=radiance"));
    assert_eq!(status, 200, "{}", String::from_utf8_lossy(&layer));
    assert!(!layer.is_empty() && layer.len() <= 6 * 96 * 96 && layer.len().is_multiple_of(6));
    let state = program.state();
    let seen = &state["view"];
    assert_eq!(
        (&seen["wish"], &seen["pose"]["aperture"], &seen["pose"]["focus"]),
        (&json!(1), &json!(20.0), &json!(900.0))
    );
    // Samples that are guided hit the light more often.
    let options = Options::new().size(96, 96).samples(1).settings(|settings| settings.nee = false);
    let unguided = Session::open(SCENE, &options).and_then(|mut session| session.step(1)).unwrap().light_hit_rate;
    let guided = state["light_hit_rate"].as_f64().unwrap();
    assert!(guided > 1.5 * unguided, "{guided} is not much above {unguided}");
    // Small pictures are denoised where the page asks for that.
    if denoiser.is_some() {
        let (status, layer) = program.ask_as_page(&format!("POST /move?{moved}&moving=1&name=denoised"));
        assert!(status == 200 && !layer.is_empty() && layer.len().is_multiple_of(6), "{status}");
    }
    // The camera rests without another wish.
    let rested = at_rest(&program);
    assert_eq!(rested["view"]["pose"], seen["pose"]);
    assert_eq!(rested["view"]["size"], json!([96, 96]));
    let (status, layer) = program.ask_as_page("GET /layer?name=depth");
    assert_eq!((status, layer.len()), (200, 2 * 96 * 96));

    // The camera as XML is read as the same camera.
    let (_, xml) = program.ask_as_page("GET /camera.xml");
    let path = program.path("camera.xml");
    std::fs::write(&path, format!("<scene version=\"3.0.0\">{}</scene>", String::from_utf8(xml).unwrap())).unwrap();
    let camera = Scene::load(&path).unwrap().camera;
    let lens = lodestar::scene::Projection::ThinLens { aperture_radius: 20.0, focus_distance: 900.0 };
    assert_eq!(camera.projection, lens);
    let (_, cameras) = program.ask_as_page("GET /cameras");
    let cameras: Value = serde_json::from_slice(&cameras).unwrap();
    assert_eq!((cameras.as_array().unwrap().len(), &cameras[0][1]["eye"]), (1, &pose["eye"]));

    // What is seen is rendered into files with names of their own, with the guide and other samples than those before.
    for (order, name) in [("render", "seen.1.exr"), ("render", "seen.2.exr")] {
        assert_eq!(program.ask_as_page(&format!("POST /{order}")).0, 204);
        let message = format!("Written: {name}");
        program.wait_for(|state| state["message"] == message && state["phase"] == "resting");
    }
    let attributes = exr::read_attributes(&program.path("seen.2.exr")).unwrap();
    let value = |name: &str| attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value.clone());
    let ranges = value("sample_ranges").unwrap();
    assert!(ranges.ends_with(":0..40") && !ranges.starts_with("0:"), "{ranges}");
    assert!(program.is_running());
    assert_eq!(program.ask_as_page("POST /stop").0, 204);
    assert_eq!(program.wait(), Some(0));
}

/// Whoever lacks the token moves nothing, wrong poses are refused in a sentence, and a flood of wishes leaves the last one.
#[test]
fn strangers_and_wrong_poses_move_nothing() {
    let mut program = Program::start(&view());
    let state = at_rest(&program);
    let pose = &state["view"]["pose"];
    let good = format!("POST /move?{}", query(pose, &[]));
    let (address, token) = program.address();
    let (host, token) = (format!("Host: {address}"), format!("X-Lodestar-Token: {token}"));
    assert_eq!(program.ask(&good, &[&host]).0, 403);
    assert_eq!(program.ask(&good, &[&host, &token, "Origin: http://evil.example"]).0, 403);
    for request in ["GET /cameras", "GET /camera.xml", "POST /render"] {
        assert_eq!(program.ask(request, &[&host]).0, 403, "{request}");
    }
    for changes in [
        ("eye", "1,2"),
        ("eye", "1,2,nan"),
        ("forward", "0,0,0"),
        ("up", "1e40,0,0"),
        ("camera", "7"),
        ("camera", "4294967296"),
        ("aperture", "-1"),
        ("focus", "0"),
    ] {
        let (status, told) = program.ask_as_page(&format!("POST /move?{}", query(pose, &[changes])));
        let told = String::from_utf8_lossy(&told);
        assert!(status == 400 && told.contains(' ') && told.trim_end().len() > 10, "{changes:?}: {status} {told}");
    }
    assert_eq!(program.ask_as_page("POST /move").0, 400);
    let after = program.state();
    assert_eq!((&after["view"]["pose"], &after["view"]["wish"]), (pose, &json!(0)));

    // Wishes that nobody waits for are followed by the last one only.
    let before = program.memory("VmRSS");
    for _ in 0..300 {
        let mut stream = std::net::TcpStream::connect(program.address().0).unwrap();
        std::io::Write::write_all(&mut stream, format!("{good} HTTP/1.1\r\n{host}\r\n{token}\r\n\r\n").as_bytes())
            .unwrap();
    }
    let last = query(pose, &[("focus", "123")]);
    let begin = Instant::now();
    while program.ask_as_page(&format!("POST /move?{last}")).0 != 200 {
        assert!(begin.elapsed() < Duration::from_secs(60), "the last wish is not followed");
    }
    assert_eq!(program.state()["view"]["pose"]["focus"], json!(123.0));
    assert!(program.memory("VmRSS") < before + 64.0, "wishes are kept");
    assert!(program.is_running());

    // The pages of renders and pictures have no camera to be moved.
    let picture = Program::start_view();
    for request in [&good[..], "GET /cameras", "GET /camera.xml"] {
        assert_eq!(picture.ask_as_page(request).0, 404, "{request}");
    }
}

/// A mouse drags the camera, keys walk, the lens opens, and the page shows the picture from there.
#[test]
fn the_page_drags_the_camera() {
    let Some(mut browser) = browser() else { return };
    let program = Program::start(&view());
    let tab = browser.open(&program.url, [1280, 800]);
    browser.wait(&tab, "Number(document.getElementById('picture').dataset.samples) === 40");
    browser.photograph(&tab, "view-moving-rest");
    let before = program.state()["view"]["pose"].clone();
    let picture = browser.value(&tab, "lodestar.pointOf([48, 48])");
    let [x, y] = [0, 1].map(|axis| picture[axis].as_f64().unwrap());

    browser.drag(&tab, [x, y], [x + 120.0, y + 30.0]);
    program.wait_for(|state| state["view"]["wish"].as_u64() >= Some(2));
    let state = at_rest(&program);
    let after = state["view"]["pose"].clone();
    assert!(after["eye"] != before["eye"] && after["forward"] != before["forward"], "{after}");
    // An orbit keeps the distance to what is in the middle.
    let number = |pose: &Value, name: &str| -> [f64; 3] {
        let numbers: Vec<f64> = pose[name].as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    let up = number(&after, "up");
    assert!(up[1] > 0.7, "the camera has rolled: {up:?}");
    browser.wait(&tab, &format!("{} && document.getElementById('picture').dataset.size === '96 96'", phase("resting")));

    // A key walks forward while it is held.
    browser.value(&tab, "document.getElementById('picture').focus()");
    browser.hold(&tab, "w", "KeyW", Duration::from_millis(300));
    let walked = program.wait_for(|state| state["view"]["pose"]["eye"] != after["eye"])["view"]["pose"].clone();
    let along: f64 =
        (0..3).map(|i| (number(&walked, "eye")[i] - number(&after, "eye")[i]) * number(&after, "forward")[i]).sum();
    assert!(along > 0.0, "{along}");

    // The lens opens, and a click focuses.
    let open = "(() => { const lens = document.getElementById('lens'); lens.value = 16; lens.dispatchEvent(new Event('input')); })()";
    browser.value(&tab, open);
    let opened = program.wait_for(|state| state["view"]["pose"]["aperture"].as_f64() > Some(0.0));
    at_rest(&program);
    browser.click(&tab, [x - 60.0, y + 60.0]);
    program.wait_for(|state| state["view"]["pose"]["focus"] != opened["view"]["pose"]["focus"]);
    browser.wait(&tab, "document.getElementById('said').textContent.startsWith('Focus at a depth of ')");

    // The camera goes back to that of the file, and its XML is shown.
    browser.value(&tab, "document.getElementById('back').click()");
    program.wait_for(|state| state["view"]["pose"] == before);
    browser.value(&tab, "document.getElementById('copy').click()");
    browser.wait(&tab, "document.getElementById('xml-text').value.startsWith('<sensor type=\"perspective\">')");
    browser.photograph(&tab, "view-moving-xml");
    browser.value(&tab, "document.getElementById('xml').close()");

    // Marks are those of every page.
    browser.value(&tab, "(() => { const drag = document.getElementById('drag'); drag.value = 'mark'; drag.dispatchEvent(new Event('change')); })()");
    at_rest(&program);
    browser.click(&tab, [x, y]);
    browser
        .wait(&tab, "document.getElementById('guide-part').dataset.pixel && !document.getElementById('guide').hidden");
    for (width, name) in [(1280, "1280"), (390, "390")] {
        browser.resize(&tab, [width, 844]);
        for scheme in ["light", "dark"] {
            browser.choose_colors(&tab, scheme);
            browser.photograph(&tab, &format!("view-moving-{name}-{scheme}"));
            let fits = "document.documentElement.scrollWidth <= window.innerWidth";
            assert_eq!(browser.value(&tab, fits), json!(true), "{name} {scheme}");
        }
    }
}
