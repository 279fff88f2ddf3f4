//! Guard of the server: who may ask for what.
//!
//! Another page in the user's browser can send requests to this machine. Its requests name its own origin, or reach the server
//! under a name that the other page's owner controls. Both are refused. What changes a render also needs the token, which only
//! the printed address has.

use std::fs::File;
use std::io::Read;
use std::net::{IpAddr, SocketAddr};
use std::path::Path;

use crate::{Error, Result};

/// Bytes of a token.
const TOKEN_BYTES: usize = 16;
/// Source of random bytes.
const RANDOM: &str = "/dev/urandom";

/// Headers of a request that the guard reads.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Asking<'a> {
    pub host: Option<&'a str>,
    pub origin: Option<&'a str>,
    /// `Sec-Fetch-Site`, by which browsers say where a request comes from.
    pub site: Option<&'a str>,
    pub token: Option<&'a str>,
}

/// The guard of one server.
#[derive(Debug)]
pub(super) struct Guard {
    address: SocketAddr,
    token: String,
}

impl Guard {
    /// Guard of the server at `address`, with a new token.
    pub fn new(address: SocketAddr) -> Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        File::open(RANDOM).and_then(|mut file| file.read_exact(&mut bytes)).map_err(Error::read(Path::new(RANDOM)))?;
        Ok(Self { address, token: bytes.map(|byte| format!("{byte:02x}")).concat() })
    }

    /// Address of the page, with the token. Browsers send the part after `#` to nobody.
    pub fn url(&self) -> String {
        let ip = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => "127.0.0.1".to_owned(),
            IpAddr::V6(ip) if ip.is_unspecified() => "[::1]".to_owned(),
            IpAddr::V4(ip) => ip.to_string(),
            IpAddr::V6(ip) => format!("[{ip}]"),
        };
        format!("http://{ip}:{}/#{}", self.address.port(), self.token)
    }

    /// Whether a request may look at the render.
    pub fn may_look(&self, asking: &Asking<'_>) -> bool {
        let Some(host) = asking.host.filter(|host| self.is_own(host)) else { return false };
        let is_own_origin = |origin: &str| origin.strip_prefix("http://").is_some_and(|rest| rest == host);
        asking.origin.is_none_or(is_own_origin) && asking.site.is_none_or(|site| matches!(site, "same-origin" | "none"))
    }

    /// Whether a request may change the render.
    pub fn may_change(&self, asking: &Asking<'_>) -> bool {
        self.may_look(asking) && asking.token.is_some_and(|token| is_same(token.as_bytes(), self.token.as_bytes()))
    }

    /// Whether `host` is a name of this server. A server of the local machine has the names of the local machine. Another one is
    /// reached by an address or by a name without dots, because the owner of a page cannot choose such a name. The port is that of
    /// the server or of a tunnel to it.
    fn is_own(&self, host: &str) -> bool {
        let (name, port) = host.rsplit_once(':').filter(|(_, port)| !port.ends_with(']')).unwrap_or((host, "80"));
        let address: Option<IpAddr> = name.trim_start_matches('[').trim_end_matches(']').parse().ok();
        let is_own_name = match address {
            Some(ip) => !self.address.ip().is_loopback() || ip.is_loopback(),
            None if self.address.ip().is_loopback() => name.eq_ignore_ascii_case("localhost"),
            None => !name.is_empty() && !name.contains('.'),
        };
        is_own_name && port.parse::<u16>().is_ok()
    }
}

/// Whether two texts are the same. The time does not tell where they differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |difference, (a, b)| difference | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: &str) -> Guard {
        Guard::new(address.parse().unwrap()).unwrap()
    }

    fn asking<'a>(host: &'a str, origin: Option<&'a str>, site: Option<&'a str>) -> Asking<'a> {
        Asking { host: Some(host), origin, site, token: None }
    }

    #[test]
    fn pages_of_others_are_refused() {
        let guard = guard("127.0.0.1:8000");
        let may = |host, origin, site| guard.may_look(&asking(host, origin, site));
        assert!(may("127.0.0.1:8000", None, None));
        assert!(may("localhost:8000", Some("http://localhost:8000"), Some("same-origin")));
        assert!(may("[::1]:8000", None, Some("none")));
        assert!(may("127.0.0.1:9000", Some("http://127.0.0.1:9000"), None), "a tunnel");
        assert!(may("localhost", None, None) && may("[::1]", None, None), "a tunnel from port 80");
        assert!(!may("127.0.0.1:evil.example", None, None));
        assert!(!may("evil.example:8000", None, None), "a name that leads here");
        assert!(!may("127.0.0.1.evil.example:8000", None, None));
        assert!(!may("127.0.0.1:8000", Some("http://evil.example"), None));
        assert!(!may("127.0.0.1:8000", Some("null"), None));
        assert!(!may("127.0.0.1:8000", Some("https://127.0.0.1:8000"), None));
        assert!(!may("127.0.0.1:8000", Some("http://127.0.0.1:9000"), None));
        assert!(!may("127.0.0.1:8000", None, Some("cross-site")));
        assert!(!may("127.0.0.1:8000", None, Some("same-site")), "another port of this machine");
        assert!(!may("10.1.2.3:8000", None, None));
        assert!(!guard.may_look(&Asking::default()), "no host");
    }

    #[test]
    fn an_open_server_is_reached_by_addresses_and_short_names() {
        let guard = guard("0.0.0.0:8000");
        let may = |host| guard.may_look(&asking(host, None, None));
        assert!(may("10.1.2.3:8000") && may("rack7:8000") && may("127.0.0.1:8000"));
        assert!(!may("rack7.evil.example:8000") && !may(":8000") && !may(""));
    }

    #[test]
    fn changes_need_the_token() {
        let guard = guard("127.0.0.1:8000");
        let url = guard.url();
        let (address, token) = url.split_once("/#").unwrap();
        assert_eq!((address, token.len()), ("http://127.0.0.1:8000", 2 * TOKEN_BYTES));
        let may = |token| guard.may_change(&Asking { token, ..asking("localhost:8000", None, None) });
        assert!(may(Some(token)));
        assert!(!may(None) && !may(Some("")) && !may(Some(&token[1..])) && !may(Some(&"0".repeat(token.len()))));
        let foreign = asking("localhost:8000", Some("http://evil.example"), None);
        assert!(!guard.may_change(&Asking { token: Some(token), ..foreign }));
        assert_ne!(url, super::tests::guard("127.0.0.1:8000").url(), "every server has its own");
    }
}
