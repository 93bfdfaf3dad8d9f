"""A small tree, documents that are right about it, and others that are not: for check-docs --self-test."""

# A program of two commands, in the words of clap.
HOST = """#!/bin/sh
case "$*" in
--help) printf 'Usage: host <COMMAND>\\n\\nCommands:\\n  train  Learns\\n  twin   Fits\\n' ;;
'train --help') printf 'Usage: host train [OPTIONS]\\n\\nOptions:\\n      --preset <NAME>  One [possible values: walk, quick]\\n
  -j, --json\\n          As JSON\\n' ;;
'twin --help') printf 'Usage: host twin <COMMAND>\\n\\nCommands:\\n  fit  Fits\\n' ;;
'twin fit --help') printf 'Usage: host twin fit [OPTIONS] --out <DIR> [GAIT]\\n\\nOptions:\\n      --out <DIR>  To\\n' ;;
*) exit 2 ;;
esac
"""
TREE = {
    "Makefile": "SEED ?= 0\ndemo:\n\ttrue\n",
    "Cargo.toml": '[package]\nname = "host"\nversion = "0.1.0"\nedition = "2024"\n',
    "src/main.rs": "fn main() {}\n// a_name_of_four_words\n",
    "docs/other.md": "# Other\n\n## A part of it\n",
}
RIGHT = """# Sample

`make demo SEED=1`, `cargo run -p host -- train --preset quick`, `host twin fit gait.toml --out docs/new.svg`,
`train --json`, `host train ...`, `--preset`, `src/main.rs`, `main.rs`, `a_name_of_four_words`, `runs/latest`,
`host train [--preset quick|walk]`, `host train
--json`, [there](docs/other.md#a-part-of-it).

```sh
host train --json  # and a comment --wrong
host twin fit \\
  --out FOLDER
```
```toml
path = "host train --wrong"
```

## Figures

<!-- not measured: an example -->
It walks at 0.3 m/s.
"""
WRONG = {
    "`make dem`": "no target dem",
    "`make demo SED=1`": "no variable SED",
    "`cargo run -p hots -- train`": "no package hots",
    "`cargo run -p host --bin robot`": "no bin robot",
    "`cargo run -p host --features cuda`": "no feature cuda",
    "`host trian`": "no subcommand trian",
    "`host twin fitt --out x`": "no subcommand fitt",
    "`cargo run -p host -- train --sed 1`": "host train has no --sed",
    "`host twin fit --out`": "--out of host twin fit needs a value",
    "`train --preset fast`": "takes walk, quick, not fast",
    "`host train fast`": "takes no argument",
    "```sh\n$ host train \\\n  --wrong\n```": "host train has no --wrong",
    "`--wrong`": "no program here has --wrong",
    "`src/mian.rs`": "no src/mian.rs",
    "`mian.rs`": "no file of this tree is called mian.rs",
    "`a_name_that_is_gone`": "does not occur",
    "[there](docs/othr.md)": "leads nowhere",
    "[there](docs/other.md#no-part)": "has no heading #no-part",
    "It walks at 0.3 m/s.": "does not say where it was measured",
    "<!-- measured: commit 0123456 -->": "not in this history",
}
