//! Primitives that `KHR_draco_mesh_compression` compresses.

use std::collections::{HashMap, HashSet};

use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, ErrorKind, FaceIndex, Mesh, MeshDecoder, PointAttribute, PointIndex,
};
use serde_json::{Map, Value as Json, json};

use super::super::usual::list;
use super::made::{DRACO, Made, entry, push, whole};
use crate::quoted;

/// Bytes that the decoder needs for each triangle, besides the attributes.
const BYTES_PER_TRIANGLE: usize = 64;

/// Primitive whose data are compressed.
struct Compressed {
    /// Index of the view of the compressed data.
    view: usize,
    /// Name of each attribute, its accessor, and its number in the compressed data.
    attributes: Vec<(String, usize, u32)>,
    /// Accessor of the indices.
    indices: Option<usize>,
}

/// Decodes the compressed primitives.
pub(super) fn decode(root: &mut Map<String, Json>, made: &mut Made) -> Result<(), String> {
    let is_required = root.get("extensionsRequired").and_then(Json::as_array);
    let is_required = is_required.is_some_and(|names| names.iter().any(|name| name == DRACO));
    let mut places = Vec::new();
    for (mesh, object) in list(root.get_mut("meshes")).iter_mut().enumerate() {
        let primitives = list(object.get_mut("primitives")).iter().enumerate();
        let is_compressed = |primitive: &Json| primitive.get("extensions").is_some_and(|all| all.get(DRACO).is_some());
        places.extend(primitives.filter(|(_, object)| is_compressed(object)).map(|(primitive, _)| (mesh, primitive)));
    }
    // Accessors that have been given decoded data.
    let mut filled = HashSet::new();
    // Primitives that have been decoded, because several may share all their data.
    let mut known: HashMap<String, Json> = HashMap::new();
    for (mesh, primitive) in places {
        let fault = |message: String| format!("mesh {mesh}: {message}");
        let Some(object) =
            entry(root, "meshes", mesh).and_then(|mesh| list(mesh.get_mut("primitives")).get_mut(primitive))
        else {
            continue;
        };
        let before = object.clone();
        let data = json!([before["extensions"][DRACO], before["attributes"], before["indices"]]).to_string();
        if let Some(decoded) = known.get(&data) {
            for name in ["attributes", "indices", "mode"] {
                object[name] = decoded[name].clone();
            }
            continue;
        }
        let compressed = Compressed::of(&before).map_err(fault)?;
        if !is_required && compressed.has_plain_data(root) {
            continue;
        }
        let decoded = compressed.decode(root, made, &mut filled, &before).map_err(fault)?;
        if let Some(object) =
            entry(root, "meshes", mesh).and_then(|mesh| list(mesh.get_mut("primitives")).get_mut(primitive))
        {
            object.clone_from(&decoded);
        }
        known.insert(data, decoded);
    }
    Ok(())
}

impl Compressed {
    fn of(primitive: &Json) -> Result<Self, String> {
        let source = &primitive["extensions"][DRACO];
        let view = whole(source, "bufferView").ok_or("its Draco compression gives no `bufferView`")?;
        let numbers = source.get("attributes").and_then(Json::as_object);
        let numbers = numbers.ok_or("its Draco compression gives no `attributes`")?;
        let attribute = |(name, number): (&String, &Json)| {
            let number = number.as_u64().and_then(|number| u32::try_from(number).ok());
            Some((name.clone(), whole(&primitive["attributes"], name)?, number?))
        };
        // An attribute without an accessor is not used.
        let attributes = numbers.iter().filter_map(attribute).collect();
        Ok(Self { view, attributes, indices: whole(primitive, "indices") })
    }

    /// Whether the file has the same data without compression.
    fn has_plain_data(&self, root: &mut Map<String, Json>) -> bool {
        let accessors =
            self.attributes.iter().map(|(_, accessor, _)| *accessor).chain(self.indices).collect::<Vec<_>>();
        accessors
            .into_iter()
            .all(|at| entry(root, "accessors", at).is_some_and(|accessor| accessor.get("bufferView").is_some()))
    }

    /// Decodes the data. Returns the primitive with accessors of what was decoded.
    fn decode(
        &self,
        root: &mut Map<String, Json>,
        made: &mut Made,
        filled: &mut HashSet<usize>,
        primitive: &Json,
    ) -> Result<Json, String> {
        let mesh = self.mesh(root, made)?;
        let mut primitive = primitive.clone();
        let points = mesh.num_points();
        for (name, accessor, number) in &self.attributes {
            let attribute = mesh.attribute_by_unique_id(*number);
            let attribute = attribute.ok_or_else(|| format!("its Draco data have no attribute {number} for {name}"))?;
            let components = attribute.num_components();
            let kind = match components {
                1 => "SCALAR",
                2 => "VEC2",
                3 => "VEC3",
                4 => "VEC4",
                _ => return Err(format!("its Draco data have {components} numbers in an element of {name}")),
            };
            let described = entry(root, "accessors", *accessor).and_then(|accessor| whole(accessor, "componentType"));
            let component = described
                .and_then(Component::of)
                .ok_or_else(|| format!("{name} has no accessor with a known `componentType`"))?;
            made.take(points.saturating_mul(usize::from(components)).saturating_mul(component.size()))?;
            let bytes = component.bytes(attribute, points);
            let bytes = bytes.ok_or_else(|| format!("its Draco data have elements of {name} without a value"))?;
            let index = fill(root, made, filled, Some(*accessor), bytes, &json!({"count": points, "type": kind}))?;
            primitive["attributes"][name] = json!(index);
        }
        let faces = mesh.num_faces();
        made.take(faces.saturating_mul(12))?;
        let corners = (0..faces).flat_map(|face| mesh.face(FaceIndex(face as u32)));
        let bytes = corners.flat_map(|PointIndex(point)| point.to_le_bytes()).collect();
        let described = json!({"count": 3 * faces, "type": "SCALAR", "componentType": 5125});
        primitive["indices"] = json!(fill(root, made, filled, self.indices, bytes, &described)?);
        // Strips become triangles, too.
        primitive["mode"] = json!(4);
        Ok(primitive)
    }

    /// Decoded mesh.
    fn mesh(&self, root: &mut Map<String, Json>, made: &Made) -> Result<Mesh, String> {
        let view = entry(root, "bufferViews", self.view);
        let view = view.ok_or_else(|| format!("it is no glTF 2.0 file: there is no buffer view {}", self.view))?;
        let bytes = || {
            let (buffer, length) = (whole(view, "buffer")?, whole(view, "byteLength")?);
            made.part(buffer, whole(view, "byteOffset").unwrap_or(0), length)
        };
        let bytes = bytes().ok_or_else(|| {
            format!("the buffer view {} of its Draco data reaches beyond its buffer: is the file cut short?", self.view)
        })?;
        let limits = DecodeLimits::default()
            .with_max_decoded_bytes(made.left as u64)
            .with_max_points(made.left as u64)
            .with_max_faces((made.left / BYTES_PER_TRIANGLE) as u64);
        let mut mesh = Mesh::new();
        match MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh) {
            Ok(()) => Ok(mesh),
            Err(error) if error.kind() == ErrorKind::LimitExceeded => Err(made.too_much()),
            Err(error) => {
                Err(format!("its Draco data are damaged ({}); write the file again", quoted::message(&error)))
            }
        }
    }
}

/// Gives an accessor the bytes and what `described` says of them. Where the accessor has data of its own, a copy of it gets them. Returns the
/// accessor's index.
fn fill(
    root: &mut Map<String, Json>,
    made: &mut Made,
    filled: &mut HashSet<usize>,
    accessor: Option<usize>,
    bytes: Vec<u8>,
    described: &Json,
) -> Result<usize, String> {
    let length = bytes.len();
    let buffer = made.add(root, bytes)?;
    let view = push(root, "bufferViews", json!({"buffer": buffer, "byteLength": length}))?;
    let own = accessor.and_then(|at| entry(root, "accessors", at)).and_then(|accessor| accessor.as_object()).cloned();
    let is_empty = own.as_ref().is_some_and(|own| !own.contains_key("bufferView") && !own.contains_key("sparse"));
    let mut object = own.unwrap_or_default();
    object.remove("sparse");
    object.insert("bufferView".to_owned(), json!(view));
    object.insert("byteOffset".to_owned(), json!(0));
    described
        .as_object()
        .into_iter()
        .flatten()
        .for_each(|(name, value)| _ = object.insert(name.clone(), value.clone()));
    match accessor.filter(|at| is_empty && filled.insert(*at)).and_then(|at| Some((at, entry(root, "accessors", at)?)))
    {
        Some((at, place)) => {
            *place = Json::Object(object);
            Ok(at)
        }
        None => push(root, "accessors", Json::Object(object)),
    }
}

/// Type of an accessor's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: usize) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Values of an attribute at all points, in this type. `None` where one is missing.
    fn bytes(self, attribute: &PointAttribute, points: usize) -> Option<Vec<u8>> {
        let kind = attribute.data_type();
        let (size, components) = (kind.byte_length(), usize::from(attribute.num_components()));
        let stride = usize::try_from(attribute.byte_stride()).ok()?.max(size * components);
        let data = attribute.buffer().data();
        let mut bytes = Vec::with_capacity(points.checked_mul(components * self.size())?);
        for point in 0..points {
            let place = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
            let element = data.get(place.checked_mul(stride)?..)?.get(..size * components)?;
            for number in element.chunks_exact(size) {
                self.push(&mut bytes, number_of(kind, number)?);
            }
        }
        Some(bytes)
    }

    fn push(self, bytes: &mut Vec<u8>, number: f64) {
        match self {
            Self::I8 => bytes.extend((number as i8).to_le_bytes()),
            Self::U8 => bytes.push(number as u8),
            Self::I16 => bytes.extend((number as i16).to_le_bytes()),
            Self::U16 => bytes.extend((number as u16).to_le_bytes()),
            Self::U32 => bytes.extend((number as u32).to_le_bytes()),
            Self::F32 => bytes.extend((number as f32).to_le_bytes()),
        }
    }
}

/// Number of a type of Draco, whose decoder writes the lowest byte first.
fn number_of(kind: DataType, bytes: &[u8]) -> Option<f64> {
    Some(match (kind, bytes) {
        (DataType::Int8, &[a]) => f64::from(a as i8),
        (DataType::Uint8 | DataType::Bool, &[a]) => f64::from(a),
        (DataType::Int16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::Uint16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (DataType::Int32, &[a, b, c, d]) => f64::from(i32::from_le_bytes([a, b, c, d])),
        (DataType::Uint32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (DataType::Float32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (DataType::Float64, bytes) => f64::from_le_bytes(bytes.try_into().ok()?),
        _ => return None,
    })
}
