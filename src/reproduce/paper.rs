//! Numbers that the paper states (Kim and Kim 2021), measured with 40 s per image on an NVIDIA GPU with OptiX.

use crate::settings::Learner;

/// Scene of Table 1, with its errors (mean absolute error of the displayed image) in the order of [`TABLE1_COLUMNS`].
#[derive(Debug, Clone, Copy)]
pub struct PaperScene {
    /// Name of the scene's folder and of its reference.
    pub name: &'static str,
    /// MAE after 40 s.
    pub mae: [f64; 5],
}

/// Columns of Table 1. "Rej+" is `rejection-mix`; "w/o SARSA" learns by `expected-sarsa`.
pub const TABLE1_COLUMNS: [&str; 5] = ["BRDF", "Quadtree", "ours w/o Rej+", "ours w/o SARSA", "ours"];

/// Rows of Table 1.
pub const SCENES: [PaperScene; 12] = [
    scene("bathroom", [0.0374, 0.0358, 0.0554, 0.0387, 0.0366]),
    scene("bathroom2", [0.0345, 0.0339, 0.0338, 0.0344, 0.0288]),
    scene("cornell-box", [0.0114, 0.0062, 0.0093, 0.0098, 0.0072]),
    scene("cornell-box-hard", [0.0216, 0.0134, 0.0182, 0.0181, 0.0134]),
    scene("kitchen", [0.0227, 0.0209, 0.0198, 0.0216, 0.0190]),
    scene("living-room", [0.0092, 0.0087, 0.0180, 0.0130, 0.0116]),
    scene("living-room-2", [0.0190, 0.0181, 0.0197, 0.0189, 0.0169]),
    scene("living-room-3", [0.0558, 0.0611, 0.0767, 0.0622, 0.0511]),
    scene("staircase", [0.0144, 0.0105, 0.0164, 0.0122, 0.0094]),
    scene("staircase2", [0.0146, 0.0101, 0.0178, 0.0107, 0.0092]),
    scene("veach-ajar", [0.0747, 0.0640, 0.2010, 0.0772, 0.0745]),
    scene("veach-ajar-2", [0.1233, 0.1066, 0.1222, 0.1323, 0.1029]),
];

/// Milliseconds per sample, mean over the scenes, in the order of [`TABLE1_COLUMNS`].
pub const TABLE1_MS: [f64; 5] = [10.59, 11.18, 54.73, 34.48, 16.30];
/// Samples per pixel, mean over the scenes, in the order of [`TABLE1_COLUMNS`].
pub const TABLE1_SPP: [f64; 5] = [4005.0, 3774.0, 1302.0, 1239.0, 2523.0];
/// Share of samples below the surface, mean over the scenes, in the order of [`TABLE1_COLUMNS`]. For the last three
/// columns the paper states "~0".
pub const TABLE1_INVALID: [f64; 5] = [0.0, 0.1719, 0.0, 0.0, 0.0];

/// Columns of Table 2.
pub const TABLE2_COLUMNS: [&str; 4] =
    ["sphere, inversion", "hemisphere, inversion", "hemisphere, rejection", "hemisphere, Rej+"];

/// Row of Table 2: means over the scenes, in the order of [`TABLE2_COLUMNS`].
#[derive(Debug, Clone, Copy)]
pub struct PaperLearner {
    /// Learner.
    pub learner: Learner,
    /// Name of the learner in the paper.
    pub name: &'static str,
    /// MAE after 40 s.
    pub mae: [f64; 4],
    /// Milliseconds per sample.
    pub ms: [f64; 4],
}

/// Rows of Table 2.
pub const TABLE2: [PaperLearner; 3] = [
    PaperLearner {
        learner: Learner::ExpectedSarsa,
        name: "expected-SARSA",
        mae: [0.0425, 0.0474, 0.0521, 0.0374],
        ms: [21.62, 45.57, 66.37, 34.48],
    },
    PaperLearner {
        learner: Learner::MonteCarlo,
        name: "Monte Carlo",
        mae: [0.0368, 0.0467, 0.0524, 0.0332],
        ms: [10.94, 26.09, 76.61, 17.67],
    },
    PaperLearner {
        learner: Learner::Sarsa,
        name: "SARSA",
        mae: [0.0340, 0.0434, 0.0507, 0.0317],
        ms: [9.23, 25.37, 54.73, 16.30],
    },
];

/// Bytes per vertex that the paper states for Monte Carlo learning: 12 floats.
pub const PATH_VERTEX_BYTES: u64 = 12 * 4;

const fn scene(name: &'static str, mae: [f64; 5]) -> PaperScene {
    PaperScene { name, mae }
}

/// Index of a column of Table 1.
pub fn table1_column(name: &str) -> Option<usize> {
    TABLE1_COLUMNS.iter().position(|column| *column == name)
}

/// Index of a column of Table 2.
pub fn table2_column(name: &str) -> Option<usize> {
    TABLE2_COLUMNS.iter().position(|column| *column == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the means that the paper prints below its columns.
    #[test]
    fn columns_have_the_means_that_the_paper_prints() {
        for (column, mean) in [0.0366, 0.0324, 0.0507, 0.0374, 0.0317].into_iter().enumerate() {
            let sum: f64 = SCENES.iter().map(|scene| scene.mae[column]).sum();
            assert!((sum / 12.0 - mean).abs() < 6.0e-5, "{}: {}", TABLE1_COLUMNS[column], sum / 12.0);
        }
    }

    #[test]
    fn both_tables_agree_where_they_meet() {
        let [expected, _, sarsa] = TABLE2;
        assert_eq!((expected.mae[3], expected.ms[3]), (0.0374, TABLE1_MS[3]));
        assert_eq!((sarsa.mae[3], sarsa.ms[3]), (0.0317, TABLE1_MS[4]));
        assert_eq!((sarsa.mae[2], sarsa.ms[2]), (0.0507, TABLE1_MS[2]));
    }
}
