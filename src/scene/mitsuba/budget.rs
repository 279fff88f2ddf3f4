//! Limits on a scene's XML with all its includes, far above what real files have. They hold before memory is taken, because a few hundred
//! bytes can ask for any amount of it.

use crate::scene::text::Decoded;

/// Most bytes of all XML files together, each counted as often as it is included: 2^20 instances, the most shapes of a scene, take 160
/// bytes each.
pub(super) const MOST_BYTES: u64 = 256 << 20;
/// Most files that a scene includes, each counted as often as it is included.
const MOST_INCLUDES: u32 = 4096;
/// Most elements, with comments and instructions: 2^20 instances have four each.
const MOST_ELEMENTS: u32 = 1 << 23;
/// Most attributes: two for each element.
const MOST_ATTRIBUTES: u32 = 1 << 24;
/// Most attributes of one element. The parser compares each with all before it.
const MOST_OF_ELEMENT: u32 = 64;
/// Most namespaces that one file declares. The parser copies the list of them.
const MOST_NAMESPACES: u32 = 64;
/// Deepest nesting of elements: far above any nesting of plugins, far below the limit of recursion.
pub(super) const MAX_ELEMENT_DEPTH: usize = 64;
/// Most bytes that the values of `$name`s put in their places.
const MOST_EXPANDED: usize = 64 << 20;

/// Most nodes of one file's tree: elements, and the text around each.
pub(super) const MOST_NODES: u32 = 2 * MOST_ELEMENTS + 1;

/// Message of a tree with more nodes.
pub(super) fn too_many_elements() -> String {
    format!("with it the scene's XML has more than {MOST_ELEMENTS} elements; join shapes to meshes")
}

/// What has been read so far of that which has a limit.
#[derive(Default)]
pub(super) struct Budget {
    bytes: u64,
    includes: u32,
    elements: u32,
    attributes: u32,
    expanded: usize,
}

/// Reason of a refusal, and the offset in the file at which it lies.
pub(super) type Refusal = (usize, String);

impl Budget {
    /// Counts a file that is included. The error says that there are too many.
    pub fn include(&mut self) -> Result<(), String> {
        self.includes += 1;
        match self.includes > MOST_INCLUDES {
            true => Err(format!("the scene includes more than {MOST_INCLUDES} files; write them into fewer")),
            false => Ok(()),
        }
    }

    /// Counts bytes that the value of a `$name` puts in its place. The error says that they are too many.
    pub fn expand(&mut self, length: usize) -> Result<(), String> {
        self.expanded = self.expanded.saturating_add(length);
        match self.expanded > MOST_EXPANDED {
            true => Err(format!(
                "the values that replace $names have more than {MOST_EXPANDED} bytes in all; give shorter values by <default> or -D"
            )),
            false => Ok(()),
        }
    }

    /// Counts what is in the text of a file, before a tree is made of it. What is no well-formed XML is left to the parser, which reads no
    /// further than to the first fault.
    pub fn count(&mut self, text: &Decoded) -> Result<(), Refusal> {
        self.bytes += text.file_bytes;
        if self.bytes > MOST_BYTES {
            return Err((
                0,
                format!("with it the scene's XML has more than {MOST_BYTES} bytes; join shapes to meshes"),
            ));
        }
        let text = text.text.as_str();
        let (mut at, mut depth, mut namespaces) = (0, 0, 0);
        while let Some(begin) = text[at..].find('<').map(|found| at + found) {
            let rest = &text[begin..];
            let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("</", ">")];
            if let Some((start, end)) = skipped.into_iter().find(|(start, _)| rest.starts_with(start)) {
                let Some(length) = rest[start.len()..].find(end) else { return Ok(()) };
                at = begin + start.len() + length + end.len();
                match start {
                    "</" => depth -= 1,
                    _ => self.count_element(begin)?,
                }
                continue;
            }
            self.count_element(begin)?;
            let Some(tag) = Tag::read(rest) else { return Ok(()) };
            at = begin + tag.length;
            namespaces += tag.namespaces;
            self.attributes += tag.attributes;
            depth += i64::from(!tag.is_closed);
            let refused = if tag.attributes > MOST_OF_ELEMENT {
                format!("an element with more than {MOST_OF_ELEMENT} attributes is refused; no plugin has so many")
            } else if self.attributes > MOST_ATTRIBUTES {
                format!("with it the scene's XML has more than {MOST_ATTRIBUTES} attributes; join shapes to meshes")
            } else if namespaces > MOST_NAMESPACES {
                format!("the file declares more than {MOST_NAMESPACES} namespaces; leave out the attributes `xmlns`")
            } else if depth + i64::from(tag.is_closed) > MAX_ELEMENT_DEPTH as i64 + 1 {
                format!("elements are nested more than {MAX_ELEMENT_DEPTH} deep")
            } else {
                continue;
            };
            return Err((begin, refused));
        }
        Ok(())
    }

    fn count_element(&mut self, at: usize) -> Result<(), Refusal> {
        self.elements += 1;
        if self.elements > MOST_ELEMENTS { Err((at, too_many_elements())) } else { Ok(()) }
    }
}

/// Begin of an element.
struct Tag {
    /// Length in bytes.
    length: usize,
    attributes: u32,
    /// Number of the attributes that declare a namespace.
    namespaces: u32,
    /// Whether the element has no content.
    is_closed: bool,
}

impl Tag {
    /// Reads a tag from its `<` on; `None` where it does not end.
    fn read(text: &str) -> Option<Self> {
        let bytes = text.as_bytes();
        let (mut at, mut attributes, mut namespaces) = (1, 0, 0);
        loop {
            let found = at + bytes[at..].iter().position(|byte| b"\"'>".contains(byte))?;
            if bytes[found] == b'>' {
                let is_closed = bytes[found - 1] == b'/';
                return Some(Self { length: found + 1, attributes, namespaces, is_closed });
            }
            attributes += 1;
            namespaces += u32::from(text[at..found].contains("xmlns"));
            at = found + 1 + bytes[found + 1..].iter().position(|&byte| byte == bytes[found])? + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(text: &str) -> (Budget, Result<(), Refusal>) {
        let mut budget = Budget::default();
        let counted = budget.count(&Decoded { text: text.to_owned(), file_bytes: text.len() as u64 });
        (budget, counted)
    }

    #[test]
    fn what_looks_like_markup_is_not_counted() {
        let text =
            "<?xml version='1.0'?><!-- a='<b c=\"d\">' --><s a=\"x>y='z'\" b='1'><![CDATA[<t u='1'>]]><v/>a=\"b\"</s>";
        let (budget, counted) = count(text);
        // The instruction, the comment and the section count as elements.
        assert_eq!((budget.elements, budget.attributes, counted), (5, 2, Ok(())));
        // Ends that are missing are found by the parser.
        for cut in 0..text.len() {
            assert_eq!(count(&text[..cut]).1, Ok(()));
        }
    }

    #[test]
    fn each_limit_is_told_where_it_is_reached() {
        let refused = |text: String| count(&text).1.unwrap_err();
        let many = |begin: &str, one: &dyn Fn(u32) -> String, count| {
            begin.to_owned() + &(0..count).map(one).collect::<String>()
        };
        let one = |i| format!(" a{i}='1'");
        assert_eq!(count(&many("<s><s", &one, 64)).1, Ok(()));
        let (at, message) = refused(many("<s><s", &one, 65) + "/>");
        assert_eq!(
            (at, &message[..]),
            (3, "an element with more than 64 attributes is refused; no plugin has so many")
        );
        assert!(refused(many("", &|i| format!("<s xmlns:n{i}='u'/>"), 65)).1.contains("64 namespaces"));
        assert_eq!(count(&many("", &|_| "<s>".to_owned(), 65)).1, Ok(()));
        assert_eq!(
            refused(many("", &|_| "<s>".to_owned(), 66)),
            (195, "elements are nested more than 64 deep".to_owned())
        );
        assert!(refused("<s/>".repeat(1 + MOST_ELEMENTS as usize)).1.contains("more than 8388608 elements"));
    }
}
