"""A hand that differs from another in a few parameters, and limits of one's own."""

from handgen.checks.limits import standard


def changed(hand, **values):
    """`hand` with values at key paths, dots written as double underscores; list indices as numbers."""
    for path, value in values.items():
        hand = _set(hand, path.split("__"), value)
    return hand


def _set(node, keys, value):
    if not keys:
        return value
    key, *rest = keys
    if isinstance(node, list):
        index = int(key)
        return [_set(item, rest, value) if i == index else item for i, item in enumerate(node)]
    return node.model_copy(update={key: _set(getattr(node, key), rest, value)})


def limits(rule, **values):
    """The shipped limits with other values for some of `rule`'s; a kind follows two underscores."""
    own = {}
    for name, value in values.items():
        name, _, kind = name.partition("__")
        row = {"value": value, "reason": "a test"}
        own.setdefault(name, {}).update({"for": {kind: row}} if kind else row)
    return standard().beside({rule: own})


def named(parts):
    """Parts by their names, as a catalogue lists them."""
    return {part.name: part for part in parts}
