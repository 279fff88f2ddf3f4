//! Views of a render: the page in a real browser, its server as other programs and strangers see it, and tev's protocol.

mod browser;
mod display;
mod hostile;
mod moving;
mod page;
mod program;
mod server;
