//! The `foveasim` command: exit 0 done, 1 a check did not hold, 2 bad input.

fn main() -> std::process::ExitCode {
    foveasim::cli::main()
}
