//! Answers of the server.
//!
//! | request | answer |
//! |---|---|
//! | `GET /` and the page's files | the page |
//! | `GET /events` | the render's state as server-sent events |
//! | `GET /layer?name=NAME` | a layer as half floats, with a header `X-Frame` of its size |
//! | `GET /cells` | the guide's cell of every pixel, as 32-bit integers, and the mean radiance of every cell |
//! | `GET /pixel?x=X&y=Y` | everything about a pixel |
//! | `POST /pause`, `/go-on`, `/stop`, `/write` | an order, with the token in the header `X-Lodestar-Token` |

use std::collections::HashMap;
use std::io::{Cursor, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use serde::Serialize;
use tiny_http::{Header, Method, Request, Response, StatusCode};

use crate::view::board::{Board, CurvePoint, Order, State};
use crate::view::guard::{Asking, Guard};
use crate::view::pixel::{PixelFacts, cells_of_pixels};
use crate::view::shot::{Content, Shot};

/// Shortest time between two events.
const EVENT_INTERVAL: Duration = Duration::from_millis(150);
/// Time after which an event is sent although nothing has changed. It finds pages that have left.
const HEARTBEAT: Duration = Duration::from_secs(5);
/// Header of the token.
const TOKEN: &str = "X-Lodestar-Token";

/// Files of the page: path, type and content.
const FILES: &[(&str, &str, &str)] = &[
    ("/", "text/html; charset=utf-8", include_str!("page/index.html")),
    ("/style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("/page.js", "text/javascript; charset=utf-8", include_str!("page/page.js")),
    ("/picture.js", "text/javascript; charset=utf-8", include_str!("page/picture.js")),
    ("/guide.js", "text/javascript; charset=utf-8", include_str!("page/guide.js")),
    ("/curve.js", "text/javascript; charset=utf-8", include_str!("page/curve.js")),
    ("/icon.svg", "image/svg+xml", include_str!("page/icon.svg")),
];

/// Headers of every answer. The page may load nothing from elsewhere, and no other page may show or read it.
const HEADERS: &[(&str, &str)] = &[
    (
        "Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cache-Control", "no-store"),
];

/// Desk at which requests are answered.
pub(super) struct Desk {
    pub board: Arc<Board>,
    pub guard: Guard,
}

type Answer = Response<Cursor<Vec<u8>>>;

/// Size and values of a layer, in the header `X-Frame`.
#[derive(Serialize)]
struct Frame<'a> {
    shot: u64,
    samples: u64,
    width: u32,
    height: u32,
    offset: [u32; 2],
    layers: Vec<String>,
    layer: &'a str,
    channels: &'a [String],
    /// Factor that makes the half floats the values.
    factor: f32,
    mean: f64,
    noise: Option<f64>,
}

impl Desk {
    /// Answers a request. A page that leaves is no error.
    pub fn answer(&self, request: Request) {
        let header = |name: &str| {
            let found =
                request.headers().iter().find(|header| header.field.as_str().as_str().eq_ignore_ascii_case(name));
            found.map(|header| header.value.as_str())
        };
        let asking = Asking {
            host: header("Host"),
            origin: header("Origin"),
            site: header("Sec-Fetch-Site"),
            token: header(TOKEN),
        };
        let url = request.url().to_owned();
        let (path, query) = url.split_once('?').unwrap_or((&url, ""));
        let query: HashMap<&str, &str> = query.split('&').filter_map(|pair| pair.split_once('=')).collect();
        let may_look = self.guard.may_look(&asking);
        if may_look && *request.method() == Method::Get && path == "/events" {
            self.board.listening.fetch_add(1, Ordering::Relaxed);
            self.send_events(request);
            self.board.listening.fetch_sub(1, Ordering::Relaxed);
            return;
        }
        self.board.answering.fetch_add(1, Ordering::Relaxed);
        let answer = match request.method() {
            _ if !may_look => text(403, "This server answers only its own page."),
            Method::Get => self.look(path, &query),
            Method::Post => self.change(path, &asking),
            _ => text(405, "This server knows GET and POST."),
        };
        let _ = request.respond(answer);
        self.board.answering.fetch_sub(1, Ordering::Relaxed);
    }

    fn look(&self, path: &str, query: &HashMap<&str, &str>) -> Answer {
        if let Some((_, kind, content)) = FILES.iter().find(|(file, _, _)| *file == path) {
            return bytes(content.as_bytes().to_vec(), kind);
        }
        match path {
            "/layer" => self.layer(query.get("name").copied().unwrap_or("radiance")),
            "/cells" => self.cells(),
            "/pixel" => self.pixel(query),
            _ => text(404, "There is no such page."),
        }
    }

    fn change(&self, path: &str, asking: &Asking<'_>) -> Answer {
        let order = match path {
            "/pause" => Order::Pause,
            "/go-on" => Order::GoOn,
            "/stop" => Order::Stop,
            "/write" => Order::Write,
            _ => return text(404, "There is no such order."),
        };
        if !self.guard.may_change(asking) {
            return text(403, "This order needs the token of the printed address.");
        }
        self.board.give(order);
        empty()
    }

    /// The last shot. Whoever looks at it also asks for the next one.
    fn shot(&self) -> Option<Arc<Shot>> {
        self.board.wants_shot.store(true, Ordering::Relaxed);
        self.board.lock().shot.clone()
    }

    fn layer(&self, name: &str) -> Answer {
        let Some(shot) = self.shot() else { return empty() };
        let Some(plane) = shot.plane(name) else { return text(404, "The picture has no such layer.") };
        let noise = self.noise(&shot);
        let ([width, height], (halves, factor)) = (shot.size(), plane.halves());
        let frame = Frame {
            shot: shot.number,
            samples: shot.samples,
            width,
            height,
            offset: shot.offset(),
            layers: shot.offered_layers(),
            layer: name,
            channels: &plane.channels,
            factor,
            mean: plane.mean(),
            noise,
        };
        framed(halves, &frame)
    }

    /// Noise of a shot. It joins the curve of noise when it is asked for first.
    fn noise(&self, shot: &Shot) -> Option<f64> {
        let noise = shot.noise()?;
        let mut pinned = self.board.lock();
        let curve = &mut pinned.state.noise;
        if curve.last().is_none_or(|last| last.samples < shot.samples) {
            curve.push(CurvePoint { samples: shot.samples, seconds: shot.seconds, value: noise });
        }
        Some(noise)
    }

    fn cells(&self) -> Answer {
        self.board.wants_guide.store(true, Ordering::Relaxed);
        let Some(shot) = self.shot() else { return empty() };
        let pinned = self.board.lock();
        let (cells, copy) = (pinned.cells.clone(), pinned.guide.clone());
        drop(pinned);
        let (Some(cells), Some(copy), Content::Rendered(picture)) = (cells, copy, &shot.content) else {
            return empty();
        };
        let [width, height] = shot.size();
        let of_pixels = cells_of_pixels(picture, &cells);
        let means = (0..cells.cells.count() as usize).map(|cell| cells.mean(&copy, cell).to_bits());
        let words = of_pixels.into_iter().chain(means).flat_map(u32::to_le_bytes).collect();
        framed(words, &serde_json::json!({ "width": width, "height": height, "count": cells.cells.count() }))
    }

    fn pixel(&self, query: &HashMap<&str, &str>) -> Answer {
        self.board.wants_guide.store(true, Ordering::Relaxed);
        let number = |name: &str| query.get(name).and_then(|text| text.parse().ok());
        let (Some(x), Some(y)) = (number("x"), number("y")) else { return text(400, "Write it as /pixel?x=1&y=2.") };
        let pinned = self.board.lock();
        let (shot, cells, copy) = (pinned.shot.clone(), pinned.cells.clone(), pinned.guide.clone());
        drop(pinned);
        let Some(shot) = shot else { return empty() };
        match PixelFacts::new(&shot, [x, y], cells.as_deref().zip(copy.as_deref())) {
            Some(facts) => json(&facts),
            None => text(404, "The picture has no such pixel."),
        }
    }

    /// Sends the state now and whenever it changes, until the page leaves or the render ends.
    fn send_events(&self, request: Request) {
        self.board.wants_shot.store(true, Ordering::Relaxed);
        let mut page = request.into_writer();
        let mut head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n".to_owned();
        HEADERS.iter().for_each(|(name, value)| head += &format!("{name}: {value}\r\n"));
        head += "\r\n";
        let mut send = |text: &str| page.write_all(text.as_bytes()).and_then(|()| page.flush());
        let mut is_there = send(&head).is_ok();
        let mut seen = None;
        while is_there {
            let pinned = match seen {
                None => self.board.lock(),
                Some(seen) => self.board.wait(seen, HEARTBEAT),
            };
            let (state, revision, is_last) = (pinned.state.clone(), pinned.revision, self.board.is_closed());
            drop(pinned);
            is_there = send(&event(&state)).is_ok() && !is_last;
            seen = Some(revision);
            thread::sleep(EVENT_INTERVAL);
        }
    }
}

fn event(state: &State) -> String {
    format!("data: {}\n\n", serde_json::to_string(state).unwrap_or_default())
}

/// Refuses a request because there are too many.
pub(super) fn refuse_for_now(request: Request) {
    let _ = request.respond(text(503, "Too many pages are open; close some."));
}

/// Answer with the headers that every answer has.
fn answer(status: u16, content: Vec<u8>, more: &[(&str, &str)]) -> Answer {
    let mut response = Response::from_data(content).with_status_code(StatusCode(status));
    for (name, value) in HEADERS.iter().chain(more) {
        if let Ok(header) = Header::from_bytes(*name, *value) {
            response.add_header(header);
        }
    }
    // Browsers need the length to know that a layer is whole.
    response.with_chunked_threshold(usize::MAX)
}

fn bytes(content: Vec<u8>, kind: &str) -> Answer {
    answer(200, content, &[("Content-Type", kind)])
}

fn framed(content: Vec<u8>, frame: &impl Serialize) -> Answer {
    let frame = ascii(&serde_json::to_string(frame).unwrap_or_default());
    answer(200, content, &[("Content-Type", "application/octet-stream"), ("X-Frame", &frame)])
}

/// JSON in ASCII, as headers need it.
fn ascii(json: &str) -> String {
    let mut units = [0; 2];
    let mut escaped =
        |c: char| c.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}")).collect::<String>();
    json.chars().map(|c| if c.is_ascii() { c.to_string() } else { escaped(c) }).collect()
}

fn json(value: &impl Serialize) -> Answer {
    bytes(serde_json::to_vec(value).unwrap_or_default(), "application/json")
}

fn text(status: u16, sentence: &str) -> Answer {
    answer(status, format!("{sentence}\n").into_bytes(), &[("Content-Type", "text/plain; charset=utf-8")])
}

/// Answer that there is nothing yet, or nothing to say.
fn empty() -> Answer {
    answer(204, Vec::new(), &[])
}
