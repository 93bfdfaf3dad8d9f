//! Measures the firmware's ELF file on the emulated Nano and prints the table.
//!
//! Holds flags and output only. Exits with 0 when the report is complete, whatever
//! it says; `--check` makes a missed bar an error.

use clap::Parser;
use miette::{IntoDiagnostic as _, Result, bail};
use sim_tests::firmware_image::FirmwareImage;
use sim_tests::report::{self, Lengths};
use std::io::Write as _;
use std::path::PathBuf;

/// The firmware's figures, measured cycle by cycle.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    /// The firmware image
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// Emulated seconds for the pacing of frames; the other runs follow in proportion
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u32).range(5..=3600))]
    seconds: u32,
    /// Fail unless every figure is within its bar
    #[arg(long)]
    check: bool,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let elf = args.elf.unwrap_or_else(FirmwareImage::default_path);
    let table = report::measure(&elf, Lengths::of(f64::from(args.seconds))).into_diagnostic()?;
    let text = if args.json {
        let mut text = serde_json::to_string_pretty(&table.json()).into_diagnostic()?;
        text.push('\n');
        text
    } else {
        table.text()
    };
    // A reader that has seen enough closes its pipe.
    let _ = std::io::stdout().write_all(text.as_bytes());
    if args.check && !table.is_met() {
        bail!("not every figure is within its bar");
    }
    Ok(())
}
