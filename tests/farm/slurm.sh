#!/usr/bin/env bash
# Runs a command beside a real Slurm of one node, this machine, which lives only as long as the command.
#
#   tests/farm/slurm.sh COMMAND ARGUMENT...
#
# Slurm's daemons run as plain processes of the user, with their files in a temporary folder. The command finds them by SLURM_CONF.
# It needs slurmctld, slurmd, srun and munged: `./setup.sh --slurm`. Where one is absent, the exit status is 77.
set -euo pipefail
export LC_ALL=C PATH=$PATH:/usr/sbin

for program in slurmctld slurmd srun munged; do
  command -v "$program" >/dev/null || { echo "there is no program $program" >&2; exit 77; }
done
cluster=$(mktemp -d)
daemons=()
finish() {
  # The last daemon is the first to end: slurmd says good-bye to slurmctld, which needs munged.
  for ((index = ${#daemons[@]} - 1; index >= 0; index--)); do
    kill "${daemons[$index]}" 2>/dev/null || true
    wait "${daemons[$index]}" 2>/dev/null || true
  done
  rm -rf "$cluster"
}
trap finish EXIT

slurm_user=$(id -un) slurm_node=$(hostname -s) slurm_port=$((20000 + $$ % 20000))
mkdir "$cluster/state" "$cluster/spool" "$cluster/munge"
head -c 1024 /dev/urandom >"$cluster/munge/key"
chmod 400 "$cluster/munge/key"
munged --foreground --force --key-file="$cluster/munge/key" --socket="$cluster/munge/socket" --pid-file="$cluster/munge/pid" \
  --log-file="$cluster/munge/log" --seed-file="$cluster/munge/seed" >"$cluster/munged.log" 2>&1 &
daemons+=($!)

# The node has as many processors as there are tasks at once, whatever the machine has.
cat >"$cluster/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$slurm_node(127.0.0.1)
SlurmctldPort=$slurm_port
SlurmdPort=$((slurm_port + 1))
SlurmUser=$slurm_user
SlurmdUser=$slurm_user
AuthType=auth/munge
AuthInfo=socket=$cluster/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=1
MinJobAge=60
ReturnToService=2
SlurmdParameters=config_overrides
StateSaveLocation=$cluster/state
SlurmdSpoolDir=$cluster/spool
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmdPidFile=$cluster/slurmd.pid
SlurmctldLogFile=$cluster/slurmctld.log
SlurmdLogFile=$cluster/slurmd.log
NodeName=$slurm_node NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
END
export SLURM_CONF=$cluster/slurm.conf
slurmctld -D -i >"$cluster/slurmctld.out" 2>&1 &
daemons+=($!)
slurmd -D -N "$slurm_node" >"$cluster/slurmd.out" 2>&1 &
daemons+=($!)

for ((tries = 0; tries < 150; tries++)); do
  if sinfo --noheader --format=%T 2>/dev/null | grep -q idle; then break; fi
  sleep 0.2
done
sinfo --noheader --format=%T 2>/dev/null | grep -q idle || {
  echo "Slurm does not start:" >&2
  tail -n 20 "$cluster"/*.log "$cluster"/*.out "$cluster/munge/log" >&2
  exit 1
}
"$@"
