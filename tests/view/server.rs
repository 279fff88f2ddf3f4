//! The server of the page, as programs and foreign pages see it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::json;

use crate::program::{PICTURE, Program, endless, layers, render, size};

#[test]
fn foreign_requests_are_refused() {
    let mut program = Program::start(&endless());
    program.wait_for(|state| state["phase"] == "rendering");
    let (address, token) = program.address();
    let (host, token) = (format!("Host: {address}"), format!("X-Lodestar-Token: {token}"));
    let status = |request: &str, headers: &[&str]| program.ask(request, headers).0;
    assert_eq!(status("GET /", &[&host]), 200);
    assert_eq!(status("GET /", &["Host: evil.example"]), 403);
    assert_eq!(status("GET /", &[]), 403);
    assert_eq!(status("GET /events", &[&host, &token, "Origin: http://evil.example"]), 403);
    assert_eq!(status("GET /events", &[&host, &token, "Origin: \u{ff}"]), 403, "an origin that is no text");
    assert_eq!(status("GET /pixel?x=1&y=1", &[&host, &host, &token]), 403, "two hosts");
    assert_eq!(status("GET /layer?name=radiance", &[&host, &token, "Sec-Fetch-Site: cross-site"]), 403);
    assert_eq!(status("POST /stop", &[&host, &token, "Origin: http://evil.example"]), 403);
    assert_eq!(status("GET /stop", &[&host, &token]), 404);
    assert_eq!(status("GET /../Cargo.toml", &[&host, &token]), 404);
    assert_eq!(status("DELETE /", &[&host, &token]), 405);
    // Before the first shot there are no pixels, and the answer is empty.
    program.wait_for(|state| state["shot"].as_u64() > Some(0));
    assert_eq!(program.ask("GET /pixel?x=96&y=0", &[&host, &token]).0, 404);
    assert_eq!(program.state()["phase"], "rendering");
    assert_eq!(status("POST /stop", &[&host, &token]), 204, "the token of the printed address");
    assert_eq!(program.wait(), Some(0));
    assert!(size(&program.path("a.exr")) > 1000);
}

/// Whoever lacks the token learns nothing about the render.
#[test]
fn reading_needs_the_token() {
    let mut program = Program::start(&endless());
    program.wait_for(|state| state["shot"].as_u64() > Some(0));
    let (address, token) = program.address();
    let host = format!("Host: {address}");
    let wrong = [String::new(), "0123456789abcdef0123456789abcdef".to_owned(), token[1..].to_owned()];
    for request in
        ["GET /events", "GET /layer?name=radiance", "GET /cells", "GET /pixel?x=1&y=1", "POST /stop", "GET /a"]
    {
        let (status, told) = program.ask(request, &[&host]);
        let told = String::from_utf8_lossy(&told);
        assert!(
            status == 403 && told.contains("the address that the render has printed"),
            "{request}: {status} {told}"
        );
        for wrong in &wrong {
            let token = format!("X-Lodestar-Token: {wrong}");
            let (status, told) = program.ask(request, &[&host, &token]);
            assert!(status == 403 && told.starts_with(b"The address has the token of another render"), "{request}");
            assert_eq!(program.ask(request, &[&host, &token, &token]).0, 403, "{request}");
        }
    }
    // No secret is in the page's files.
    for file in
        ["/", "/page.js", "/picture.js", "/tone.js", "/move.js", "/guide.js", "/curve.js", "/style.css", "/icon.svg"]
    {
        let (status, content) = program.ask(&format!("GET {file}"), &[&host]);
        assert!(status == 200 && !String::from_utf8_lossy(&content).contains(token), "{file}");
    }
    assert!(program.is_running() && program.state()["phase"] == "rendering");
}

/// Holders of the token see names of files, but no folders of the machine.
#[test]
fn no_folders_are_told() {
    let program = Program::start(&endless());
    program.wait_for(|state| state["samples"].as_u64() > Some(0));
    assert_eq!(program.ask_as_page("POST /write").0, 204);
    let state = program.wait_for(|state| state["message"].as_str().is_some_and(|text| text.starts_with("Written")));
    assert_eq!((&state["scene"], &state["files"][0]), (&json!("cornell-box/scene.xml"), &json!("a.exr")));
    assert_eq!(state["message"], "Written: a.exr");
    let folder = env!("CARGO_MANIFEST_DIR");
    assert!(!state.to_string().contains(folder), "{state}");

    let program = Program::start_view();
    let state = program.state().to_string();
    assert!(state.contains(PICTURE) && !state.contains(&program.path("").display().to_string()), "{state}");
}

/// The user's own token opens the page of a wall display. It is not printed.
#[test]
fn the_users_token_is_taken() {
    let token = "wall-display-of-hall-7";
    let mut program = Program::start_view_with_token(token);
    let address = program.address().0.to_owned();
    assert_eq!(program.address().1, "LODESTAR_VIEW_TOKEN");
    let host = format!("Host: {address}");
    let status =
        |token: &str| program.ask("GET /layer?name=radiance", &[&host, &format!("X-Lodestar-Token: {token}")]).0;
    assert_eq!((status(token), status("LODESTAR_VIEW_TOKEN")), (200, 403));
    program.signal("TERM");
    assert_eq!(program.wait(), Some(0));

    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_lodestar"));
    let output = command.args(render(&["--view"])).env("LODESTAR_VIEW_TOKEN", "too-short").output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    let is_one_sentence = error.lines().count() == 1 && error.contains("LODESTAR_VIEW_TOKEN is no token: it needs 16");
    assert!(!output.status.success() && is_one_sentence && !error.contains("too-short"), "{error}");
}

/// A render has the same bits without viewers, and with viewers that ask for everything all the time, hang or leave.
#[test]
fn bits_do_not_depend_on_viewers() {
    let mut plain = Program::start_silent(&render(&["--spp", "48"]));
    assert_eq!(plain.wait(), Some(0));
    let mut watched = Program::start(&render(&["--spp", "48", "--view"]));
    let is_over = AtomicBool::new(false);
    let asked = std::thread::scope(|scope| {
        let watched_by_page = &watched;
        let hung = watched_by_page.listen();
        drop(watched_by_page.listen());
        let ask = scope.spawn(|| {
            let mut layers = 0;
            while !is_over.load(Ordering::Relaxed) {
                for path in ["/layer?name=radiance", "/layer?name=normal", "/cells", "/pixel?x=40&y=80"] {
                    layers += u32::from(try_to_ask(watched_by_page.address(), path).unwrap_or(0) == 200);
                }
            }
            layers
        });
        let begin = std::time::Instant::now();
        while TcpStream::connect(watched_by_page.address().0).is_ok() && begin.elapsed() < crate::browser::PATIENCE {
            std::thread::sleep(Duration::from_millis(20));
        }
        is_over.store(true, Ordering::Relaxed);
        drop(hung);
        ask.join().unwrap()
    });
    assert_eq!(watched.wait(), Some(0));
    assert!(asked > 3, "only {asked} answers: the viewers have seen nothing");
    assert_eq!(layers(&plain.path("a.exr")), layers(&watched.path("a.exr")));
}

/// Status of the answer to a request. The program may have ended.
fn try_to_ask((address, token): (&str, &str), path: &str) -> std::io::Result<u16> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(crate::browser::PATIENCE))?;
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {address}\r\nX-Lodestar-Token: {token}\r\nConnection: close\r\n\r\n")?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer)?;
    Ok(answer.get(9..12).and_then(|digits| std::str::from_utf8(digits).ok()?.parse().ok()).unwrap_or(0))
}

#[test]
fn a_pause_ends_no_render_and_files_are_written_on_the_way() {
    let mut program = Program::start(&endless());
    program.wait_for(|state| state["samples"].as_u64() > Some(0));
    assert_eq!(program.ask_as_page("POST /pause").0, 204);
    let paused = program.wait_for(|state| state["phase"] == "paused");
    assert_eq!(program.ask_as_page("POST /write").0, 204);
    let written = program.wait_for(|state| state["message"].as_str().is_some_and(|text| text.starts_with("Written")));
    assert_eq!((&written["samples"], &written["phase"]), (&paused["samples"], &paused["phase"]));
    let counts = layers(&program.path("a.exr")).words("samples.N").unwrap().to_vec();
    assert!(counts.iter().all(|&count| Some(u64::from(count)) == paused["samples"].as_u64()));
    assert_eq!(program.ask_as_page("POST /go-on").0, 204);
    program.wait_for(|state| state["samples"].as_u64() > paused["samples"].as_u64());
    assert_eq!(program.ask_as_page("POST /stop").0, 204);
    assert_eq!(program.wait(), Some(0));
    let more = layers(&program.path("a.exr")).words("samples.N").unwrap()[0];
    assert!(u64::from(more) > paused["samples"].as_u64().unwrap());
}

/// The library of the denoiser is loaded when a page asks for the layer first. A library that only leaves a mark when it is loaded
/// stands for Open Image Denoise.
#[test]
fn the_denoisers_library_is_loaded_when_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let [mark, source] = ["loaded", "mark.c"].map(|name| folder.path().join(name));
    let code = format!(
        "#include <stdio.h>\n__attribute__((constructor)) static void load(void) {{ fclose(fopen(\"{}\", \"w\")); }}\n",
        mark.display()
    );
    std::fs::write(&source, code).unwrap();
    let library = folder.path().join("libOpenImageDenoise.so.2");
    let built = std::process::Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&source).status();
    assert!(built.unwrap().success());

    let program = Program::start_with_denoiser(&endless(), folder.path());
    let state = program.wait_for(|state| state["shot"].as_u64() > Some(0));
    assert_eq!(program.ask_as_page("GET /layer?name=radiance").0, 200);
    assert!(state["shot"].as_u64() > Some(0) && !mark.exists(), "the library is loaded unasked");
    let (status, told) = program.ask_as_page("GET /layer?name=denoised");
    assert!(status == 404 && told.starts_with(b"Open Image Denoise cannot be used"), "{status}");
    assert!(mark.exists(), "the library is not loaded");
    assert_eq!(program.ask_as_page("GET /layer?name=radiance").0, 200);
}

/// The layer `denoised` has less noise than the radiance, and the file does not contain it.
#[test]
fn the_page_offers_the_denoised_picture() {
    let empty = tempfile::tempdir().unwrap();
    let program = Program::start_with_denoiser(&endless(), empty.path());
    program.wait_for(|state| state["shot"].as_u64() > Some(0));
    assert_eq!(program.ask_as_page("GET /layer?name=denoised").0, 404);
    drop(program);

    let Some(folder) = support::denoiser_folder() else { return };
    let mut program = Program::start_with_denoiser(&endless(), &folder);
    program.wait_for(|state| state["samples"].as_u64() > Some(0));
    assert_eq!(program.ask_as_page("POST /pause").0, 204);
    program.wait_for(|state| state["phase"] == "paused" && state["shot"].as_u64() > Some(0));
    let [noisy, smooth] = ["radiance", "denoised"].map(|name| {
        let (status, bytes) = program.ask_as_page(&format!("GET /layer?name={name}"));
        assert_eq!((status, bytes.len()), (200, 96 * 96 * 3 * 2), "{name}");
        roughness(&bytes)
    });
    assert!(smooth < 0.5 * noisy, "pixels differ from their neighbors by {noisy}, denoised ones by {smooth}");
    assert_eq!(program.ask_as_page("POST /stop").0, 204);
    assert_eq!(program.wait(), Some(0));
    assert!(layers(&program.path("a.exr")).channels.iter().all(|(name, _)| !name.starts_with("denoised")));
}

/// Mean difference between the half floats of neighbors in a row. A difference counts as 1 at most, so that outliers do not decide.
fn roughness(bytes: &[u8]) -> f32 {
    let value = |bytes: &[u8]| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
    let values: Vec<f32> = bytes.chunks_exact(2).map(value).collect();
    let differences = values.windows(4).map(|four| (four[3] - four[0]).abs().min(1.0));
    differences.sum::<f32>() / values.len() as f32
}

#[test]
fn wrong_addresses_are_one_sentence() {
    for (arguments, word) in [
        (render(&["--view", "scene.xml"]), "name the scene before --view"),
        (render(&["--view", "127.0.0.1:65536"]), "write it as ADDRESS:PORT"),
        (render(&["--view", "192.0.2.1:8000"]), "no page can be served at 192.0.2.1:8000"),
        (vec!["view", "missing.exr"], "missing.exr"),
        (vec!["view", "picture.png"], "picture.png: cannot be read"),
        (vec!["view", "missing.xml"], "missing.xml: cannot be read"),
    ] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_lodestar")).args(&arguments).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.lines().count() == 1 && error.contains(word), "{error}");
    }
}
