//! Stream to a browser that does not wait for ever: whoever takes no data is dropped.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Sleep, sleep};

/// Stream whose writes fail after a time without progress. The HTTP library limits the time of reading only.
pub struct Patient {
    stream: TcpStream,
    patience: Duration,
    /// Time that is left to a write that waits.
    left: Option<Pin<Box<Sleep>>>,
}

impl Patient {
    pub fn new(stream: TcpStream, patience: Duration) -> Self {
        Self { stream, patience, left: None }
    }

    /// Passes the result of a write on, or the end of patience.
    fn limited(&mut self, context: &mut Context<'_>, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if written.is_pending() {
            let patience = self.patience;
            let left = self.left.get_or_insert_with(|| Box::pin(sleep(patience)));
            ready!(left.as_mut().poll(context));
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        self.left = None;
        written
    }
}

impl AsyncRead for Patient {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, to: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, to)
    }
}

impl AsyncWrite for Patient {
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
    use std::future::poll_fn;
    use std::io::Read;
    use std::net::TcpListener;

    use super::*;

    /// Writes until the stream fails, as a server does to a page. Returns the number of bytes.
    async fn write_all(mut stream: Patient) -> (usize, io::ErrorKind) {
        let mut written = 0;
        loop {
            match poll_fn(|context| Pin::new(&mut stream).poll_write(context, &[0; 4096])).await {
                Ok(count) => written += count,
                Err(error) => return (written, error.kind()),
            }
        }
    }

    #[test]
    fn whoever_takes_no_data_is_dropped_and_whoever_is_slow_is_not() {
        let patience = Duration::from_secs(1);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let address = listener.local_addr().unwrap();
        let connect = || async { Patient::new(TcpStream::connect(address).await.unwrap(), patience) };
        let hung = runtime.block_on(async { write_all(connect().await).await });
        assert!(hung.0 > 0 && hung.1 == io::ErrorKind::TimedOut, "{hung:?}");

        drop(listener.accept().unwrap());
        let slow = std::thread::spawn(move || {
            let (mut page, _) = listener.accept().unwrap();
            let mut bytes = vec![0; 8 << 20];
            // It reads what has come, three times as long as the patience lasts.
            for _ in 0..30 {
                std::thread::sleep(patience / 10);
                let _ = page.read(&mut bytes).unwrap();
            }
        });
        let begin = std::time::Instant::now();
        let (written, error) = runtime.block_on(async { write_all(connect().await).await });
        assert!(begin.elapsed() > 2 * patience && written > hung.0, "{written} bytes, {error:?}");
        slow.join().unwrap();
    }
}
