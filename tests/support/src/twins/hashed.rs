//! Twin of `glsl/include/texture/{hash,lattice_noise,bricks,color_models}.glsl`, in double precision.

use glam::{DVec2, DVec3, DVec4, IVec4};

/// Bob Jenkins's lookup3 of 2006.
pub fn lookup3(words: &[u32]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add((words.len() as u32) << 2).wrapping_add(13);
    let mut state = [start; 3];
    for (part, word) in state.iter_mut().zip(words) {
        *part = part.wrapping_add(*word);
    }
    let [mut a, mut b, mut c] = state;
    if let Some(fourth) = words.get(3) {
        for (first, second, third) in [(4, 6, 8), (16, 19, 4)] {
            a = a.wrapping_sub(c) ^ c.rotate_left(first);
            c = c.wrapping_add(b);
            b = b.wrapping_sub(a) ^ a.rotate_left(second);
            a = a.wrapping_add(c);
            c = c.wrapping_sub(b) ^ b.rotate_left(third);
            b = b.wrapping_add(a);
        }
        a = a.wrapping_add(*fourth);
    }
    for (first, second, third) in [(14, 11, 25), (16, 4, 14)] {
        c = (c ^ b).wrapping_sub(b.rotate_left(first));
        a = (a ^ c).wrapping_sub(c.rotate_left(second));
        b = (b ^ a).wrapping_sub(a.rotate_left(third));
    }
    (c ^ b).wrapping_sub(b.rotate_left(24))
}

pub(super) fn of_floats(values: &[f64]) -> f64 {
    let words: Vec<u32> = values.iter().map(|&value| (value as f32).to_bits()).collect();
    f64::from(lookup3(&words)) / f64::from(u32::MAX)
}

/// White noise of one to four numbers.
pub fn white_noise(v: &[f64]) -> DVec3 {
    let with = |last: f64| of_floats(&[v, &[last]].concat());
    match *v {
        [x, y, z, w] => DVec3::new(of_floats(v), of_floats(&[z, x, w, y]), of_floats(&[w, z, y, x])),
        _ => DVec3::new(of_floats(v), with(1.0), with(2.0)),
    }
}

/// Jarzynski and Olano's generators of 2020 for two to four whole numbers.
pub(super) fn of_cell(dimensions: usize, cell: IVec4) -> DVec4 {
    let mut v = cell.to_array().map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    // The component that grows, and the two whose product it grows by.
    let steps: &[[usize; 3]] = match dimensions {
        2 => &[[0, 1, 4], [1, 0, 4]],
        3 => &[[0, 1, 2], [1, 2, 0], [2, 0, 1]],
        _ => &[[0, 1, 3], [1, 2, 0], [2, 0, 1], [3, 1, 2]],
    };
    for round in 0..2 {
        for &[at, first, second] in steps {
            let factor = v.get(second).copied().unwrap_or(1_664_525);
            v[at] = v[at].wrapping_add(v[first].wrapping_mul(factor));
        }
        if round == 0 {
            v = v.map(|x| x ^ (x >> 16));
        }
    }
    DVec4::from_array(v.map(|x| f64::from(x & i32::MAX) / f64::from(i32::MAX)))
}

/// Noise of Perlin's kind in as many dimensions as the point has.
fn noise(p: &[f64]) -> f64 {
    let count = p.len();
    let p: Vec<f64> = p.iter().map(|x| x % 100_000.0 + if x.abs() >= 1.0e6 { 0.5 } else { 0.0 }).collect();
    let mut sum = 0.0;
    for corner in 0..1usize << count {
        let lattice: Vec<f64> = (0..count).map(|axis| p[axis].floor() + (corner >> axis & 1) as f64).collect();
        let d: Vec<f64> = (0..count).map(|axis| p[axis] - lattice[axis]).collect();
        let weight: f64 = d
            .iter()
            .map(|d| {
                let t = 1.0 - d.abs();
                t * t * t * (10.0 - 15.0 * t + 6.0 * t * t)
            })
            .product();
        let words: Vec<u32> = lattice.iter().map(|&x| x as i64 as u32).collect();
        let hash = lookup3(&words);
        let sign = |bit: u32| if hash >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let gradient = match count {
            1 => sign(3) * f64::from(1 + hash % 8) * d[0],
            2 => {
                let (u, v) = if hash % 8 < 4 { (d[0], d[1]) } else { (d[1], d[0]) };
                sign(0) * u + sign(1) * 2.0 * v
            }
            3 => {
                let h = hash % 16;
                let u = d[usize::from(h >= 8)];
                let v = match h {
                    0..4 => d[1],
                    12 | 14 => d[0],
                    _ => d[2],
                };
                sign(0) * u + sign(1) * v
            }
            _ => {
                let h = hash % 32;
                let (u, v, s) = (d[usize::from(h >= 24)], d[1 + usize::from(h >= 16)], d[2 + usize::from(h >= 8)]);
                sign(0) * u + sign(1) * v + sign(2) * s
            }
        };
        sum += weight * gradient;
    }
    sum * [0.25, 0.6616, 0.9820, 0.8344][count - 1]
}

/// Sum of octaves: detail, roughness, lacunarity, offset and gain.
pub fn fractal(kind: u32, normalized: bool, p: &[f64], [detail, roughness, lacunarity, offset, gain]: [f64; 5]) -> f64 {
    let (detail, roughness) = (detail.clamp(0.0, 15.0), roughness.max(0.0));
    let whole = detail.floor() as i32;
    let rest = detail - detail.floor();
    let octave = |at: i32| noise(&p.iter().map(|x| x * lacunarity.powi(at)).collect::<Vec<_>>());
    let amplitude = |at: i32| roughness.powi(at);
    match kind {
        0 => {
            let sum = |last: i32| (0..=last).map(|at| amplitude(at) * octave(at)).sum::<f64>();
            let total = |last: i32| (0..=last).map(amplitude).sum::<f64>();
            let value = |last: i32| if normalized { 0.5 * sum(last) / total(last) + 0.5 } else { sum(last) };
            if rest == 0.0 { value(whole) } else { value(whole) * (1.0 - rest) + value(whole + 1) * rest }
        }
        1 => {
            let product: f64 = (0..=whole).map(|at| amplitude(at) * octave(at) + 1.0).product();
            product * (rest * amplitude(whole + 1) * octave(whole + 1) + 1.0)
        }
        2 => {
            let (mut value, mut weight) = (0.0, 1.0f64);
            for at in 0..=whole + 1 {
                let share = if at <= whole { 1.0 } else { rest };
                if weight <= 0.001 || share == 0.0 {
                    break;
                }
                weight = weight.min(1.0);
                let signal = (octave(at) + offset) * amplitude(at);
                value += share * weight * signal;
                weight *= gain * signal;
            }
            value
        }
        3 => {
            let ridge = |at: i32| (offset - octave(at).abs()).powi(2);
            let mut signal = ridge(0);
            let mut value = signal;
            for at in 1..=whole {
                signal = ridge(at) * (signal * gain).clamp(0.0, 1.0);
                value += signal * amplitude(at);
            }
            value
        }
        _ => {
            let mut value = offset + octave(0);
            for at in 1..=whole {
                value += (octave(at) + offset) * amplitude(at) * value;
            }
            value + rest * (octave(whole + 1) + offset) * amplitude(whole + 1) * value
        }
    }
}

/// Number of a brick and share of mortar: sizes are mortar, smoothness, bias, width and height.
pub fn bricks(p: DVec2, sizes: [f64; 5], [offset, squash]: [f64; 2], [offset_rows, squash_rows]: [i64; 2]) -> DVec2 {
    let [mortar, smoothness, bias, mut width, height] = sizes;
    let row = (p.y / height).floor() as i64;
    let mut shift = 0.0;
    if offset_rows != 0 && squash_rows != 0 {
        width *= if row % squash_rows == 0 { squash } else { 1.0 };
        shift = if row % offset_rows == 0 { width * offset } else { 0.0 };
    }
    let column = ((p.x + shift) / width).floor() as i64;
    let (x, y) = (p.x + shift - width * column as f64, p.y - height * row as f64);
    let start = ((row << 16) + (column & 0xffff)) as u32;
    let n = start.wrapping_add(1013) & 0x7fff_ffff;
    let n = n ^ (n >> 13);
    let inner = n.wrapping_mul(n).wrapping_mul(60493).wrapping_add(19_990_303);
    let hash = n.wrapping_mul(inner).wrapping_add(1_376_312_589) & 0x7fff_ffff;
    let number = (f64::from(hash) / 2_147_483_648.0 + bias).clamp(0.0, 1.0);
    let inside = x.min(y).min(width - x).min(height - y);
    let share = match inside < mortar {
        false => 0.0,
        true if smoothness == 0.0 => 1.0,
        true => {
            let t = ((1.0 - inside / mortar) / smoothness).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        }
    };
    DVec2::new(number, share)
}

/// Hue in turns, the largest component and the span of a color.
fn hue(color: DVec3) -> (f64, f64, f64) {
    let (most, span) = (color.max_element(), color.max_element() - color.min_element());
    let sixths = match most {
        _ if span == 0.0 => 0.0,
        _ if most == color.x => (color.y - color.z) / span,
        _ if most == color.y => 2.0 + (color.z - color.x) / span,
        _ => 4.0 + (color.x - color.y) / span,
    };
    ((sixths / 6.0).rem_euclid(1.0), most, span)
}

/// Hue, saturation and value.
pub fn hsv(color: DVec3) -> DVec3 {
    let (hue, most, span) = hue(color);
    if most == 0.0 { DVec3::ZERO } else { DVec3::new(hue, span / most, most) }
}

/// Hue, saturation and lightness.
pub fn hsl(color: DVec3) -> DVec3 {
    let (hue, most, span) = hue(color);
    let least = most - span;
    let lightness = (0.5 * (most + least)).min(1.0);
    let saturation = match lightness {
        _ if span == 0.0 => 0.0,
        _ if lightness > 0.5 => span / (2.0 - most - least),
        _ => span / (most + least),
    };
    DVec3::new(hue, saturation, lightness)
}

/// Color of a hue, a saturation and a value.
pub fn from_hsv(v: DVec3) -> DVec3 {
    let sixths = 6.0 * if v.x == 1.0 { 0.0 } else { v.x };
    let f = sixths - sixths.floor();
    let of = |share: f64| v.z * (1.0 - v.y * share);
    let (low, falling, rising) = (of(1.0), of(f), of(1.0 - f));
    if v.y == 0.0 {
        return DVec3::splat(v.z);
    }
    let [r, g, b] = match sixths.floor() as i64 {
        0 => [v.z, rising, low],
        1 => [falling, v.z, low],
        2 => [low, v.z, rising],
        3 => [low, falling, v.z],
        4 => [rising, low, v.z],
        _ => [v.z, low, falling],
    };
    DVec3::new(r, g, b)
}

/// Color of a hue, a saturation and a lightness.
pub fn from_hsl(v: DVec3) -> DVec3 {
    let sixths = 6.0 * v.x;
    let shares = DVec3::new((sixths - 3.0).abs() - 1.0, 2.0 - (sixths - 2.0).abs(), 2.0 - (sixths - 4.0).abs());
    let chroma = (1.0 - (2.0 * v.z - 1.0).abs()) * v.y;
    (shares.clamp(DVec3::ZERO, DVec3::ONE) - 0.5) * chroma + v.z
}

/// One channel of a table.
pub fn table(entries: &[f64], at: f64, steps: bool, extrapolate: bool) -> f64 {
    let last = entries.len() - 1;
    let slope = |from: usize, to: usize| (entries[to] - entries[from]) * last as f64;
    if extrapolate && at < 0.0 {
        return entries[0] + at * slope(0, 1.min(last));
    }
    if extrapolate && at > 1.0 {
        return entries[last] + (at - 1.0) * slope(last.saturating_sub(1), last);
    }
    let place = at.clamp(0.0, 1.0) * last as f64;
    let low = place.floor() as usize;
    let t = if steps { 0.0 } else { place - low as f64 };
    entries[low] + t * (entries[(low + 1).min(last)] - entries[low])
}
