//! Guard of the server: who may ask for what.
//!
//! Another page in the user's browser can send requests to this machine. Its requests name its own origin, or reach the server
//! under a name that the other page's owner controls. Both are refused. What tells something about a render, or changes it, also
//! needs the token, which only the printed address has.

use std::fs::File;
use std::hint::black_box;
use std::io::Read;
use std::net::{IpAddr, SocketAddr};
use std::ops::RangeInclusive;
use std::path::Path;

use crate::{Error, Result};

/// Environment variable with a token that the user has chosen.
const TOKEN_VARIABLE: &str = "LODESTAR_VIEW_TOKEN";
/// Lengths of the user's token. Sixteen random letters and digits cannot be guessed through a network.
const LENGTHS: RangeInclusive<usize> = 16..=128;
/// Bytes of a new token.
const TOKEN_BYTES: usize = 16;
/// Source of random bytes.
const RANDOM: &str = "/dev/urandom";

/// Headers of a request that the guard reads. One that comes twice or is no text is an empty text here, which nothing allows.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Asking<'a> {
    pub host: Option<&'a str>,
    pub origin: Option<&'a str>,
    /// `Sec-Fetch-Site`, by which browsers say where a request comes from.
    pub site: Option<&'a str>,
    pub token: Option<&'a str>,
}

/// The guard of one server.
pub(super) struct Guard {
    address: SocketAddr,
    token: Token,
}

/// Secret of whoever may look at the render and change it.
pub(super) struct Token {
    text: String,
    is_of_user: bool,
}

impl Token {
    /// The user's token, or a new one.
    ///
    /// # Errors
    /// Where the user's token is short or has other characters than addresses do.
    pub fn find() -> Result<Self> {
        match std::env::var_os(TOKEN_VARIABLE).filter(|value| !value.is_empty()) {
            Some(value) => Self::of_user(value.to_str().unwrap_or_default()),
            None => Self::new(),
        }
    }

    fn new() -> Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        File::open(RANDOM).and_then(|mut file| file.read_exact(&mut bytes)).map_err(Error::read(Path::new(RANDOM)))?;
        Ok(Self { text: bytes.map(|byte| format!("{byte:02x}")).concat(), is_of_user: false })
    }

    fn of_user(text: &str) -> Result<Self> {
        let is_right = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~+/=".contains(&byte);
        if !LENGTHS.contains(&text.len()) || !text.bytes().all(is_right) {
            let [least, most] = [LENGTHS.start(), LENGTHS.end()];
            let sentence = format!(
                "{TOKEN_VARIABLE} is no token: it needs {least} to {most} characters, which may be letters, digits and - . _ ~ + / ="
            );
            return Err(Error::Settings(sentence));
        }
        Ok(Self { text: text.to_owned(), is_of_user: true })
    }
}

impl Guard {
    /// Guard of the server at `address`.
    pub fn new(address: SocketAddr, token: Token) -> Self {
        Self { address, token }
    }

    /// Address of the page, with the token. Browsers send the part after `#` to nobody. In place of the user's token, which outlives
    /// the render, stands the name of its variable, because what is printed may be kept.
    pub fn url(&self) -> String {
        let ip = match self.address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => "127.0.0.1".to_owned(),
            IpAddr::V6(ip) if ip.is_unspecified() => "[::1]".to_owned(),
            IpAddr::V4(ip) => ip.to_string(),
            IpAddr::V6(ip) => format!("[{ip}]"),
        };
        let token = if self.token.is_of_user { TOKEN_VARIABLE } else { &self.token.text };
        format!("http://{ip}:{}/#{token}", self.address.port())
    }

    /// Whether a request is from the server's own page, or from a program, but from no other page.
    pub fn is_from_own_page(&self, asking: &Asking<'_>) -> bool {
        let Some(host) = asking.host.filter(|host| self.is_own(host)) else { return false };
        let is_own_origin = |origin: &str| origin.strip_prefix("http://").is_some_and(|rest| rest == host);
        asking.origin.is_none_or(is_own_origin) && asking.site.is_none_or(|site| matches!(site, "same-origin" | "none"))
    }

    /// Whether a request has the token.
    pub fn has_token(&self, asking: &Asking<'_>) -> bool {
        asking.token.is_some_and(|token| is_same(token.as_bytes(), self.token.text.as_bytes()))
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
    a.len() == b.len() && a.iter().zip(b).fold(0, |difference, (a, b)| black_box(difference | (a ^ b))) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: &str) -> Guard {
        Guard::new(address.parse().unwrap(), Token::new().unwrap())
    }

    fn asking<'a>(host: &'a str, origin: Option<&'a str>, site: Option<&'a str>) -> Asking<'a> {
        Asking { host: Some(host), origin, site, token: None }
    }

    #[test]
    fn pages_of_others_are_refused() {
        let guard = guard("127.0.0.1:8000");
        let may = |host, origin, site| guard.is_from_own_page(&asking(host, origin, site));
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
        assert!(!guard.is_from_own_page(&Asking::default()), "no host");
    }

    #[test]
    fn an_open_server_is_reached_by_addresses_and_short_names() {
        let guard = guard("0.0.0.0:8000");
        let may = |host| guard.is_from_own_page(&asking(host, None, None));
        assert!(may("10.1.2.3:8000") && may("rack7:8000") && may("127.0.0.1:8000"));
        assert!(!may("rack7.evil.example:8000") && !may(":8000") && !may(""));
    }

    #[test]
    fn only_the_printed_address_has_the_token() {
        let guard = guard("127.0.0.1:8000");
        let url = guard.url();
        let (address, token) = url.split_once("/#").unwrap();
        assert_eq!((address, token.len()), ("http://127.0.0.1:8000", 2 * TOKEN_BYTES));
        let has = |token| guard.has_token(&Asking { token, ..asking("localhost:8000", None, None) });
        assert!(has(Some(token)));
        assert!(!has(None) && !has(Some("")) && !has(Some(&token[1..])) && !has(Some(&"0".repeat(token.len()))));
        assert_ne!(url, super::tests::guard("127.0.0.1:8000").url(), "every server has its own");
    }

    #[test]
    fn the_users_token_is_long_enough_and_not_printed() {
        let longest = "a".repeat(128);
        for text in ["0123456789abcdef", "-._~+/=-._~+/=ZZ", &longest] {
            let guard = Guard::new("[::]:80".parse().unwrap(), Token::of_user(text).unwrap());
            assert!(guard.has_token(&Asking { token: Some(text), ..Asking::default() }));
            assert_eq!(guard.url(), "http://[::1]:80/#LODESTAR_VIEW_TOKEN");
        }
        let too_long = "a".repeat(129);
        for text in ["", "0123456789abcde", "0123456789 abcdef", "0123456789abcdef#", "pässword-pässword", &too_long]
        {
            let sentence = Token::of_user(text).err().unwrap().to_string();
            assert!(
                sentence.starts_with("LODESTAR_VIEW_TOKEN is no token: it needs 16 to 128 characters"),
                "{sentence}"
            );
            assert!(text.is_empty() || !sentence.contains(text), "the secret is not told");
        }
    }
}
