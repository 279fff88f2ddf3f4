//! Ranks of a render: the processes that a launcher such as mpirun has started together.

use std::sync::Arc;

use lodestar::Result;
use lodestar::fleet::exchange::Exchange;

/// Variables in which launchers give the number of processes: Open MPI's mpirun, MPICH's, and Slurm's srun.
const LAUNCHERS: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"];

/// Number of processes that a launcher has started together with this one.
fn launched() -> Option<usize> {
    let number = |name| std::env::var(name).ok()?.parse().ok();
    LAUNCHERS.into_iter().find_map(number).filter(|&number| number > 1)
}

/// Whether a launcher has started several processes.
pub fn are_several() -> bool {
    launched().is_some()
}

/// The exchange with the other ranks, where a launcher has started several processes.
#[cfg(feature = "mpi")]
pub fn exchange() -> Result<Option<Arc<dyn Exchange>>> {
    use lodestar::{Error, fleet::mpi::Mpi};

    let Some(launched) = launched() else { return Ok(None) };
    let exchange = Mpi::start()?;
    if exchange.ranks() == 1 {
        return Err(Error::Render(format!(
            "{launched} processes were started together, but MPI does not connect them; start them with mpirun, or with \
             `srun --mpi=pmix`"
        )));
    }
    Ok(Some(Arc::new(exchange)))
}

/// No exchange: this build has no MPI. A user who has started several processes is warned.
#[cfg(not(feature = "mpi"))]
pub fn exchange() -> Result<Option<Arc<dyn Exchange>>> {
    if let Some(launched) = launched() {
        super::print::report(
            "warning",
            &format!(
                "{launched} processes were started together, but each renders on its own; build Lodestar with `--features mpi` to \
                 have them render one picture"
            ),
        );
    }
    Ok(None)
}
