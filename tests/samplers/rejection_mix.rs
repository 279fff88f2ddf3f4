//! `sample_rejection_mix` against `pdf_rejection_mix`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use lodestar::kernels::{Variant, test};
use lodestar::reference::equal_area::{bin_center, bin_point, sphere_to_square, square_bin};

use crate::device::{Cell, DIRECTIONS, Device, NORMALS};

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Drawn {
    wi: [f32; 3],
    pdf: f32,
    pdf_of_wi: f32,
    tries: u32,
    bin: u32,
    overrun: u32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct TestPush {
    normal: [f32; 3],
    seed: u32,
}

#[test]
fn scratch() {
    let device = Device::new();
    let table: Vec<f32> =
        (0..256).map(|i| if i == 37 || i == 120 { 50.0 } else { 0.1 + 0.01 * (i % 7) as f32 }).collect();
    for k in [1, 2, 8, 32] {
        let variant = Variant { max_tries: k, ..Variant::default() };
        let cell = Cell::new(&device, &variant, &table);
        let n = 1 << 18;
        let out = device.storage("out", n * size_of::<Drawn>());
        let normal = Vec3::new(0.3, 0.5, 0.8).normalize();
        let push = TestPush { normal: normal.into(), seed: 7 };
        device.run(
            &test::REJECTION_MIX,
            &variant,
            &[&out, &cell.radiance, &cell.entries],
            bytemuck::bytes_of(&push),
            (n / 64) as u32,
        );
        let drawn: Vec<Drawn> = out.read(0, n).unwrap();
        // estimate of the hemisphere's solid angle, and of the integral of cos
        let mut hist = vec![0u32; 256];
        let (mut a, mut b, mut mism, mut tries) = (0.0f64, 0.0f64, 0, 0u64);
        for d in &drawn {
            let w = Vec3::from(d.wi);
            if w.dot(normal) > 0.0 {
                a += 1.0 / f64::from(d.pdf);
                b += f64::from(w.dot(normal)) / f64::from(d.pdf);
            }
            let bin = square_bin(sphere_to_square(w.as_dvec3()), 16);
            hist[bin as usize] += 1;
            if bin != d.bin {
                mism += 1;
            }
            tries += u64::from(d.tries);
            if (d.pdf / d.pdf_of_wi - 1.0).abs() > 1e-4 {
                mism += 1000;
            }
        }
        for d in drawn.iter().take(if k == 2 { 12 } else { 0 }) {
            let bin = square_bin(sphere_to_square(Vec3::from(d.wi).as_dvec3()), 16);
            println!("{bin} {d:?}");
        }
        println!(
            "K {k}: solid angle/2pi {} cos/pi {} mism {mism} tries {} {:?}",
            a / n as f64 / std::f64::consts::TAU,
            b / n as f64 / std::f64::consts::PI,
            tries as f64 / n as f64,
            cell.entry(0)
        );
    }
}
