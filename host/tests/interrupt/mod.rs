//! A command that somebody ends with Ctrl-C.

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest that the sign and the end are waited for, each.
const PATIENCE: Duration = Duration::from_secs(120);

/// Runs `host ARGS` until `sign` is there, then ends it; what it said. It must exit with 130.
#[track_caller]
pub fn interrupted_once(sign: &Path, folder: &Path, args: &[&str]) -> String {
    let mut host = Command::new(env!("CARGO_BIN_EXE_host"))
        .current_dir(folder)
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait(&mut host, "nothing to interrupt within two minutes", |_| sign.exists());
    kill(Pid::from_raw(host.id() as i32), Signal::SIGINT).unwrap();
    wait(&mut host, "still running after Ctrl-C", |host| host.try_wait().unwrap().is_some());
    let output = host.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn wait(host: &mut Child, otherwise: &str, is_over: impl Fn(&mut Child) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_over(host) {
        if Instant::now() > deadline {
            host.kill().unwrap();
            panic!("{otherwise}");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
