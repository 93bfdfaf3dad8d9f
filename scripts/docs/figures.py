"""Checks that measured figures say at which commit they were measured.

A section with figures carries a line such as

    <!-- measured: commit c302bd3, command: host experiment --trials 10 -->
    Measured at commit `c302bd3` with `host experiment`.

or says why it needs none: <!-- not measured: from the data sheet -->. It
does not read the figures, so it cannot tell whether they are still true.
"""
import re
import subprocess

# Where measured figures may stand. Elsewhere numbers are settings and arithmetic.
FILES = ["README.md", "docs/*.md"]
# What only a run can tell: a speed, a power, a mean with its interval, a rate.
NUMBER = r"\d[\d.,]*"
FIGURE = re.compile(
    rf"{NUMBER} (?:m/s|W|J|MiB)\b|{NUMBER} ± ?{NUMBER}|{NUMBER} (?:updates|trials|(?:control )?steps) a second"
)
MARKER = re.compile(r"(?i)<!--\s*measured: commit ([0-9a-f]{7,40})\b|\bmeasured at commit `?([0-9a-f]{7,40})\b")
NOT_MEASURED = re.compile(r"<!--\s*not measured: \S")


def in_history(root, commit):
    """False if git knows that `commit` is no ancestor of this tree; True if it is, or nobody can tell."""

    def git(*words):
        return subprocess.run(["git", *words], cwd=root, capture_output=True, text=True)

    shallow = git("rev-parse", "--is-shallow-repository")
    if shallow.returncode != 0 or shallow.stdout.strip() == "true":
        return True
    return git("merge-base", "--is-ancestor", commit, "HEAD").returncode == 0


def check(root, document):
    """(line, fault) for every section of the document."""
    for start, heading, rows in document.sections():
        text = "\n".join(row for _, row in rows)
        for line, row in rows:
            for match in MARKER.finditer(row):
                commit = match[1] or match[2]
                if not in_history(root, commit):
                    yield line, f"measured at commit {commit}, which is not in this history"
        figure = next(((line, FIGURE.search(row)) for line, row in rows if FIGURE.search(row)), None)
        if figure and not MARKER.search(text) and not NOT_MEASURED.search(text):
            line, found = figure
            yield line, (
                f"{found[0]!r} in section {heading!r} does not say where it was measured; write "
                "<!-- measured: commit HASH, command: ... --> or <!-- not measured: why --> in the section"
            )
