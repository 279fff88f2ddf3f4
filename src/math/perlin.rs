//! Gradient noise (Perlin 2002), as pbrt has it.

use glam::DVec3;

/// Ken Perlin's permutation of 2002.
pub const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240,
    21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88,
    237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83,
    111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216,
    80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186,
    3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17,
    182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129,
    22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238,
    210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184,
    84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195,
    78, 66, 215, 61, 156, 180,
];

/// Noise at a point (Perlin 2002).
pub fn noise(p: DVec3) -> f64 {
    let cell = p.floor();
    let within = p - cell;
    let lattice = cell.to_array().map(|coordinate| coordinate.rem_euclid(256.0) as usize);
    let fades = within.to_array().map(|t| t * t * t * (t * (6.0 * t - 15.0) + 10.0));
    let mut sum = 0.0;
    for corner in 0..8 {
        let offset = [0, 1, 2].map(|axis| corner >> axis & 1);
        let hash = |hash: usize, axis: usize| usize::from(PERMUTATION[(hash + lattice[axis] + offset[axis]) % 256]);
        let d = within - DVec3::from_array(offset.map(|one| one as f64));
        // The twelve edges of a cube, four of them twice.
        let gradient = match (0..3).fold(0, hash) & 15 {
            0 | 12 => DVec3::new(1.0, 1.0, 0.0),
            1 | 13 => DVec3::new(-1.0, 1.0, 0.0),
            2 => DVec3::new(1.0, -1.0, 0.0),
            3 => DVec3::new(-1.0, -1.0, 0.0),
            4 => DVec3::new(1.0, 0.0, 1.0),
            5 => DVec3::new(-1.0, 0.0, 1.0),
            6 => DVec3::new(1.0, 0.0, -1.0),
            7 => DVec3::new(-1.0, 0.0, -1.0),
            8 => DVec3::new(0.0, 1.0, 1.0),
            9 => DVec3::new(0.0, -1.0, 1.0),
            10 | 14 => DVec3::new(0.0, 1.0, -1.0),
            _ => DVec3::new(0.0, -1.0, -1.0),
        };
        let share = |axis: usize| if offset[axis] == 1 { fades[axis] } else { 1.0 - fades[axis] };
        sum += share(0) * share(1) * share(2) * gradient.dot(d);
    }
    sum
}
