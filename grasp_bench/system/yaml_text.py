"""YAML of strangers: plain data or one clear error, and never more of it than was written."""

from __future__ import annotations

from typing import Any

import yaml

from grasp_bench.system.texts import said, shown

MOST_BYTES = 2**20
"""Largest text that is read."""
MOST_NODES = 50_000
"""Most values that a text may stand for, those that its aliases repeat included."""
DEEPEST = 100
"""Most levels of values within values."""


def read_yaml(text: str) -> Any:
    """Return the content of a YAML text.

    Raises:
        ValueError: for what is not YAML, a key that comes twice in one mapping, an impossible number or date,
            values nested too deeply, and aliases that make much of little.
    """
    if len(text) > MOST_BYTES:
        raise ValueError(f"larger than {MOST_BYTES:,} bytes")
    loader = None
    try:
        loader = _Loader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _size(node, {}, 0)
        return loader.construct_document(node)
    except (yaml.YAMLError, RecursionError, ValueError, TypeError, AttributeError, LookupError) as error:
        if isinstance(error, RecursionError):
            raise ValueError("nested too deeply") from error
        raise ValueError(said(error, 400) or type(error).__name__) from error
    finally:
        if loader is not None:
            loader.dispose()


class _Loader(yaml.SafeLoader):
    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Refuse a key that comes twice; merged keys (``<<``) may be written over."""
        own = [k for k, _ in node.value if k.tag != "tag:yaml.org,2002:merge"]
        keys = [(k.tag, k.value) for k in own if isinstance(k, yaml.ScalarNode)]
        for key, node_of_key in zip(keys, own, strict=False):
            if keys.count(key) > 1:
                line = node_of_key.start_mark.line + 1
                raise ValueError(f"the key {shown(key[1])} comes twice (line {line})")
        return super().construct_mapping(node, deep)


def _size(node: yaml.Node, known: dict[int, int], depth: int) -> int:
    """Return how many values a node stands for, aliases written out; ValueError where they are too many."""
    if depth > DEEPEST:
        raise ValueError("nested too deeply, or an alias of itself")
    if id(node) in known:
        return known[id(node)]
    total = 1
    if isinstance(node, yaml.SequenceNode):
        total += sum(_size(child, known, depth + 1) for child in node.value)
    elif isinstance(node, yaml.MappingNode):
        total += sum(_size(child, known, depth + 1) for pair in node.value for child in pair)
    if total > MOST_NODES:
        raise ValueError(f"its aliases stand for more than {MOST_NODES:,} values")
    known[id(node)] = total
    return total
