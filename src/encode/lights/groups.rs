//! Groups of lights among which the cells of a guide learn to choose (`glsl/include/light/light_selection.glsl`).

use super::alias_table::alias_table;
use super::candidate::Candidate;
use crate::generated::constants;
use crate::generated::layout::{LightGroupRecord, LightRecord};

/// Groups of a tree of one node, and of a tree of two levels.
pub(super) const ONE_NODE: usize = 16;
const TWO_LEVELS: usize = 256;

/// Number of groups for so many lights: 0 where there is nothing to choose, or where a record cannot hold a light's index.
pub(super) fn group_count(light_count: usize) -> usize {
    match light_count {
        0 | 1 => 0,
        2..=ONE_NODE => ONE_NODE,
        count if count <= constants::LIGHT_INDEX_MASK as usize => TWO_LEVELS,
        _ => 0,
    }
}

/// Records of lights and of `group_count` groups. Each of the last `patch_count` lights has a group of its own. The others share
/// the rest: consecutive lights are near each other, and make groups of about equal power and number.
pub(super) fn grouped(
    candidates: &[Candidate],
    patch_count: usize,
    group_count: usize,
) -> (Vec<LightRecord>, Vec<LightGroupRecord>) {
    let total = candidates.iter().map(|candidate| candidate.power).sum::<f64>().max(f64::MIN_POSITIVE);
    let near = candidates.len() - patch_count;
    let powers: Vec<f64> = candidates[..near].iter().map(|candidate| candidate.power / total).collect();
    let sizes = sizes(&powers, group_count - patch_count).into_iter().chain(std::iter::repeat_n(1, patch_count));
    let (mut lights, mut groups) = (Vec::with_capacity(candidates.len()), Vec::with_capacity(group_count));
    for size in sizes {
        let first = lights.len();
        let members = &candidates[first..first + size];
        let powers: Vec<f64> = members.iter().map(|member| member.power).collect();
        let group = (groups.len() as u32) << constants::LIGHT_GROUP_SHIFT;
        lights.extend(members.iter().zip(alias_table(&powers)).map(|(member, entry)| LightRecord {
            threshold: entry.threshold,
            group_and_alias: group | (first as u32 + entry.alias),
            kind_and_index: member.kind_and_index(),
            probability: entry.probability,
        }));
        let power = (powers.iter().sum::<f64>() / total) as f32;
        groups.push(LightGroupRecord { first: first as u32, count: size as u32, power, unused: 0 });
    }
    groups.resize(group_count, bytemuck::Zeroable::zeroed());
    (lights, groups)
}

/// Sizes of at most `most` groups of consecutive lights, none of them empty. Power and number count alike.
fn sizes(powers: &[f64], most: usize) -> Vec<usize> {
    if powers.len() <= most {
        return vec![1; powers.len()];
    }
    let total = powers.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let (mut sizes, mut weight) = (vec![0], 0.0);
    for power in powers {
        let has_left = sizes.len() < most && weight * most as f64 >= sizes.len() as f64;
        if has_left {
            sizes.push(0);
        }
        *sizes.last_mut().expect("a group") += 1;
        weight += 0.5 * (power / total + 1.0 / powers.len() as f64);
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates(powers: impl IntoIterator<Item = f64>) -> Vec<Candidate> {
        let candidate = |(index, power)| Candidate { kind: constants::LIGHT_AREA, index, power };
        (0..).zip(powers).map(candidate).collect()
    }

    fn check(candidates: &[Candidate], patch_count: usize) -> Vec<LightGroupRecord> {
        let count = group_count(candidates.len());
        let (lights, groups) = grouped(candidates, patch_count, count);
        assert_eq!((lights.len(), groups.len()), (candidates.len(), count));
        let total: f64 = candidates.iter().map(|candidate| candidate.power).sum();
        let mut next = 0;
        for (number, group) in (0..).zip(groups.iter().filter(|group| group.count > 0)) {
            assert_eq!(group.first, next);
            next += group.count;
            let members = group.first as usize..next as usize;
            let power: f64 = candidates[members.clone()].iter().map(|candidate| candidate.power).sum();
            assert!((f64::from(group.power) - power / total).abs() < 1.0e-6);
            for member in members.clone() {
                let light = lights[member];
                let expected = if power > 0.0 { candidates[member].power / power } else { 0.0 };
                assert!((f64::from(light.probability) - expected).abs() < 1.0e-6, "light {member}");
                assert_eq!(light.group_and_alias >> constants::LIGHT_GROUP_SHIFT, number);
                assert!(members.contains(&((light.group_and_alias & constants::LIGHT_INDEX_MASK) as usize)));
            }
        }
        assert_eq!(next as usize, candidates.len());
        groups
    }

    #[test]
    fn few_lights_have_a_group_each() {
        let groups = check(&candidates([3.0, 0.0, 1.0]), 0);
        assert_eq!(groups.iter().map(|group| group.count).collect::<Vec<_>>()[..4], [1, 1, 1, 0]);
        check(&candidates((0..16).map(f64::from)), 0);
        check(&candidates((0..64).map(f64::from)), 64);
        check(&candidates([0.0; 5]).into_iter().chain(candidates([1.0])).collect::<Vec<_>>(), 1);
    }

    #[test]
    fn many_lights_make_groups_of_like_power_and_number() {
        for patch_count in [0, 64] {
            let many = candidates((0..10_000).map(|i| f64::from(i % 7)));
            let groups = check(&many, patch_count);
            let most = groups.iter().map(|group| group.count).max();
            assert!(most <= Some(60), "{most:?}");
        }
        // One light has nearly all power, so it has a group with few others.
        let bright = candidates((0..10_000).map(|i| if i == 5000 { 1.0e9 } else { 1.0 }));
        let groups = check(&bright, 0);
        let with_it = groups.iter().find(|group| (group.first..group.first + group.count).contains(&5000));
        assert!(with_it.is_some_and(|group| group.count < 100), "{with_it:?}");
    }

    #[test]
    fn lights_that_records_cannot_count_are_not_grouped() {
        assert_eq!([0, 1, 2, 16, 17, (1 << 24) - 1, 1 << 24].map(group_count), [0, 0, 16, 16, 256, 256, 0]);
    }
}
