//! The fake robot on a pseudo-terminal, at 60 frames a second, for tests that
//! start the host as a process.

use super::FakeRobot;
use nix::fcntl::OFlag;
use nix::pty::{PtyMaster, grantpt, posix_openpt, ptsname_r, unlockpt};
use std::io::{ErrorKind, Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// No test takes longer; a hung one must not keep the thread.
const LIFETIME: Duration = Duration::from_secs(120);

pub struct Bench {
    /// What `--port` takes.
    pub port: String,
    robot: Arc<Mutex<FakeRobot>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Bench {
    pub fn new(robot: FakeRobot) -> Self {
        // A host that inherited the master would keep the terminal alive after the cable was pulled.
        let flags = OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_NONBLOCK | OFlag::O_CLOEXEC;
        let master = posix_openpt(flags).expect("a pseudo-terminal");
        grantpt(&master).expect("granted");
        unlockpt(&master).expect("unlocked");
        let port = ptsname_r(&master).expect("a name");
        let robot = Arc::new(Mutex::new(robot));
        let stop = Arc::new(AtomicBool::new(false));
        let thread = {
            let (robot, stop) = (Arc::clone(&robot), Arc::clone(&stop));
            std::thread::spawn(move || pump(master, &robot, &stop))
        };
        Self { port, robot, stop, thread: Some(thread) }
    }

    /// Looks at the robot.
    pub fn robot<T>(&self, look: impl FnOnce(&FakeRobot) -> T) -> T {
        look(&self.robot.lock().expect("the pump does not panic"))
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Ends, and so closes the terminal, when the robot's cable is pulled.
fn pump(mut master: PtyMaster, robot: &Mutex<FakeRobot>, stop: &AtomicBool) {
    let begin = Instant::now();
    let mut frames = 0_u64;
    let mut bytes = [0; 256];
    while !stop.load(Ordering::Relaxed) && begin.elapsed() < LIFETIME {
        let (heard, is_open) = match master.read(&mut bytes) {
            Ok(count) => (&bytes[..count], true),
            Err(error) if error.kind() == ErrorKind::WouldBlock => (&bytes[..0], true),
            // No host has the port open: nobody hears what the robot says.
            Err(_) => (&bytes[..0], false),
        };
        let Ok(mut robot) = robot.lock() else { return };
        if robot.write_all(heard).is_err() {
            return;
        }
        while frames < begin.elapsed().as_millis() as u64 * 60 / 1000 {
            robot.frame();
            frames += 1;
        }
        let said = robot.take_said();
        drop(robot);
        if is_open {
            // A host that closed the port in this moment does not hear it.
            let _ = master.write_all(&said);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
