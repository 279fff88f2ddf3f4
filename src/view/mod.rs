//! Live views of a render: a page in a browser, and the display server tev.
//!
//! A render never waits for its viewers. Between two steps it looks whether somebody has asked for something, and hands a copy over
//! if so. All other work is done by threads of the viewers.
//!
//! | part | file |
//! |---|---|
//! | what render and viewers share | `board.rs`, `shot.rs` |
//! | the render's side | `viewers.rs` |
//! | the server of the page | `server.rs`, `guard.rs` (who may ask), `routes.rs` (answers) |
//! | one pixel, and what the guide has learned there | `pixel.rs`, `guide.rs` |
//! | layers of a picture | `planes.rs` |
//! | the page | `page/` |
//! | tev's protocol | `tev.rs` (packets), `display.rs` (when they are sent) |

mod board;
mod display;
mod guard;
mod guide;
mod pixel;
mod planes;
mod routes;
mod server;
mod shot;
#[doc(hidden)]
pub mod tev;
mod viewers;

pub use server::{FileView, check_address};
pub use viewers::{ViewOptions, Viewers};
