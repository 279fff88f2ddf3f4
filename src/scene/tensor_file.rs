//! Reader of tensor files (Dupuy and Jakob 2018): named arrays of numbers of any dimensions.

use std::ops::Range;

use crate::quoted;

/// Beginning of each file.
const MAGIC: &[u8] = b"tensor_file\0";
/// Bytes of the magic, the version and the number of fields.
const HEADER: usize = MAGIC.len() + 6;
/// Most fields of a file. Those of measured materials have ten.
const MAX_FIELDS: u32 = 256;
/// Most dimensions of a field.
const MAX_DIMENSIONS: u16 = 8;
/// Number by which the format calls bytes.
const UINT8: u8 = 1;
/// Number by which the format calls numbers in single precision.
const FLOAT32: u8 = 10;
/// Bytes of a number of each type of the format; 0 stands for no type.
const TYPE_BYTES: [u64; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// Tensor file whose fields lie within it.
pub(super) struct TensorFile<'b> {
    bytes: &'b [u8],
    fields: Vec<Field<'b>>,
}

struct Field<'b> {
    name: &'b str,
    shape: Vec<usize>,
    kind: u8,
    place: Range<usize>,
}

/// Reader of the header.
struct Cursor<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b> Cursor<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [u8], String> {
        let end = self.at.saturating_add(count);
        let taken = self.bytes.get(self.at..end).ok_or("is cut off within its header")?;
        self.at = end;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self) -> Result<u64, String> {
        let mut wide = [0; 8];
        wide[..N].copy_from_slice(self.take(N)?);
        Ok(u64::from_le_bytes(wide))
    }
}

impl<'b> TensorFile<'b> {
    /// Reads the header. Nothing is copied. The message of an error goes on after the file's name.
    pub fn new(bytes: &'b [u8]) -> Result<Self, String> {
        if !bytes.starts_with(MAGIC) {
            return Err("is no tensor file: it does not begin with `tensor_file`".to_owned());
        }
        if bytes.len() < HEADER {
            return Err("is cut off within its header".to_owned());
        }
        let mut cursor = Cursor { bytes, at: MAGIC.len() };
        let (major, minor) = (cursor.number::<1>()?, cursor.number::<1>()?);
        if (major, minor) != (1, 0) {
            return Err(format!("has version {major}.{minor}; only version 1.0 is supported"));
        }
        let count = cursor.number::<4>()?;
        if count > u64::from(MAX_FIELDS) {
            return Err(format!("has {count} fields; at most {MAX_FIELDS} are supported"));
        }
        let mut fields = Vec::<Field>::new();
        for _ in 0..count {
            let field = Field::read(&mut cursor)?;
            if fields.iter().any(|other| other.name == field.name) {
                return Err(format!("has two fields {}", quoted::word(field.name)));
            }
            fields.push(field);
        }
        Ok(Self { bytes, fields })
    }

    /// Whether there is a field of that name.
    pub fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|field| field.name == name)
    }

    /// Shape and numbers of a field in single precision.
    pub fn numbers(&self, name: &str) -> Result<(&[usize], Vec<f32>), String> {
        let field = self.field(name, FLOAT32, "numbers in single precision")?;
        let (words, _) = self.bytes[field.place.clone()].as_chunks::<4>();
        let numbers: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(format!("has a number that is not finite in its field `{name}`: {number}")),
            None => Ok((&field.shape, numbers)),
        }
    }

    /// Bytes of a field.
    pub fn bytes(&self, name: &str) -> Result<&'b [u8], String> {
        let field = self.field(name, UINT8, "bytes")?;
        Ok(&self.bytes[field.place.clone()])
    }

    fn field(&self, name: &str, kind: u8, wanted: &str) -> Result<&Field<'b>, String> {
        match self.fields.iter().find(|field| field.name == name) {
            Some(field) if field.kind == kind => Ok(field),
            Some(field) => Err(format!("has the field `{name}` of type {}; it should have {wanted}", field.kind)),
            None => Err(format!("has no field `{name}`")),
        }
    }
}

impl<'b> Field<'b> {
    fn read(cursor: &mut Cursor<'b>) -> Result<Self, String> {
        let length = cursor.number::<2>()? as usize;
        let name = std::str::from_utf8(cursor.take(length)?).map_err(|_| "has a field whose name is no text")?;
        let quoted = quoted::word(name);
        let dimensions = cursor.number::<2>()?;
        if dimensions > u64::from(MAX_DIMENSIONS) {
            return Err(format!(
                "has the field {quoted} of {dimensions} dimensions; at most {MAX_DIMENSIONS} are supported"
            ));
        }
        let kind = cursor.number::<1>()? as u8;
        let start = cursor.number::<8>()?;
        let shape = (0..dimensions).map(|_| cursor.number::<8>()).collect::<Result<Vec<_>, _>>()?;
        let width = TYPE_BYTES.get(usize::from(kind)).copied().unwrap_or(0);
        if width == 0 {
            return Err(format!("has the field {quoted} of type {kind}, which is none of the format's"));
        }
        // All sizes of a field that fits are lengths in memory.
        let end =
            shape.iter().try_fold(width, |size, &side| size.checked_mul(side)).and_then(|size| size.checked_add(start));
        let end = end.filter(|&end| end <= cursor.bytes.len() as u64 && !shape.contains(&0));
        let Some(end) = end else {
            let sides: Vec<_> = shape.iter().map(u64::to_string).collect();
            let sides = sides.join(" x ");
            return Err(format!("is cut off or wrong: its field {quoted} of {sides} numbers does not lie within it"));
        };
        let shape = shape.into_iter().map(|side| side as usize).collect();
        Ok(Self { name, shape, kind, place: start as usize..end as usize })
    }
}
