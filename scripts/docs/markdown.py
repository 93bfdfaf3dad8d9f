"""Takes a Markdown file apart: headings, links, code spans, fenced blocks, sections.

Does not depend on what they contain. Reads the Markdown that these documents
are written in, not every Markdown: fences of three backticks, headings with #.
"""
import dataclasses
import re

SPAN = re.compile(r"(?<!`)`([^`]+)`(?!`)")
LINK = re.compile(r"!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(\s*([^)\s]+)[^)]*\)|<img\b[^>]*\bsrc=\"([^\"]+)\"")
ANCHOR = re.compile(r"<a\b[^>]*\b(?:id|name)=\"([^\"]+)\"")


@dataclasses.dataclass
class Document:
    """One file; lines are counted from 1."""

    path: str
    lines: list
    headings: list = dataclasses.field(default_factory=list)  # (line, level, text)
    links: list = dataclasses.field(default_factory=list)  # (line, target)
    spans: list = dataclasses.field(default_factory=list)  # (line, text)
    blocks: list = dataclasses.field(default_factory=list)  # (line of the first row, language, rows)
    anchors: set = dataclasses.field(default_factory=set)
    prose: list = dataclasses.field(default_factory=list)  # (line, text), outside of fences

    def sections(self):
        """(line, heading, [(line, text)]) from one heading of level 1 or 2 to the next, fences left out."""
        starts = [(line, text) for line, level, text in self.headings if level <= 2] or [(1, self.path)]
        ends = [line for line, _ in starts[1:]] + [len(self.lines) + 1]
        for (start, heading), end in zip(starts, ends):
            yield start, heading, [(line, text) for line, text in self.prose if start <= line < end]


def anchor_of(heading):
    """What GitHub makes of a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def read(path, text):
    document = Document(path, text.splitlines())
    fence, paragraph, counted = None, [], {}

    def end_paragraph():
        if not paragraph:
            return
        first = paragraph[0][0]
        whole = "\n".join(row for _, row in paragraph)
        for pattern, kept in ((SPAN, document.spans), (LINK, document.links)):
            # A link's text may be code, but what is written as code is no link.
            searched = whole if pattern is SPAN else SPAN.sub(lambda span: "x" * len(span.group()), whole)
            for match in pattern.finditer(searched):
                found = next(filter(None, match.groups()))
                line = first + whole.count("\n", 0, match.start())
                kept.append((line, " ".join(found.split()) if pattern is SPAN else found))
        paragraph.clear()

    for number, row in enumerate(document.lines, 1):
        stripped = row.strip()
        if fence is not None:
            if stripped == "```":
                document.blocks.append((number - len(fence[1]), *fence))
                fence = None
            else:
                fence[1].append(row)
            continue
        if stripped.startswith("```"):
            end_paragraph()
            fence = (stripped[3:].strip(), [])
            continue
        document.prose.append((number, row))
        document.anchors.update(ANCHOR.findall(row))
        heading = re.match(r"(#{1,6})\s+(.*?)\s*#*$", row)
        if heading:
            end_paragraph()
            document.headings.append((number, len(heading[1]), heading[2]))
            anchor = anchor_of(heading[2])
            counted[anchor] = counted.get(anchor, -1) + 1
            document.anchors.add(f"{anchor}-{counted[anchor]}" if counted[anchor] else anchor)
        # A row of a table and an item of a list are paragraphs of their own.
        if not stripped or stripped.startswith("|") or re.match(r"[-*]\s|\d+\.\s", stripped):
            end_paragraph()
        if stripped:
            paragraph.append((number, row))
    end_paragraph()
    return document
