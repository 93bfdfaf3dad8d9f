"""Checks commands from the documents against the real command lines.

`make` is known by the Makefile, `cargo` by `cargo metadata`, and our own programs by
what they print for --help. Does not depend on Markdown.
"""
import functools
import json
import pathlib
import re
import shlex
import subprocess

# What may stand for the rest of a command.
REST = {"...", "…"}
# Of the cargo commands in the documents; True where a value follows.
CARGO_FLAGS = {
    "--package": True, "-p": True, "--bin": True, "--example": True, "--test": True, "--features": True, "-F": True,
    "--manifest-path": True, "--target": True, "--target-dir": True, "--profile": True, "--exclude": True,
    "--root": True, "--path": True, "--jobs": True, "-j": True, "--version": True, "--config": True,
    "--no-default-features": False, "--all-features": False, "--release": False, "--locked": False,
    "--workspace": False, "--all": False, "--all-targets": False, "--bins": False, "--tests": False,
    "--examples": False, "--lib": False, "--doc": False, "--no-deps": False, "--open": False, "--check": False,
    "--quiet": False, "-q": False, "--offline": False, "--no-run": False, "--debug": False, "--force": False,
}
CARGO_COMMANDS = {"run", "build", "test", "check", "clippy", "fmt", "doc", "clean", "tree", "metadata", "update"}
# Commands of other packages; their arguments are not looked at.
CARGO_PLUGINS = {"install", "deny", "machete", "add"}


class Wrong(Exception):
    """What is wrong with a command, for the reader of the document."""


def words_of(command):
    """The command's words without its comment; placeholders such as [--leg 1.0] and A|B are kept as words."""
    command = re.sub(r"[\[\]]", " ", command)
    try:
        return shlex.split(command, comments=True)
    except ValueError as cause:
        raise Wrong(f"not readable: {cause}") from cause


class Help:
    """A program's or subcommand's own account of its flags: none, OPTIONAL or NEEDED value."""

    FLAG = re.compile(r"^ +(?:(-\w)(?:, |(?= )))?(--[a-z][\w-]*)?(?:[ =]?(\[=?)?(<[^>]+>)\]?)?(?:\.\.\.)?(?: |$)")
    NONE, OPTIONAL, NEEDED = range(3)

    def __init__(self, text):
        self.text = text
        self.flags, self.values, last = {}, {}, None
        for row in text.splitlines():
            match = self.FLAG.match(row)
            if match and (match[1] or match[2]) and row.lstrip().startswith("-"):
                value = self.NONE if not match[4] else self.OPTIONAL if match[3] else self.NEEDED
                last = [name for name in match.groups()[:2] if name]
                for name in last:
                    self.flags[name] = value
            possible = re.search(r"\[possible values: ([^\]]*)\]", row)
            if possible and last:
                for name in last:
                    self.values[name] = [value.strip() for value in possible[1].split(",")]
            # Values with a line of help each stand below each other.
            listed = re.match(r"\s+Possible values:", row)
            if listed and last:
                for name in last:
                    self.values[name] = []
            entry = re.match(r"\s+- ([\w-]+)(?::|$)", row)
            if entry and last:
                for name in last:
                    if name in self.values:
                        self.values[name].append(entry[1])
        usage = re.search(r"^Usage:(.*?)(?:\n\s*\n|\Z)", text, re.S | re.M)
        usage = " ".join(usage[1].split()) if usage else ""
        self.has_commands = "COMMAND" in usage
        own = re.sub(r"\[OPTIONS\]|--[\w-]+ <[^>]+>|<--[^>]*>", "", usage)
        self.takes_arguments = self.has_commands or "<" in own or "[" in own


class Programs:
    """Our own programs, asked for their --help once each."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def exists(self, name):
        return (self.folder / name).exists()

    @functools.cache
    def help(self, name, *subcommands):
        command = [self.folder / name, *subcommands, "--help"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        return Help(done.stdout) if done.returncode == 0 else None

    @functools.cache
    def subcommands(self, name):
        """The subcommands in a program's help, however it groups them."""
        words = re.findall(r"^ {2,6}([a-z][a-z0-9-]*)\s{2,}\S", self.help(name).text, re.M)
        return [word for word in words if word != "help" and self.help(name, word)]

    def all_flags(self, name):
        for sub in self.subcommands(name):
            yield from self.help(name, sub).flags
            if self.help(name, sub).has_commands:
                for nested in re.findall(r"^ {2,6}([a-z][a-z0-9-]*)\s{2,}\S", self.help(name, sub).text, re.M):
                    if nested != "help" and self.help(name, sub, nested):
                        yield from self.help(name, sub, nested).flags
        yield from self.help(name).flags

    def check(self, name, words):
        """Raises Wrong if `words` are not arguments that the program takes."""
        if not self.exists(name):
            raise Wrong(f"there is no {self.folder / name} to ask; build it first")
        known, sub = self.help(name), ()
        if known is None:
            raise Wrong(f"{name} --help fails")
        while known.has_commands and words and not words[0].startswith("-"):
            if words[0] in REST:
                return
            sub, words = (*sub, words[0]), words[1:]
            if sub[-1] == "help":
                return
            asked = self.help(name, *sub)
            if asked is None:
                raise Wrong(f"{' '.join((name, *sub[:-1]))} has no subcommand {sub[-1]}")
            known = asked
        self.check_flags(" ".join((name, *sub)), known, words)

    @staticmethod
    def check_flags(called, known, words):
        at = 0
        while at < len(words):
            word, at = words[at], at + 1
            if word in REST:
                return
            if not word.startswith("-") or re.fullmatch(r"-?[\d.]+.*", word):
                if not known.takes_arguments:
                    raise Wrong(f"{called} takes no argument, but gets {word}")
                continue
            flag, equals, value = word.partition("=")
            if flag not in known.flags:
                raise Wrong(f"{called} has no {flag}")
            if not equals and known.flags[flag] != Help.NONE:
                if at < len(words) and not words[at].startswith("--"):
                    value, at = words[at], at + 1
                elif known.flags[flag] == Help.NEEDED:
                    raise Wrong(f"{flag} of {called} needs a value")
            allowed = known.values.get(flag)
            stands_for_one = not value or value in REST or re.fullmatch(r"[A-Z_]+", value)
            if allowed and not stands_for_one and not set(re.split("[|,]", value)) <= set(allowed):
                raise Wrong(f"{flag} of {called} takes {', '.join(allowed)}, not {value}")


class Commands:
    """The three kinds of command that the documents give."""

    def __init__(self, root, binaries):
        self.root, self.programs = root, Programs(binaries)
        makefile = (root / "Makefile").read_text()
        self.targets = set(re.findall(r"^([\w-]+):(?!=)", makefile, re.M))
        self.variables = set(re.findall(r"^([A-Z_]+)\s*\??=", makefile, re.M))

    @functools.cache
    def packages(self, folder):
        command = ["cargo", "metadata", "--no-deps", "--format-version", "1", "--offline"]
        done = subprocess.run(command, cwd=self.root / folder, capture_output=True, text=True, check=True)
        return {package["name"]: package for package in json.loads(done.stdout)["packages"]}

    def is_command(self, text):
        words = text.split()
        while words and re.fullmatch(r"[A-Z_]+=\S*|\$", words[0]):
            words.pop(0)
        return len(words) > 1 and words[0] in ("host", "cargo", "make") or text.startswith("cd ") and "&&" in text

    def check(self, text):
        folder = "."
        for part in re.split(r"\s+(?:&&|;|\|)\s+", text):
            words = words_of(part.removeprefix("$ "))
            while words and re.fullmatch(r"[A-Z_]+=.*", words[0]):
                words.pop(0)
            if not words:
                continue
            program, rest = words[0], words[1:]
            if program == "cd":
                folder = rest[0]
                if not (self.root / folder).is_dir():
                    raise Wrong(f"there is no folder {folder}")
            elif program == "make":
                self.check_make(rest)
            elif program == "cargo":
                self.check_cargo(rest, folder)
            elif program == "host":
                self.programs.check("host", rest)

    def check_make(self, words):
        for word in words:
            variable = re.match(r"([A-Z_]+)=", word)
            if variable and variable[1] not in self.variables:
                raise Wrong(f"the Makefile has no variable {variable[1]}")
            if not variable and not word.startswith("-") and word not in REST and word not in self.targets:
                raise Wrong(f"the Makefile has no target {word}")

    def check_cargo(self, words, folder):
        if words and words[0].startswith("+"):
            words = words[1:]
        if not words or words[0].startswith("-") or words[0] in CARGO_PLUGINS | REST:
            return
        command, words = words[0], words[1:]
        if command not in CARGO_COMMANDS:
            raise Wrong(f"cargo {command} is not known here")
        own = words[words.index("--") + 1 :] if "--" in words else None
        words = words[: words.index("--")] if "--" in words else words
        given, at = {}, 0
        while at < len(words):
            flag, equals, value = words[at].partition("=")
            at += 1
            if flag in REST or not flag.startswith("-"):
                continue
            if flag not in CARGO_FLAGS:
                raise Wrong(f"cargo's {flag} is not known here")
            if CARGO_FLAGS[flag] and not equals:
                if at == len(words) or words[at].startswith("-"):
                    raise Wrong(f"cargo's {flag} needs a value")
                value, at = words[at], at + 1
            given.setdefault({"-p": "--package", "-F": "--features"}.get(flag, flag), []).append(value)
        self.check_packages(command, given, own, self.packages(folder))

    def check_packages(self, command, given, own, packages):
        named = given.get("--package", [])
        for name in named:
            if name not in packages and not re.fullmatch(r"[A-Z_]+", name):
                raise Wrong(f"the workspace has no package {name}")
        among = [packages[name] for name in named if name in packages] or list(packages.values())
        for flag, kind in (("--bin", "bin"), ("--example", "example"), ("--test", "test")):
            for name in given.get(flag, []):
                targets = {target["name"] for package in among for target in package["targets"] if kind in target["kind"]}
                if name not in targets and not re.fullmatch(r"[A-Z_]+", name):
                    raise Wrong(f"there is no {kind} {name} in {' or '.join(package['name'] for package in among)}")
        for features in given.get("--features", []):
            for feature in re.split("[, ]", features):
                if not any(feature in package["features"] for package in among):
                    raise Wrong(f"{' or '.join(package['name'] for package in among)} has no feature {feature}")
        if command == "run" and own is not None and "--example" not in given:
            bins = [target["name"] for package in among for target in package["targets"] if "bin" in target["kind"]]
            default = [package["default_run"] for package in among if package["default_run"]]
            run = given.get("--bin") or default or bins
            if self.programs.exists(run[0]) or run[0] == "host":
                self.programs.check(run[0], own)
