//! Answers of the server.
//!
//! | request | answer |
//! |---|---|
//! | `GET /` and the page's files | the page, for everybody |
//! | `GET /events` | the render's state as server-sent events |
//! | `GET /layer?name=NAME` | a layer as half floats, with a header `X-Frame` of its size |
//! | `GET /cells` | the guide's cell of every pixel, as 32-bit integers, and the mean radiance of every cell |
//! | `GET /pixel?x=X&y=Y` | everything about a pixel |
//! | `GET /cameras` | the cameras of the scene with their poses |
//! | `GET /camera.xml` | the camera now, as a sensor of Mitsuba's XML |
//! | `POST /move?camera=0&eye=X,Y,Z&...&name=NAME` | the layer of the first picture after the camera has moved there (`pose.rs`) |
//! | `POST /pause`, `/go-on`, `/stop`, `/write`, `/render` | an order |
//!
//! All but the page's files needs the token in the header `X-Lodestar-Token`. No request has a body.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use hyper::body::Body;
use hyper::header::{HOST, HeaderMap, ORIGIN};
use hyper::{Method, Request};
use serde::Serialize;
use tokio::time::timeout_at;

use crate::Result;
use crate::view::board::{Board, CurvePoint, Order, Phase, Scenery, thinned};
use crate::view::content::{Answer, Answering, bytes, claiming, empty, framed, json, last, text};
use crate::view::denoiser;
use crate::view::events::Listeners;
use crate::view::guard::{Asking, Guard};
use crate::view::guests::Visit;
use crate::view::limits::{ANSWERS_MIB, DENOISED_ANSWERS_MIB, Limits, MOVE_TIME, STRANGER_REQUESTS, WORKERS};
use crate::view::pixel::{PixelFacts, cells_of_pixels};
use crate::view::pose::Pose;
use crate::view::shot::{Content, DENOISED, Shot};
use crate::view::workers::{Failure, Workers};

/// Header of the token.
const TOKEN: &str = "x-lodestar-token";

/// Sentence about a picture whose camera nobody can move.
const IMMOVABLE: &str = "The camera of this picture cannot be moved; `lodestar view` with a scene shows one that can.";

/// Files of the page: path, type and content.
const FILES: &[(&str, &str, &str)] = &[
    ("/", "text/html; charset=utf-8", include_str!("page/index.html")),
    ("/style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("/page.js", "text/javascript; charset=utf-8", include_str!("page/page.js")),
    ("/picture.js", "text/javascript; charset=utf-8", include_str!("page/picture.js")),
    ("/tone.js", "text/javascript; charset=utf-8", include_str!("../image/tone.js")),
    ("/move.js", "text/javascript; charset=utf-8", include_str!("page/move.js")),
    ("/guide.js", "text/javascript; charset=utf-8", include_str!("page/guide.js")),
    ("/curve.js", "text/javascript; charset=utf-8", include_str!("page/curve.js")),
    ("/icon.svg", "image/svg+xml", include_str!("page/icon.svg")),
];

/// Desk at which requests are answered.
pub(super) struct Desk {
    board: Arc<Board>,
    guard: Guard,
    pub listeners: Listeners,
    workers: Workers,
    /// Worker of the denoised layer, which takes longer than all others.
    denoiser: Workers,
}

/// Size and values of a layer, in the header `X-Frame`.
#[derive(Serialize)]
struct Frame<'a> {
    shot: u64,
    /// Wish that the picture follows.
    wish: u64,
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
    /// Desk of a render.
    pub fn new(board: Arc<Board>, guard: Guard, limits: Limits) -> Result<Self> {
        Ok(Self {
            guard,
            listeners: Listeners::new(Arc::clone(&board), limits.listeners),
            workers: Workers::start("view worker", WORKERS, ANSWERS_MIB)?,
            denoiser: Workers::start("view denoiser", 1, DENOISED_ANSWERS_MIB)?,
            board,
        })
    }

    /// Address of the page with the token.
    pub fn url(&self) -> String {
        self.guard.url()
    }

    /// Answers a request.
    pub async fn answer(self: &Arc<Self>, request: Request<impl Body>, visit: &Visit) -> Answer {
        let headers = request.headers();
        let asking = Asking {
            host: only(headers, HOST.as_str()),
            origin: only(headers, ORIGIN.as_str()),
            site: only(headers, "sec-fetch-site"),
            token: only(headers, TOKEN),
        };
        let path = request.uri().path();
        let refusal = if !self.guard.is_from_own_page(&asking) {
            text(403, "This server answers only its own page.")
        } else if !request.body().is_end_stream() {
            text(413, "This server takes no content.")
        } else if self.guard.has_token(&asking) {
            return self.serve(request, visit).await;
        } else if let Some(file) = file(path).filter(|_| *request.method() == Method::GET) {
            let count = visit.ask_as_stranger();
            return if count < STRANGER_REQUESTS { file } else { last(file) };
        } else if asking.token.is_some() {
            text(
                403,
                "The address has the token of another render: open the one that this render has printed on its terminal.",
            )
        } else {
            text(403, "This needs the token of the address that the render has printed on its terminal.")
        };
        last(refusal)
    }

    /// Answers a request that has the token.
    async fn serve(self: &Arc<Self>, request: Request<impl Body>, visit: &Visit) -> Answer {
        let may_stay = visit.show_token();
        let (path, query) = (request.uri().path(), request.uri().query().unwrap_or_default());
        let answer = match (request.method(), path) {
            (&Method::GET, "/events") if may_stay => self.listeners.listen(),
            (&Method::GET, "/events") => text(503, "Too many pages are open; close some."),
            (&Method::GET, "/layer" | "/cells" | "/pixel") => self.work(path, query).await,
            (&Method::GET, "/cameras") => self.moving(|scenery| json(&scenery.poses)),
            (&Method::GET, "/camera.xml") => {
                self.moving(|scenery| bytes(scenery.xml.clone(), "text/xml; charset=utf-8"))
            }
            (&Method::POST, "/move") => self.follow_wish(query).await,
            (&Method::GET, _) => file(path).unwrap_or_else(|| text(404, "There is no such page.")),
            (&Method::POST, _) => self.follow(path),
            _ => text(405, "This server knows GET and POST."),
        };
        if may_stay { answer } else { last(answer) }
    }

    /// Answers what only a session that moves knows.
    fn moving(&self, answer: impl Fn(&Scenery) -> Answer) -> Answer {
        let scenery = self.board.lock().scenery.clone();
        scenery.map_or_else(|| text(404, IMMOVABLE), |scenery| answer(&scenery))
    }

    /// Moves the camera, and answers with a layer of the first picture from there, or from where a later wish has it. Nothing is kept of
    /// a wish but the last one, so that a flood of wishes takes no memory.
    async fn follow_wish(self: &Arc<Self>, query: &str) -> Answer {
        let (scenery, phase) = {
            let pinned = self.board.lock();
            (pinned.scenery.clone(), pinned.state.phase)
        };
        let Some(scenery) = scenery else { return text(404, IMMOVABLE) };
        if phase == Phase::Rendering {
            return text(409, "A picture is being rendered; end that first.");
        }
        let wished = {
            let asked = Query::new(query);
            let is_moving = asked.0.get("moving") == Some(&"1");
            let pose = Pose::read(|name| asked.0.get(name).copied());
            pose.and_then(|pose| Ok((pose, pose.camera(&scenery.cameras)?, is_moving)))
        };
        let (pose, camera, is_moving) = match wished {
            Ok(wished) => wished,
            Err(sentence) => return text(400, &sentence),
        };
        let mut changes = self.board.changes();
        let number = self.board.wish(pose, camera, is_moving);
        let end = (Instant::now() + MOVE_TIME).into();
        loop {
            changes.mark_unchanged();
            let followed = self.board.lock().followed.clone();
            match followed {
                (wish, Some(sentence)) if wish == number => return text(400, &sentence),
                (wish, _) if wish >= number => return self.work("/layer", query).await,
                _ if self.board.is_closed() => return empty(),
                _ => {}
            }
            if timeout_at(end, changes.changed()).await.is_err() {
                return empty();
            }
        }
    }

    /// Answers what takes time.
    async fn work(self: &Arc<Self>, path: &str, query: &str) -> Answer {
        let answering = Answering::new(&self.board);
        let (desk, path, query) = (Arc::clone(self), path.to_owned(), query.to_owned());
        let is_denoised = path == "/layer" && Query::new(&query).layer() == DENOISED;
        let workers = if is_denoised { &self.denoiser } else { &self.workers };
        let made = workers.run(self.most_bytes(&path), move || desk.make(&path, &Query::new(&query))).await;
        let (answer, permit) = match made {
            Ok((answer, permit)) => (answer, Some(permit)),
            Err(Failure::Busy) => (text(503, "Too many pages ask at once."), None),
            Err(Failure::Panicked) => {
                (text(500, "This answer failed; the terminal says why. The render goes on."), None)
            }
        };
        claiming(answer, (permit, Some(answering)))
    }

    /// Most bytes of the content of an answer: three half floats a pixel, or a number a pixel and one a cell. Facts about one pixel
    /// are few.
    fn most_bytes(&self, path: &str) -> u64 {
        let pinned = self.board.lock();
        let pixels = pinned.shot.as_ref().map_or(0, |shot| shot.size().map(u64::from).iter().product());
        match path {
            "/layer" => 6 * pixels,
            "/cells" => 4 * (pixels + pinned.cells.as_ref().map_or(0, |cells| u64::from(cells.cells.count()))),
            _ => 0,
        }
    }

    fn make(&self, path: &str, query: &Query<'_>) -> Answer {
        match path {
            "/layer" => self.layer(query.layer()),
            "/cells" => self.cells(),
            _ => self.pixel(query),
        }
    }

    fn follow(&self, path: &str) -> Answer {
        let order = match path {
            "/pause" => Order::Pause,
            "/go-on" => Order::GoOn,
            "/stop" => Order::Stop,
            "/write" => Order::Write,
            "/render" => Order::Render,
            _ => return text(404, "There is no such order."),
        };
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
        let Some(plane) = shot.plane(name) else {
            return text(404, if name == DENOISED { denoiser::MISSING } else { "The picture has no such layer." });
        };
        let noise = self.noise(&shot);
        let ([width, height], (halves, factor)) = (shot.size(), plane.halves());
        let frame = Frame {
            shot: shot.number,
            wish: shot.wish,
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
            *curve = thinned(std::mem::take(curve));
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

    fn pixel(&self, query: &Query<'_>) -> Answer {
        self.board.wants_guide.store(true, Ordering::Relaxed);
        let (Some(x), Some(y)) = (query.number("x"), query.number("y")) else {
            return text(400, "Write it as /pixel?x=1&y=2.");
        };
        let pinned = self.board.lock();
        let (shot, cells, copy) = (pinned.shot.clone(), pinned.cells.clone(), pinned.guide.clone());
        drop(pinned);
        let Some(shot) = shot else { return empty() };
        match PixelFacts::new(&shot, [x, y], cells.as_deref().zip(copy.as_deref())) {
            Some(facts) => json(&facts),
            None => text(404, "The picture has no such pixel."),
        }
    }
}

/// Names and values of a request's query.
struct Query<'a>(HashMap<&'a str, &'a str>);

impl<'a> Query<'a> {
    fn new(query: &'a str) -> Self {
        Self(query.split('&').filter_map(|pair| pair.split_once('=')).collect())
    }

    fn number(&self, name: &str) -> Option<u32> {
        self.0.get(name)?.parse().ok()
    }

    /// Layer that is asked for.
    fn layer(&self) -> &'a str {
        self.0.get("name").copied().unwrap_or("radiance")
    }
}

/// The only header of a name; an empty text where there are several, or where it is no text.
fn only<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let first = values.next()?;
    Some(first.to_str().ok().filter(|_| values.next().is_none()).unwrap_or_default())
}

/// A file of the page.
fn file(path: &str) -> Option<Answer> {
    let (_, kind, content) = FILES.iter().find(|(file, _, _)| *file == path)?;
    Some(bytes(*content, kind))
}
