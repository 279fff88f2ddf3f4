//! Grids for tests, and files of them.

/// Bytes of a `.vol` file over the unit cube, with one or three numbers for each voxel.
pub fn file(size: [usize; 3], values: &[f32]) -> Vec<u8> {
    let channels = values.len() / size.iter().product::<usize>();
    let mut bytes = b"VOL\x03".to_vec();
    for word in [1, size[0], size[1], size[2], channels] {
        bytes.extend((word as u32).to_le_bytes());
    }
    let corners = [0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0];
    bytes.extend(corners.iter().chain(values).flat_map(|number| number.to_le_bytes()));
    bytes
}

/// A puff of smoke: lumps, thin places and holes, with values in [0, 1]. Each of the `channels` differs.
pub fn smoke(size: [usize; 3], channels: usize) -> Vec<f32> {
    let mut values = Vec::with_capacity(size.iter().product::<usize>() * channels);
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let at = [x, y, z].map(|i| i as f64);
                let p = [0, 1, 2].map(|axis| (at[axis] + 0.5) / size[axis] as f64 - 0.5);
                let radius = (p[0] * p[0] + 1.4 * p[1] * p[1] + p[2] * p[2]).sqrt();
                for channel in 0..channels {
                    let c = channel as f64;
                    let lump =
                        ((9.0 + c) * p[0] + 2.0 * c).sin() * ((8.0 - c) * p[1] + 0.5).cos() * (7.0 * p[2] + c).sin();
                    values.push(((1.3 - 2.4 * radius) * (0.6 + 0.7 * lump)).clamp(0.0, 1.0) as f32);
                }
            }
        }
    }
    values
}
