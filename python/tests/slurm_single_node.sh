#!/bin/bash
# A Slurm cluster of one node in a folder, for tests: no systemd, no database, started by any user.
#   slurm_single_node.sh up DIR      bring it up; then: . DIR/env   (sets SLURM_CONF)
#   slurm_single_node.sh down DIR    stop it; DIR stays, with its logs
# Exit code 77: programs are missing; a test skips then. Debian has them in slurmctld slurmd munge slurm-client.
set -u
skip() { echo "slurm_single_node: skip: $*" >&2; exit 77; }
die() { echo "slurm_single_node: $*" >&2; exit 1; }
[ $# -eq 2 ] || die "usage: $0 up|down DIR"
verb=$1
export PATH=$PATH:/usr/sbin:/sbin

mine() { # mine NAME: prints the id in NAME's pid file, if that process still is NAME
  local pid
  pid=$(cat "$dir/run/$1.pid" 2>/dev/null) || return 1
  case $(cat "/proc/$pid/comm" 2>/dev/null) in "$1"*) echo "$pid";; *) return 1;; esac
}

down() {
  local pid p i
  if [ -s "$dir/env" ] && mine slurmctld >/dev/null; then # end the jobs first: their steps outlive slurmd
    (. "$dir/env"; timeout 10 scancel --quiet --user="$(id -un)" 2>/dev/null
      for ((i = 0; i < 100; i++)); do [ -z "$(timeout 5 squeue -h 2>/dev/null)" ] && break; sleep 0.1; done)
  fi
  for p in slurmd slurmctld munged; do pid=$(mine $p) && kill "$pid"; done
  for p in slurmd slurmctld munged; do
    for ((i = 0; i < 100; i++)); do mine $p >/dev/null || break; sleep 0.1; done
    pid=$(mine $p) && kill -9 "$pid"
  done
}

case $verb in
up)
  for p in munged slurmctld slurmd sbatch squeue scontrol sinfo; do
    command -v "$p" >/dev/null || skip "no $p"
  done
  mkdir -p "$2" && dir=$(cd "$2" && pwd -P) || die "no folder $2"
  case $dir in *[!A-Za-z0-9/._-]*) die "the folder's path must be plain: $dir";; esac
  [ -e "$dir/run/slurmctld.pid" ] && die "$dir is in use; take it down and use a fresh folder"
  chmod 755 "$dir"
  mkdir -p "$dir"/{run,etc,log,state,spool}; chmod 755 "$dir"/{run,etc,log,state,spool}
  [ ${#dir} -le 80 ] || die "the folder's path is too long for a socket: $dir"
  # Two free ports.
  read -r cport dport < <(python3 - <<'PY' 2>/dev/null || echo "$((20000 + RANDOM % 5000)) $((26000 + RANDOM % 5000))"
import socket
s = [socket.socket() for _ in range(2)]
for x in s: x.bind(("127.0.0.1", 0))
print(*[x.getsockname()[1] for x in s])
PY
)
  host=$(hostname -s)
  user=$(id -un)
  # munged: its own key and socket. --force: the folder may be in a folder that others can write to.
  (umask 077; head -c 1024 /dev/urandom > "$dir/etc/munge.key")
  munged --force --key-file="$dir/etc/munge.key" --socket="$dir/run/munge.socket" \
    --pid-file="$dir/run/munged.pid" --log-file="$dir/log/munged.log" --seed-file="$dir/etc/munge.seed" \
    --num-threads=2 > "$dir/log/munged.out" 2>&1 || { cat "$dir/log/munged.out" >&2; die "munged did not start"; }
  cpus=$(nproc)
  mem=$(awk '/^MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)
  cat > "$dir/etc/slurm.conf" <<CONF
ClusterName=adumbratest
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$cport
SlurmdPort=$dport
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$dir/run/munge.socket
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/run/slurmctld.pid
SlurmdPidFile=$dir/run/slurmd.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/slurmd.log
PlugStackConfig=/dev/null
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=10000
ReturnToService=2
SlurmdParameters=config_overrides
MailProg=/bin/true
MinJobAge=300
KillWait=5
JobRequeue=1
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=$mem State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  echo "export SLURM_CONF='$dir/etc/slurm.conf'" > "$dir/env"
  . "$dir/env"
  slurmctld -f "$SLURM_CONF" -c > "$dir/log/slurmctld.out" 2>&1 || { cat "$dir/log/slurmctld.out" >&2; down; die "slurmctld did not start"; }
  slurmd -f "$SLURM_CONF" -N "$host" > "$dir/log/slurmd.out" 2>&1 || { cat "$dir/log/slurmd.out" >&2; down; die "slurmd did not start"; }
  for ((i = 0; i < 150; i++)); do
    s=$(timeout 5 sinfo -h -o %t 2>/dev/null)
    [ "$s" = idle ] && { echo "slurm_single_node: up: . $dir/env"; exit 0; }
    sleep 0.2
  done
  tail -n 5 "$dir"/log/*.log >&2
  down
  die "the node did not become idle (state: ${s:-none})";;
down)
  dir=$(cd "$2" 2>/dev/null && pwd -P) || die "no folder $2"
  down; rm -f "$dir"/run/*;;
*) die "usage: $0 up|down DIR";;
esac
