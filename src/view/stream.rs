//! Stream to a browser that does not wait for ever: whoever takes no data is dropped.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::Sleep;

/// Stream whose writes fail after a wait without progress. The HTTP library limits the time of reading only.
pub struct Patient<S, W: Fn() -> F, F = Sleep> {
    stream: S,
    /// Begins a wait, which ends when patience does.
    wait: W,
    /// Wait of a write that has made no progress yet.
    waiting: Option<Pin<Box<F>>>,
}

impl<S, W: Fn() -> F, F: Future<Output = ()>> Patient<S, W, F> {
    /// Stream that gives up when what `wait` returns is ready.
    pub fn new(stream: S, wait: W) -> Self {
        Self { stream, wait, waiting: None }
    }

    /// Passes the result of a write on, or the end of patience.
    fn limited(&mut self, context: &mut Context<'_>, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if written.is_pending() {
            let waiting = self.waiting.get_or_insert_with(|| Box::pin((self.wait)()));
            ready!(waiting.as_mut().poll(context));
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        self.waiting = None;
        written
    }
}

impl<S, W, F> AsyncRead for Patient<S, W, F>
where
    S: AsyncRead + Unpin,
    W: Fn() -> F + Unpin,
    F: Future<Output = ()>,
{
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, to: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, to)
    }
}

impl<S, W, F> AsyncWrite for Patient<S, W, F>
where
    S: AsyncWrite + Unpin,
    W: Fn() -> F + Unpin,
    F: Future<Output = ()>,
{
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.limited(context, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, parts);
        self.limited(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::task::Waker;

    use super::*;

    /// Browser that takes no data, or a byte of each write.
    struct Browser<'a>(&'a Cell<bool>);

    impl AsyncWrite for Browser<'_> {
        fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, _: &[u8]) -> Poll<io::Result<usize>> {
            if self.0.get() { Poll::Ready(Ok(1)) } else { Poll::Pending }
        }

        fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }

        fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    /// Patience lasts three looks in this test, so that no clock is asked.
    #[test]
    fn whoever_takes_no_data_is_dropped_and_whoever_is_slow_is_not() {
        let takes_data = Cell::new(false);
        let wait = || {
            let mut looks = 0;
            std::future::poll_fn(move |_| {
                looks += 1;
                if looks > 3 { Poll::Ready(()) } else { Poll::Pending }
            })
        };
        let mut stream = Patient::new(Browser(&takes_data), wait);
        let mut context = Context::from_waker(Waker::noop());
        let mut write = |ready: bool| {
            takes_data.set(ready);
            Pin::new(&mut stream).poll_write(&mut context, &[0; 4096]).map_err(|error| error.kind())
        };
        for _ in 0..10 {
            for _ in 0..3 {
                assert_eq!(write(false), Poll::Pending);
            }
            // Whoever takes a byte in time has all patience again.
            assert_eq!(write(true), Poll::Ready(Ok(1)));
        }
        for _ in 0..3 {
            assert_eq!(write(false), Poll::Pending);
        }
        assert_eq!(write(false), Poll::Ready(Err(io::ErrorKind::TimedOut)));
    }
}
