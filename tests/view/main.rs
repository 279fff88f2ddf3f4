//! Views of a render: the page in a real browser, its server as other programs see it, and tev's protocol.

mod browser;
mod display;
mod page;
mod program;
mod server;
