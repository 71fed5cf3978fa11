//! Resources of the machine, and their use by this process.

use crate::error::{Error, Kind, Result};
use crate::parallel::cores;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Wall-clock and processor time since a start.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    wall: Instant,
    cpu: Duration,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Stopwatch { wall: Instant::now(), cpu: cpu_time() }
    }

    /// Wall-clock time since the start.
    pub fn wall(&self) -> Duration {
        self.wall.elapsed()
    }

    /// Processor time (user and system, all threads) since the start.
    pub fn cpu(&self) -> Duration {
        cpu_time().saturating_sub(self.cpu)
    }
}

/// Processor time of this process: user and system, all threads.
fn cpu_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.try_into().unwrap_or(0), time.tv_nsec.try_into().unwrap_or(0))
}

/// Returns the number of threads to use: `asked`, else the number in a scheduler's environment variables, else the
/// cores available to this process (within affinity and cgroup limits).
///
/// # Errors
/// More than 4096 threads, or 0, were asked for.
pub fn threads(asked: Option<usize>, variable: impl Fn(&str) -> Option<String>) -> Result<usize> {
    const MOST: usize = 4096;
    let scheduled = || {
        let number = |name| variable(name)?.trim().parse::<usize>().ok().filter(|n| (1..=MOST).contains(n));
        ["SLURM_CPUS_PER_TASK", "CUE_THREADS"].into_iter().find_map(number)
    };
    match asked {
        Some(n) if (1..=MOST).contains(&n) => Ok(n),
        Some(n) => Err(Error::usage(format!("--threads {n}: must be from 1 to {MOST}"))),
        None => Ok(scheduled().unwrap_or_else(cores)),
    }
}

/// Peak resident memory of this process, in bytes; `None` where the system does not report it.
pub fn peak_memory() -> Option<u64> {
    kilobytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Resident memory of this process, in bytes; `None` where the system does not report it.
pub fn resident_memory() -> Option<u64> {
    kilobytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Memory limit of `--memory`, in bytes; 0 if none was given.
static BUDGET: AtomicU64 = AtomicU64::new(0);

/// Limits the memory of this process to `bytes` in all.
pub fn limit_memory(bytes: u64) {
    BUDGET.store(bytes, Ordering::Relaxed);
}

/// Returns the memory still available, in bytes: free memory within the limits of the control groups and of
/// [`limit_memory`]. `None` where the system does not report it.
pub fn available_memory() -> Option<u64> {
    let free = kilobytes(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let granted = Some(BUDGET.load(Ordering::Relaxed)).filter(|&bytes| bytes > 0);
    let left = granted.map(|bytes| bytes.saturating_sub(resident_memory().unwrap_or(0)));
    Some([cgroup_room(), left].into_iter().flatten().fold(free, u64::min))
}

/// Rejects a request that exceeds the available memory, before the kernel kills the process. `cure` names a remedy.
///
/// # Errors
/// [`Kind::Memory`] with both figures.
pub fn affordable(what: &str, need: u64, cure: &str) -> Result<()> {
    match available_memory() {
        Some(available) if need > available => {
            let (need, available) = (need as f64 / 1e9, available as f64 / 1e9);
            Err(Error::new(
                Kind::Memory,
                format!("{what} would take {need:.2} GB and {available:.2} GB are available: {cure}"),
            ))
        }
        _ => Ok(()),
    }
}

/// Transparent huge page mode of the system: `always`, `madvise` or `never`; `None` where the system does not report
/// it.
pub fn huge_pages() -> Option<String> {
    let text = std::fs::read_to_string("/sys/kernel/mm/transparent_hugepage/enabled").ok()?;
    Some(text.split_once('[')?.1.split_once(']')?.0.to_owned())
}

/// Remaining memory of the tightest control group (version 2) around this process, if one has a limit.
fn cgroup_room() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = Path::new("/sys/fs/cgroup").join(groups.lines().find_map(|l| l.strip_prefix("0::/"))?);
    let number = |file: PathBuf| std::fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
    let room =
        |group: &Path| Some(number(group.join("memory.max"))?.saturating_sub(number(group.join("memory.current"))?));
    own.ancestors().take_while(|group| group.starts_with("/sys/fs/cgroup")).filter_map(room).min()
}

fn kilobytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// The first processor, as the system describes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Processor {
    /// Its model name.
    pub model: Option<String>,
    /// Its instruction sets, as Linux names them; empty if unknown.
    pub flags: Vec<String>,
}

impl Processor {
    /// Reads the description from the system.
    pub fn detect() -> Self {
        // The first processor's entry is enough, and generating it for hundreds of cores would take milliseconds.
        let mut head = vec![0; 8192];
        let read = std::fs::File::open("/proc/cpuinfo").and_then(|mut file| std::io::Read::read(&mut file, &mut head));
        Self::parse(&String::from_utf8_lossy(&head[..read.unwrap_or(0)]))
    }

    fn parse(text: &str) -> Self {
        let first = text.split("\n\n").next().unwrap_or_default();
        let value = |key: &str| {
            let (_, value) = first.lines().filter_map(|l| l.split_once(':')).find(|(name, _)| name.trim() == key)?;
            Some(value.trim().to_owned())
        };
        let flags = value("flags").map(|f| f.split_whitespace().map(str::to_owned).collect());
        Processor { model: value("model name"), flags: flags.unwrap_or_default() }
    }

    /// Returns the instruction sets that étendue was compiled for and this processor lacks.
    pub fn missing(&self) -> Vec<&'static str> {
        if self.flags.is_empty() {
            return Vec::new();
        }
        let compiled = [
            ("avx2", cfg!(target_feature = "avx2")),
            ("fma", cfg!(target_feature = "fma")),
            ("bmi1", cfg!(target_feature = "bmi1")),
            ("bmi2", cfg!(target_feature = "bmi2")),
        ];
        let lacks = |name: &str| !self.flags.iter().any(|f| f == name);
        compiled.into_iter().filter(|&(name, wanted)| wanted && lacks(name)).map(|(name, _)| name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detect(asked: Option<usize>, variables: &[(&str, &str)]) -> usize {
        let variable = |name: &str| variables.iter().find(|v| v.0 == name).map(|v| v.1.to_owned());
        threads(asked, variable).unwrap()
    }

    #[test]
    fn the_flag_beats_schedulers_and_schedulers_beat_cores() {
        assert_eq!(detect(Some(3), &[("SLURM_CPUS_PER_TASK", "7")]), 3);
        assert_eq!(detect(None, &[("SLURM_CPUS_PER_TASK", "7"), ("CUE_THREADS", "5")]), 7);
        assert_eq!(detect(None, &[("CUE_THREADS", "5")]), 5);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        for nonsense in ["", "0", "many", "-1"] {
            assert_eq!(detect(None, &[("SLURM_CPUS_PER_TASK", nonsense)]), cores, "{nonsense}");
        }
    }

    #[test]
    fn absurd_thread_counts_are_refused() {
        for n in [0, 1_000_000] {
            assert!(threads(Some(n), |_| None).is_err());
        }
    }

    #[test]
    fn processor_model_is_that_of_the_first_entry() {
        let text = "processor\t: 0\nmodel name\t: A Chip\nflags\t\t: fpu avx2 bmi1\n\nprocessor\t: 1\nmodel name\t: B";
        let chip = Processor::parse(text);
        assert_eq!(chip.model.as_deref(), Some("A Chip"));
        if cfg!(target_feature = "avx2") {
            assert_eq!(chip.missing(), ["fma", "bmi2"]);
        }
        assert!(Processor::parse("").missing().is_empty());
    }

    #[test]
    fn a_busy_thread_uses_processor_time() {
        let watch = Stopwatch::start();
        let end = Instant::now() + Duration::from_millis(30);
        while Instant::now() < end {
            std::hint::spin_loop();
        }
        assert!(watch.wall() >= Duration::from_millis(30));
        assert!(watch.cpu() > Duration::ZERO);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn system_memory_figures_are_available() {
        assert!(peak_memory().unwrap() > 1 << 20);
        assert!(available_memory().is_some());
    }
}
