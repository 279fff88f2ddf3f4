//! Answers: their headers, and contents that are sent in parts.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::task::{Context, Poll};

use hyper::Response;
use hyper::body::{Body, Bytes, Frame, SizeHint};
use hyper::header::{CONNECTION, CONTENT_TYPE, HeaderName, HeaderValue};
use serde::Serialize;
use tokio::sync::{OwnedSemaphorePermit, mpsc};

use crate::view::board::Board;
use crate::view::limits::PART_BYTES;

/// Headers of every answer. The page may load nothing from elsewhere, and no other page may show or read it.
const HEADERS: &[(&str, &str)] = &[
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cache-control", "no-store"),
];

/// An answer.
pub type Answer = Response<Content>;

/// Content of an answer.
pub struct Content {
    data: Data,
    /// Claims that end when all is handed over.
    _claims: Claims,
}

enum Data {
    /// Bytes that are left.
    Whole(Bytes),
    /// Events that are still to come.
    Events(mpsc::Receiver<Bytes>),
}

/// Whatever an answer keeps in use: a permit of workers or of listeners, and a place among the answers that the render waits for.
pub type Claims = (Option<OwnedSemaphorePermit>, Option<Answering>);

/// Count of a request that is being answered.
pub struct Answering(Arc<Board>);

impl Answering {
    pub fn new(board: &Arc<Board>) -> Self {
        board.answering.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(board))
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        self.0.answering.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Body for Content {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        match &mut self.data {
            Data::Whole(left) if left.is_empty() => Poll::Ready(None),
            Data::Whole(left) => Poll::Ready(Some(Ok(Frame::data(left.split_to(left.len().min(PART_BYTES)))))),
            Data::Events(events) => events.poll_recv(context).map(|event| Some(Ok(Frame::data(event?)))),
        }
    }

    fn is_end_stream(&self) -> bool {
        matches!(&self.data, Data::Whole(left) if left.is_empty())
    }

    fn size_hint(&self) -> SizeHint {
        match &self.data {
            Data::Whole(left) => SizeHint::with_exact(left.len() as u64),
            Data::Events(_) => SizeHint::default(),
        }
    }
}

/// Answer with the headers that every answer has.
fn answer(status: u16, data: Data, kind: Option<&'static str>) -> Answer {
    let mut answer = Response::new(Content { data, _claims: Claims::default() });
    *answer.status_mut() = hyper::StatusCode::from_u16(status).unwrap_or_default();
    let headers = answer.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    if let Some(kind) = kind {
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    }
    answer
}

/// Answer with bytes of a kind.
pub fn bytes(content: impl Into<Bytes>, kind: &'static str) -> Answer {
    answer(200, Data::Whole(content.into()), Some(kind))
}

/// Answer with bytes, and with facts about them in the header `X-Frame`.
pub fn framed(content: Vec<u8>, frame: &impl Serialize) -> Answer {
    let mut answer = bytes(content, "application/octet-stream");
    let frame = ascii(&serde_json::to_string(frame).unwrap_or_default());
    if let Ok(frame) = HeaderValue::try_from(frame) {
        answer.headers_mut().insert(HeaderName::from_static("x-frame"), frame);
    }
    answer
}

/// JSON in ASCII, as headers need it.
fn ascii(json: &str) -> String {
    let mut units = [0; 2];
    let mut escaped =
        |c: char| c.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}")).collect::<String>();
    json.chars().map(|c| if c.is_ascii() { c.to_string() } else { escaped(c) }).collect()
}

/// Answer with JSON.
pub fn json(value: &impl Serialize) -> Answer {
    bytes(serde_json::to_vec(value).unwrap_or_default(), "application/json")
}

/// Answer with a sentence.
pub fn text(status: u16, sentence: &str) -> Answer {
    answer(status, Data::Whole(format!("{sentence}\n").into()), Some("text/plain; charset=utf-8"))
}

/// Answer that there is nothing yet, or nothing to say.
pub fn empty() -> Answer {
    answer(204, Data::Whole(Bytes::new()), None)
}

/// Answer with events. The connection ends with them.
pub fn events(events: mpsc::Receiver<Bytes>) -> Answer {
    last(answer(200, Data::Events(events), Some("text/event-stream")))
}

/// An answer after which the connection ends.
pub fn last(mut answer: Answer) -> Answer {
    answer.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
    answer
}

/// An answer that keeps something in use until it is handed over.
pub fn claiming(answer: Answer, claims: Claims) -> Answer {
    answer.map(|content| Content { _claims: claims, ..content })
}
