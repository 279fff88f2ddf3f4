//! Choice of the device to use.

use std::fmt::Write;

use super::device_info::{DeviceInfo, DeviceKind};
use crate::{Error, Result};

/// Chooses the device with the wanted index or part of a name; without a wish, the best usable one.
pub(super) fn choose<'a>(devices: &'a [DeviceInfo], wanted: Option<&str>) -> Result<&'a DeviceInfo> {
    match wanted {
        Some(wanted) => usable(find(devices, wanted)?),
        None => best(devices),
    }
}

/// One of the usable devices of the best kind, which are taken in turn.
pub(super) fn in_turn(devices: &[DeviceInfo], number: usize) -> Result<&DeviceInfo> {
    let best = best(devices)?;
    let alike = devices.iter().filter(|device| device.refused.is_none() && device.kind == best.kind);
    let alike: Vec<_> = alike.collect();
    Ok(alike[number % alike.len()])
}

fn find<'a>(devices: &'a [DeviceInfo], wanted: &str) -> Result<&'a DeviceInfo> {
    let wanted = wanted.trim();
    if let Some(device) = wanted.parse::<usize>().ok().and_then(|index| devices.get(index)) {
        return Ok(device);
    }
    let lower = wanted.to_lowercase();
    let named = |device: &&DeviceInfo| !lower.is_empty() && device.name.to_lowercase().contains(&lower);
    let matches: Vec<_> = devices.iter().filter(named).collect();
    match matches[..] {
        [device] => Ok(device),
        [] => Err(Error::Device(format!("no Vulkan device is called `{wanted}`; there {}", listing(devices)))),
        _ => {
            Err(Error::Device(format!("more than one Vulkan device is called `{wanted}`; there {}", listing(devices))))
        }
    }
}

fn usable(device: &DeviceInfo) -> Result<&DeviceInfo> {
    match &device.refused {
        None => Ok(device),
        Some(lacks) => {
            Err(Error::Device(format!("the Vulkan device {} ({}) cannot be used: {lacks}", device.index, device.name)))
        }
    }
}

fn best(devices: &[DeviceInfo]) -> Result<&DeviceInfo> {
    let candidates = devices.iter().filter(|device| device.refused.is_none());
    candidates.min_by_key(|device| (rank(device.kind), device.index)).ok_or_else(|| {
        Error::Device(format!("no Vulkan device can be used; there {}; `lodestar devices` says more", listing(devices)))
    })
}

fn rank(kind: DeviceKind) -> u32 {
    match kind {
        DeviceKind::Discrete => 0,
        DeviceKind::Integrated => 1,
        DeviceKind::Virtual => 2,
        DeviceKind::Cpu => 3,
        DeviceKind::Other => 4,
    }
}

fn listing(devices: &[DeviceInfo]) -> String {
    let mut text = String::from(if devices.len() == 1 { "is" } else { "are" });
    for (place, device) in devices.iter().enumerate() {
        let separator = if place == 0 { " " } else { "; " };
        let refusal = device.refused.as_ref().map(|lacks| format!(" (refused: {lacks})")).unwrap_or_default();
        // Writing to a String does not fail.
        let _ = write!(text, "{separator}{}: {}{refusal}", device.index, device.name);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Limits;

    fn device(index: usize, name: &str, kind: DeviceKind, refused: Option<&str>) -> DeviceInfo {
        DeviceInfo {
            index,
            name: name.into(),
            kind,
            api_version: "1.2.0".into(),
            driver_name: String::new(),
            driver_info: String::new(),
            vendor_id: 0,
            device_id: 0,
            driver_version: 0,
            pipeline_cache_uuid: String::new(),
            limits: Limits::default(),
            refused: refused.map(Into::into),
        }
    }

    fn machine() -> [DeviceInfo; 4] {
        [
            device(0, "llvmpipe", DeviceKind::Cpu, None),
            device(1, "Arc Graphics", DeviceKind::Integrated, None),
            device(2, "GeForce 4090", DeviceKind::Discrete, None),
            device(3, "GeForce 3", DeviceKind::Discrete, Some("it lacks Vulkan 1.2")),
        ]
    }

    fn refusal(wanted: Option<&str>, devices: &[DeviceInfo]) -> String {
        choose(devices, wanted).map(|device| device.index).expect_err("a refusal").to_string()
    }

    #[test]
    fn kinds_are_preferred_in_order_and_refused_devices_skipped() {
        let machine = machine();
        for (devices, index) in [(&machine[..], 2), (&machine[..2], 1), (&machine[..1], 0)] {
            assert_eq!(choose(devices, None).expect("a device").index, index);
        }
    }

    #[test]
    fn ranks_take_the_best_devices_in_turn() {
        let mut machine = machine().to_vec();
        machine.push(device(4, "GeForce 4090", DeviceKind::Discrete, None));
        let indices = [0, 1, 2, 3].map(|rank| in_turn(&machine, rank).expect("a device").index);
        assert_eq!(indices, [2, 4, 2, 4]);
        assert!(in_turn(&machine[3..4], 0).is_err());
    }

    #[test]
    fn a_device_is_found_by_index_or_part_of_its_name() {
        let machine = machine();
        for (wanted, index) in [("1", 1), ("LLVM", 0), (" arc ", 1), ("4090", 2)] {
            assert_eq!(choose(&machine, Some(wanted)).expect("a device").index, index);
        }
    }

    #[test]
    fn what_cannot_be_chosen_is_said_in_a_sentence() {
        let machine = machine();
        let all =
            "there are 0: llvmpipe; 1: Arc Graphics; 2: GeForce 4090; 3: GeForce 3 (refused: it lacks Vulkan 1.2)";
        assert_eq!(refusal(Some("voodoo"), &machine), format!("no Vulkan device is called `voodoo`; {all}"));
        assert_eq!(refusal(Some(""), &machine), format!("no Vulkan device is called ``; {all}"));
        assert_eq!(
            refusal(Some("geforce"), &machine),
            format!("more than one Vulkan device is called `geforce`; {all}")
        );
        assert_eq!(refusal(Some("3"), &machine), "the Vulkan device 3 (GeForce 3) cannot be used: it lacks Vulkan 1.2");
        assert_eq!(
            refusal(None, &machine[3..]),
            "no Vulkan device can be used; there is 3: GeForce 3 (refused: it lacks Vulkan 1.2); `lodestar devices` says more"
        );
    }
}
