//! Lets these binaries start when cargo has built them together with `host`.
//!
//! Nothing here uses libtorch, but cargo unifies features over one command:
//! `cargo test` in the root links `host` with `train`, and so libtorch, which
//! then must be found at run time.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    if let Ok(folder) = std::env::var("LIBTORCH") {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}/lib");
    }
}
