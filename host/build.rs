//! Lets binaries that link libtorch find it at run time.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // Exported by torch-sys, a direct dependency for this line's sake.
    if let Ok(folder) = std::env::var("DEP_TCH_LIBTORCH_LIB") {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}");
    }
}
