//! Live views of a render: a page in a browser, and the display server tev.
//!
//! A render never waits for its viewers. Between two steps it looks whether somebody has asked for something, and hands a copy over
//! if so. All other work is done by threads of the viewers.
//!
//! | part | file |
//! |---|---|
//! | what render and viewers share | `board.rs`, `shot.rs` |
//! | the render's side | `viewers.rs`, `file.rs` (a picture file instead of a render), `moving.rs` (a camera that moves), `detail.rs` (how small its pictures are) |
//! | cameras | `pose.rs` |
//! | the server of the page | `server.rs`, `limits.rs` (what it bounds), `guests.rs` (who is connected), `stream.rs` (slow readers) |
//! | requests | `guard.rs` (who may ask), `routes.rs` (answers), `content.rs`, `events.rs`, `workers.rs` (what takes time) |
//! | one pixel, and what the guide has learned there | `pixel.rs`, `guide.rs` |
//! | layers of a picture | `planes.rs`, `denoiser.rs` |
//! | names of files | `names.rs` |
//! | the page | `page/` |
//! | tev's protocol | `tev.rs` (packets), `display.rs` (when they are sent) |

mod board;
mod content;
mod denoiser;
mod detail;
mod display;
mod events;
mod file;
mod guard;
mod guests;
mod guide;
mod limits;
mod moving;
mod names;
mod pixel;
mod planes;
mod pose;
mod routes;
mod server;
mod shot;
mod stream;
#[doc(hidden)]
pub mod tev;
mod viewers;
mod workers;

pub use file::FileView;
pub use moving::{MovingOptions, MovingView};
pub use viewers::{ViewOptions, Viewers};
