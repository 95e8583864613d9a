//! CPU seconds: what a measurement counts, so that other programs on the machine take nothing away.

/// CPU seconds that all threads of this process have used so far (POSIX `CLOCK_PROCESS_CPUTIME_ID`).
#[cfg(unix)]
pub fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Where the system has no such clock: seconds of the wall since the first call.
#[cfg(not(unix))]
pub fn cpu_seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}

/// The processor's name if the system tells it, else its architecture.
pub fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    line.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sleep costs no CPU time, work does.
    #[test]
    #[cfg(unix)]
    fn work_counts() {
        let start = cpu_seconds();
        let wall = std::time::Instant::now();
        let mut x = 1u64;
        while cpu_seconds() - start < 0.02 {
            x = std::hint::black_box(x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
            assert!(wall.elapsed().as_secs() < 60, "{x}: the clock stands still");
        }
        assert!(!processor().is_empty());
    }
}
