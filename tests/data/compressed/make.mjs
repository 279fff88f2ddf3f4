// Writes the models of this folder: one grid, compressed in each way that glTF knows.
//
//   npm install meshoptimizer@1.3.0 draco3dgltf@1.5.7 && node make.mjs
//
// The grid has 20 x 20 vertices at (i % 20, floor(i / 20), (7 i % 5) / 4), the normals (0, 0, 1), and the texture coordinates
// (x / 20, y / 20).
import draco from 'draco3dgltf';
import { writeFileSync } from 'fs';
import { MeshoptEncoder as meshopt } from 'meshoptimizer';

const SIDE = 20, COUNT = SIDE * SIDE;
const grid = (row) => new Float32Array(Array.from({ length: COUNT }, (_, i) => row(i % SIDE, Math.floor(i / SIDE), i)).flat());
const positions = grid((x, y, i) => [x, y, (7 * i % 5) / 4]);
const normals = grid(() => [0, 0, 1]);
const uvs = grid((x, y) => [x / SIDE, y / SIDE]);
const indices = new Uint32Array(Array.from({ length: (SIDE - 1) ** 2 }, (_, i) => {
  const a = i % (SIDE - 1) + SIDE * Math.floor(i / (SIDE - 1));
  return [a, a + 1, a + SIDE + 1, a, a + SIDE + 1, a + SIDE];
}).flat());
const bytesOf = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);

function model(name, extension, accessors, views, buffers, draco) {
  const primitive = { attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: 0, ...draco };
  const file = {
    asset: { version: '2.0' }, extensionsUsed: [extension, 'KHR_mesh_quantization'], extensionsRequired: [extension, 'KHR_mesh_quantization'],
    scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], materials: [{}], meshes: [{ primitives: [primitive] }],
    accessors, bufferViews: views, buffers,
  };
  writeFileSync(`${name}.gltf`, JSON.stringify(file) + '\n');
}
const bounds = { min: [0, 0, 0], max: [SIDE - 1, SIDE - 1, 1] };
const uri = (bytes) => 'data:application/octet-stream;base64,' + Buffer.from(bytes).toString('base64');

await meshopt.ready;
// Version 0 is what EXT_meshopt_compression has, and version 1 adds modes of bits and of channels.
for (const [version, extension] of [[0, 'EXT_meshopt_compression'], [1, 'KHR_meshopt_compression']]) {
  const vertices = (bytes, stride) => meshopt.encodeVertexBufferLevel(bytes, COUNT, stride, 2 + version, version);
  const four = grid(() => [0, 0, 1, 0]);
  const parts = [
    // Positions are exact in version 0, and have 15 bits in version 1.
    version ? [vertices(meshopt.encodeFilterExp(positions, COUNT, 12, 15), 12), 12, COUNT, 'ATTRIBUTES', 'EXPONENTIAL']
      : [vertices(bytesOf(positions), 12), 12, COUNT, 'ATTRIBUTES'],
    [vertices(meshopt.encodeFilterOct(four, COUNT, 4, 8), 4), 4, COUNT, 'ATTRIBUTES', 'OCTAHEDRAL'],
    [vertices(bytesOf(uvs), 8), 8, COUNT, 'ATTRIBUTES'],
    version ? [meshopt.encodeIndexSequence(bytesOf(indices), indices.length, 4), 4, indices.length, 'INDICES']
      : [meshopt.encodeIndexBuffer(bytesOf(indices), indices.length, 4), 4, indices.length, 'TRIANGLES'],
  ];
  let offset = 0, decoded = 0;
  const views = parts.map(([bytes, stride, count, mode, filter]) => {
    const source = { buffer: 0, byteOffset: offset, byteLength: bytes.length, byteStride: stride, count, mode, filter };
    const view = { buffer: 1, byteOffset: decoded, byteLength: stride * count, extensions: { [extension]: source } };
    if (mode === 'ATTRIBUTES') view.byteStride = stride;
    offset += bytes.length;
    decoded += stride * count;
    return view;
  });
  const buffer = Buffer.concat(parts.map(([bytes]) => bytes));
  model(`meshopt-${version}`, extension, [
    { bufferView: 0, componentType: 5126, count: COUNT, type: 'VEC3', ...bounds },
    { bufferView: 1, componentType: 5120, normalized: true, count: COUNT, type: 'VEC3' },
    { bufferView: 2, componentType: 5126, count: COUNT, type: 'VEC2' },
    { bufferView: 3, componentType: 5125, count: indices.length, type: 'SCALAR' },
  ], views, [{ byteLength: buffer.length, uri: uri(buffer) }, { byteLength: decoded, extensions: { [extension]: { fallback: true } } }]);
}

const encoders = await draco.createEncoderModule();
for (const [name, method, speed] of [['sequential', 0, 10], ['edgebreaker', 1, 5], ['edgebreaker-valence', 1, 0]]) {
  const encoder = new encoders.Encoder(), builder = new encoders.MeshBuilder(), mesh = new encoders.Mesh();
  builder.AddFacesToMesh(mesh, indices.length / 3, indices);
  const numbers = [[encoders.POSITION, 3, positions], [encoders.NORMAL, 3, normals], [encoders.TEX_COORD, 2, uvs]]
    .map(([kind, size, values]) => builder.AddFloatAttributeToMesh(mesh, kind, COUNT, size, values));
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetAttributeQuantization(encoders.POSITION, 14);
  encoder.SetAttributeQuantization(encoders.NORMAL, 8);
  encoder.SetAttributeQuantization(encoders.TEX_COORD, 12);
  const out = new encoders.DracoInt8Array();
  const bytes = Uint8Array.from({ length: encoder.EncodeMeshToDracoBuffer(mesh, out) }, (_, i) => out.GetValue(i));
  const source = { bufferView: 0, attributes: { POSITION: numbers[0], NORMAL: numbers[1], TEXCOORD_0: numbers[2] } };
  model(`draco-${name}`, 'KHR_draco_mesh_compression', [
    { componentType: 5126, count: COUNT, type: 'VEC3', ...bounds },
    { componentType: 5126, count: COUNT, type: 'VEC3' },
    { componentType: 5126, count: COUNT, type: 'VEC2' },
    { componentType: 5125, count: indices.length, type: 'SCALAR' },
  ], [{ buffer: 0, byteLength: bytes.length }], [{ byteLength: bytes.length, uri: uri(bytes) }],
  { extensions: { KHR_draco_mesh_compression: source } });
}
