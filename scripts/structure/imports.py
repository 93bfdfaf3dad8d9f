"""Finds which module imports which, and which siblings do so in a circle.

Holds how a path is resolved: crate, super, self, children, imported names, globs,
and re-exports, which are followed to the module that defines a name. Does not
depend on any rule.
"""
import collections

from structure.rust import Module, walk


class Resolver:
    """Finds the modules that a path leads through."""

    def __init__(self, crates):
        self.crates = crates

    def module_at(self, path):
        module = self.crates[path[0]]
        for name in path[1:]:
            module = module.children[name]
        return module

    def lead(self, module, path, seen=frozenset()):
        """(module, name in it) for every module on the way; an outside crate stands for itself."""
        first, rest = path[0], path[1:]
        if first == "crate":
            return self.follow(self.crates[module.path[0]], rest, seen)
        if first == "self":
            return self.follow(module, rest, seen)
        if first == "super":
            if len(module.path) == 1:
                return []
            return self.follow(self.module_at(module.path[:-1]), rest, seen)
        if first in module.children or first in module.imports:
            return self.follow(module, path, seen)
        if first in self.crates:
            return self.follow(self.crates[first], rest, seen)
        return [(first, rest[0] if rest else first)] if rest else []

    def follow(self, module, path, seen):
        if not path or path[0] == "*":
            return [(module, "*" if path else module.path[-1])]
        name, rest = path[0], path[1:]
        if name == "super":
            return self.lead(module, path, seen)
        if name in module.children:
            return self.follow(module.children[name], rest, seen)
        key = (module.path, name)
        if key in seen:
            return []
        here = [(module, name)]
        if name in module.imports:
            return here + self.lead(module, module.imports[name] + rest, seen | {key})
        if name not in module.items:
            for glob in module.imports.get("*", []):
                through = self.lead(module, glob + [name], seen | {key})
                if any(isinstance(at, Module) and name in at.items for at, _ in through):
                    return here + through
        return here


def imports_of(crates):
    """{(importer, imported): names} over module paths; an outside crate has a path of one name."""
    resolver, found = Resolver(crates), collections.defaultdict(set)
    for root in crates.values():
        for module in walk(root):
            for path in module.named:
                for target, name in resolver.lead(module, path):
                    if isinstance(target, str):
                        found[module.path, (target,)].add(name)
                    elif target is not module:
                        found[module.path, target.path].add(name)
    return found


def circles(imports):
    """Every set of siblings that import each other, with the imports that tie them."""
    levels = collections.defaultdict(lambda: collections.defaultdict(list))
    for (importer, imported), names in imports.items():
        shared = 0
        while shared < min(len(importer), len(imported)) and importer[shared] == imported[shared]:
            shared += 1
        if shared and shared < min(len(importer), len(imported)):
            edge = (importer[: shared + 1], imported[: shared + 1])
            levels[importer[:shared]][edge].append((importer, imported, names))
    for _, edges in sorted(levels.items()):
        graph = collections.defaultdict(set)
        for one, other in edges:
            graph[one].add(other)
        for group in strongly_connected(graph):
            yield group, [tie for (one, other), ties in sorted(edges.items()) if {one, other} <= group for tie in ties]


def strongly_connected(graph):
    def reach(start):
        seen, waiting = set(), [start]
        while waiting:
            for next_one in graph[waiting.pop()] - seen:
                seen.add(next_one)
                waiting.append(next_one)
        return seen

    reached = {one: reach(one) for one in list(graph)}
    groups = {frozenset(other for other in reached[one] if one in reached.get(other, ())) for one in reached}
    return sorted((group for group in groups if group), key=sorted)
