"""Reads Rust files into modules with the paths that they name; test code is left out.

Holds as much of Rust's grammar as that takes. Does not depend on what the paths
mean: see imports.py.
"""
import re

TOKEN = re.compile(
    r"""(?P<skip> \s+ | //[^\n]* )
    | (?P<block> /\* )
    | (?P<raw> b?c?r(?P<hashes>\#*)"(?s:.*?)"(?P=hashes) )
    | (?P<string> [bc]?"(?:[^"\\]|\\(?s:.))*" )
    | (?P<char> b?'(?:[^'\\]|\\u\{[0-9a-fA-F_]+\}|\\x[0-9a-fA-F]{2}|\\.)' )
    | (?P<lifetime> '[A-Za-z_]\w* )
    | (?P<name> (?:r\#)?[A-Za-z_]\w* )
    | (?P<number> \d[\w.]* )
    | (?P<path> :: )
    | (?P<other> . )""",
    re.X,
)
NAME = re.compile(r"[A-Za-z_]\w*$")
OPEN, CLOSE = "([{", ")]}"
ITEM_WORDS = {"fn", "struct", "enum", "union", "trait", "type", "const", "static"}


def tokens_of(text):
    """The names and marks of a Rust text; comments, strings and numbers left out."""
    found, at = [], 0
    while at < len(text):
        match = TOKEN.match(text, at)
        at = match.end()
        if match.lastgroup == "block":
            depth = 1
            while depth and at < len(text):
                if text.startswith("/*", at):
                    depth, at = depth + 1, at + 2
                elif text.startswith("*/", at):
                    depth, at = depth - 1, at + 2
                else:
                    at += 1
        elif match.lastgroup == "name":
            found.append(match.group().removeprefix("r#"))
        elif match.lastgroup in ("path", "other"):
            found.append(match.group())
    return found


def matching(tokens, start):
    """Where the bracket that opens at `start` is closed."""
    depth = 0
    for at in range(start, len(tokens)):
        depth += (tokens[at] in OPEN) - (tokens[at] in CLOSE)
        if depth == 0:
            return at
    return len(tokens) - 1


def end_of_item(tokens, start):
    """The last token of the item that starts at `start`."""
    words = tokens[start : start + 6]
    at, is_use = start, "use" in words and "fn" not in words
    while at < len(tokens):
        if tokens[at] == ";":
            return at
        if tokens[at] in OPEN:
            closed = matching(tokens, at)
            if tokens[at] == "{" and not is_use:
                return closed
            at = closed
        elif tokens[at] in CLOSE:
            return at - 1
        at += 1
    return len(tokens) - 1


def is_for_tests(attribute):
    """Whether `#[...]` leaves its item out of a build that is no test."""
    return attribute[:1] == ["test"] or (
        attribute[:1] == ["cfg"] and "test" in attribute and "not" not in attribute and "any" not in attribute
    )


class Module:
    """One module: its file, its children, and which paths it names."""

    def __init__(self, path, file):
        self.path, self.file = path, file
        self.children, self.items, self.imports = {}, set(), {}
        # Paths as they are written, with the module that they are resolved from.
        self.named = []
        self.test_children = set()


def use_tree(tokens, at, prefix):
    """The paths of one `use` tree, as (path, name here), and where it ends."""
    path, found = list(prefix), []
    while at < len(tokens):
        token = tokens[at]
        if token == "{":
            end = matching(tokens, at)
            at += 1
            while at < end:
                inner, at = use_tree(tokens, at, path)
                found += inner
                # A comma, or whatever is no `use` tree after all.
                at += 1
            return found, end + 1
        if token == "*":
            return [(path, "*")], at + 1
        if token == "as":
            return [(path, tokens[at + 1])], at + 2
        if token in ",;}":
            break
        if token != "::":
            path.append(token)
        at += 1
    if path and path[-1] == "self" and len(path) > 1:
        path.pop()
    return [(path, path[-1])] if path else [], at


def read_module(module, tokens):
    """Fills `module` from its tokens, and the modules that it writes out in braces."""
    at = 0
    while at < len(tokens):
        token = tokens[at]
        if token == "#" and tokens[at + 1 : at + 2] == ["["]:
            end = matching(tokens, at + 1)
            at, attribute = end + 1, tokens[at + 2 : end]
            if is_for_tests(attribute):
                while tokens[at : at + 2] == ["#", "["]:
                    at = matching(tokens, at + 1) + 1
                end = end_of_item(tokens, at)
                item = tokens[at : end + 1]
                if "mod" in item[:6] and item[-1:] == [";"]:
                    module.test_children.add(item[-2])
                at = end + 1
        elif token == "use" and tokens[at + 1 : at + 2] != ["<"]:
            found, at = use_tree(tokens, at + 1, [])
            for path, name in found:
                module.named.append(path + ["*"] if name == "*" else path)
                if name == "*":
                    module.imports.setdefault("*", []).append(path)
                elif name != "_":
                    module.imports[name] = path
        elif token == "mod" and at + 2 < len(tokens) and tokens[at + 2] == "{":
            end = matching(tokens, at + 2)
            child = Module(module.path + (tokens[at + 1],), module.file)
            module.children[tokens[at + 1]] = child
            read_module(child, tokens[at + 3 : end])
            at = end + 1
        elif NAME.match(token) and tokens[at + 1 : at + 2] == ["::"] and tokens[at - 1 : at] != ["::"]:
            path = [token]
            while tokens[at + 1 : at + 2] == ["::"] and at + 2 < len(tokens) and NAME.match(tokens[at + 2]):
                path.append(tokens[at + 2])
                at += 2
            module.named.append(path)
            at += 1
        else:
            if token in ITEM_WORDS and at + 1 < len(tokens):
                module.items.add(tokens[at + 1])
            at += 1


def roots_of(crate):
    """The crates of a package: its library and each binary, by name and main file."""
    source = crate / "src"
    name = crate.name.replace("-", "_")
    if (source / "lib.rs").exists():
        yield name, source / "lib.rs", source
    if (source / "main.rs").exists():
        yield f"{crate.name}/{crate.name}", source / "main.rs", None
    for main in sorted([*(source / "bin").glob("*.rs"), *(source / "bin").glob("*/main.rs")]):
        own = main.name == "main.rs"
        yield f"{crate.name}/{main.parent.name if own else main.stem}", main, main.parent if own else None


def read_tree(root, packages):
    """All modules of the packages below `root`, by the name of their crate."""
    crates = {}
    for crate in packages:
        for name, main, folder in roots_of(root / crate):
            crates[name] = read_file(Module((name,), main), folder, main)
    return crates


def read_file(module, folder, main=None):
    read_module(module, tokens_of(module.file.read_text()))
    if folder is None:
        return module
    files = {}
    for file in sorted(folder.glob("*.rs")):
        files[file.stem] = file
    for file in sorted(folder.glob("*/mod.rs")):
        files[file.parent.name] = file
    for name, file in files.items():
        for_tests = name in module.test_children or name == "tests"
        if file in (main, module.file) or name in ("main", "lib", "mod") or for_tests:
            continue
        child = Module(module.path + (name,), file)
        module.children[name] = child
        read_file(child, folder / name if (folder / name).is_dir() else None)
    return module


def walk(module):
    yield module
    for child in module.children.values():
        yield from walk(child)
