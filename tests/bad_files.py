"""Bad parameter files and what a report must say of each."""

from dataclasses import dataclass

VARIANT = "extends: adult.yaml\n"


@dataclass(frozen=True)
class Bad:
    """A file's text and what is wrong with it: key path -> what the report must say there."""

    name: str
    text: str | bytes
    errors: dict[str, str]


def variant(name: str, text: str, errors: dict[str, str]) -> Bad:
    return Bad(name, VARIANT + text, errors)


FILES = [
    # The file as a file
    Bad("empty", "", {"": "empty"}),
    Bad("blank", " \n\n", {"": "empty"}),
    Bad("only-a-comment", "# nothing\n", {"": "no mapping"}),
    Bad("list-on-top", "- 1\n- 2\n", {"": "no mapping"}),
    Bad("text-on-top", "hello", {"": "no mapping"}),
    Bad("not-utf8", b"name: \xff\xfe\n", {"": "UTF-8"}),
    Bad("binary", bytes(range(256)), {"": ""}),
    Bad("control-character", "name: a\x07b\n", {"": "not valid YAML"}),
    Bad("unclosed", VARIANT + "layers: {tip: 4\n", {"": "not valid YAML"}),
    Bad("tab-indented", VARIANT + "layers:\n\ttip: 4\n", {"": "not valid YAML"}),
    Bad("two-documents", VARIANT + "---\nname: b\n", {"": "more than one"}),
    Bad("key-is-a-list", VARIANT + "? [a, b]\n: 1\n", {"": "plain word"}),
    Bad("10-MB-of-nesting", "[" * 10_000_000, {"": "larger than"}),
    Bad("deep-flow", "a: " + "[" * 400_000, {"": "nested too deeply"}),
    Bad("deep-mappings", "{a: " * 100_000, {"": "nested too deeply"}),
    Bad("deep-block", "- " * 400_000, {"": "nested too deeply"}),
    # YAML that could do harm
    variant("tag-runs-code", "name: !!python/object/apply:os.system ['touch pwned']\n", {"name": "tags"}),
    variant("tag-opens-file", "name: !!python/name:os.system\n", {"name": "tags"}),
    variant("own-tag", "layers: !mine {tip: 4}\n", {"layers": "tags"}),
    variant("duplicate-key", "name: a\nname: b\n", {"name": "twice"}),
    variant("duplicate-below", "layers: {tip: 4, external: 1, tip: 5}\n", {"layers.tip": "twice"}),
    variant("anchor", "name: &a hand\n", {"name": "anchor"}),
    variant(
        "alias-bomb",
        "a: &a [x, x]\nb: &b [*a, *a]\n",
        {"a": "anchor", "b": "anchor", "b[0]": "alias", "b[1]": "alias"},
    ),
    variant("merge-key", "layers:\n  <<: {tip: 4}\n", {"layers.<<": "unknown key"}),
    # Version and kind
    Bad(
        "other-kind",
        "schema: handgen.measurements/1\nname: x\n",
        {"schema": "not a parameter file of a hand"},
    ),
    variant("unknown-version", "schema: handgen.hand/2\n", {"schema": "unknown version"}),
    variant("version-is-a-number", "schema: 1\n", {"schema": "unknown version"}),
    variant("version-removed", "schema: null\n", {"schema": "unknown version"}),
    # Chains of files
    Bad("missing-base", "extends: adlut.yaml\n", {"extends": "no such file"}),
    Bad("base-is-a-folder", "extends: .\n", {"extends": "directory"}),
    Bad("base-is-a-number", "extends: 3\n", {"extends": "name of a YAML file"}),
    Bad("base-has-nul", 'extends: "a\\0b"\n', {"extends": "name of a YAML file"}),
    Bad("extends-itself", "extends: bad.yaml\n", {"extends": "circle"}),
    Bad(
        "missing-base-and-more",
        "extends: no.yaml\nlayers: {tip: -1}\nnam: x\n",
        {"extends": "no such file", "layers.tip": "too small", "nam": "unknown key"},
    ),
    # Names
    variant("name-climbs-out", "name: ../../etc/passwd\n", {"name": "path separator"}),
    variant("name-with-backslash", "name: a\\b\n", {"name": "path separator"}),
    variant("name-empty", "name: ''\n", {"name": "name"}),
    variant("name-too-long", f"name: {'x' * 65}\n", {"name": "name"}),
    variant("name-with-newline", 'name: "adult\\n"\n', {"name": "name"}),
    variant("name-is-a-number", "name: 12\n", {"name": "a text"}),
    # Numbers
    variant("nan", "layers: {tip: .nan}\n", {"layers.tip": "not a finite"}),
    variant("infinity", "layers: {tip: .inf}\n", {"layers.tip": "not a finite"}),
    variant("minus-infinity", "layers: {tip: -.inf}\n", {"layers.tip": "not a finite"}),
    variant("overflow", "layers: {tip: 1e400}\n", {"layers.tip": "not a finite"}),
    variant("five-thousand-digits", f"layers: {{tip: {'9' * 5000}}}\n", {"layers.tip": "not a finite"}),
    variant("negative", "layers: {tip: -4}\n", {"layers.tip": "too small"}),
    variant("quoted-number", "layers: {tip: '4'}\n", {"layers.tip": "text where a number"}),
    variant("number-with-unit", "layers: {tip: 4 mm}\n", {"layers.tip": "text where a number"}),
    variant("decimal-comma", "layers:\n  tip: 4,5\n", {"layers.tip": "text where a number"}),
    variant("boolean-as-number", "layers: {tip: true}\n", {"layers.tip": "a number"}),
    variant("number-as-boolean", "thread: {groove: 1}\n", {"thread.groove": "true or false"}),
    variant("yes-is-no-boolean", "thread: {groove: yes}\n", {"thread.groove": "true or false"}),
    variant("list-as-number", "layers: {tip: [4]}\n", {"layers.tip": "a number"}),
    variant("number-as-mapping", "layers: 4\n", {"layers": "a mapping"}),
    variant("list-as-mapping", "fingers: [1, 2]\n", {"fingers": "a mapping"}),
    variant("mapping-as-list", "fingers: {index: {joints: {a: 1}}}\n", {"fingers.index.joints": "a list"}),
    variant("no-joints", "fingers: {index: {joints: []}}\n", {"fingers.index.joints": "0 entries"}),
    variant(
        "point-of-two",
        "fingers: {index: {placement: {root: [1, 2]}}}\n",
        {"fingers.index.placement.root": "2 entries"},
    ),
    variant(
        "text-in-point",
        "fingers: {index: {placement: {root: [1, 2, a]}}}\n",
        {"fingers.index.placement.root[2]": "text where a number"},
    ),
    variant("unknown-choice", "side: lift\n", {"side": "none of the known"}),
    variant("required-removed", "layers: {tip: null}\n", {"layers.tip": "missing"}),
    # Keys
    variant(
        "misspelt", "fingers: {index: {outer_lenght: 100}}\n", {"fingers.index.outer_lenght": "unknown key"}
    ),
    variant("number-as-key", "layers: {3: 4}\n", {"layers.3": "unknown key"}),
    variant(
        "pattern-matches-nothing",
        "assumed: {fingers.*.taperr: why}\n",
        {"assumed.fingers.*.taperr": "matches nothing"},
    ),
    # Relations
    variant(
        "no-tip", "fingers: {index: {inner_length: 102}}\n", {"fingers.index.inner_length": "no closed tip"}
    ),
    variant(
        "no-wall",
        "fingers: {index: {tip_bore_diameter: 15}}\n",
        {"fingers.index.tip_bore_diameter": "wall of 0.25 mm"},
    ),
    variant(
        "widening",
        "fingers: {index: {tip_outer_diameter: 21}}\n",
        {"fingers.index.tip_outer_diameter": "wider than the base"},
    ),
    variant(
        "bad-taper",
        "fingers: {index: {taper: [[0, 0.1], [0.5, 0.6], [0.5, 0.4], [0.9, 1]]}}\n",
        {
            "fingers.index.taper[0]": "start",
            "fingers.index.taper[3]": "end",
            "fingers.index.taper[2][0]": "follow",
            "fingers.index.taper[2][1]": "narrows",
        },
    ),
    variant(
        "slots-out-of-place",
        "fingers: {thumb: {joints: ["
        "{name: A, position: 4, slot_length: 9, palmar_arc: 80}, "
        "{name: A, position: 12, slot_length: 6, palmar_arc: 80}, "
        "{name: C, position: 60, slot_length: 6, palmar_arc: 80}]}}\n",
        {
            "fingers.thumb.joints[0].position": "out of the bore",
            "fingers.thumb.joints[1].name": "this name",
            "fingers.thumb.joints[1].position": "2 mm closed",
            "fingers.thumb.joints[2].position": "out of",
        },
    ),
    variant(
        "curled-through",
        "fingers: {index: {joints: ["
        "{name: A, position: 16, slot_length: 14, palmar_arc: 80, rest_angle: 70}, "
        "{name: B, position: 46, slot_length: 14, palmar_arc: 80, rest_angle: 70}, "
        "{name: C, position: 76, slot_length: 14, palmar_arc: 80, rest_angle: 70}]}}\n",
        {"fingers.index.joints": "add up"},
    ),
    variant(
        "strip-bent-into-itself",
        "fingers: {index: {joints: ["
        "{name: A, position: 16, slot_length: 9, palmar_arc: 80, rest_angle: 48}, "
        "{name: B, position: 46, slot_length: 9, palmar_arc: 80, rest_angle: 49}]}}\n",
        {"fingers.index.joints[1].rest_angle": "into itself"},
    ),
    variant(
        "finger-without-actuator", "actuators: {ring: null}\n", {"actuators.ring": "ring has no actuator"}
    ),
    variant("actuator-without-finger", "fingers: {ring: null}\n", {"fingers.ring": "ring has no finger"}),
    variant(
        "actuator-too-big",
        "actuators: {ring: {outer_length: 93, base_outer_diameter: 16.1}}\n",
        {
            "actuators.ring.outer_length": "longer than the bore",
            "actuators.ring.base_outer_diameter": "wider than the bore",
        },
    ),
    variant(
        "tapers-differ",
        "actuators: {index: {taper: [[0, 0], [0.9, 0.1], [1, 1]]}}\n",
        {"actuators.index.taper": "though both ends fit"},
    ),
    variant(
        "no-core",
        "actuators: {index: {layers: {external: 3.5, thread: 0.5, internal: 3, tip: 4}}}\n",
        {"actuators.index.layers": "small core of 2 mm"},
    ),
    variant(
        "too-thin-at-the-tip",
        "actuators: {index: {tip_outer_diameter: 3}}\n",
        {"actuators.index.tip_outer_diameter": "too little"},
    ),
    variant(
        "all-tip",
        "actuators: {index: {layers: {external: 1, thread: 0.5, internal: 1, tip: 15}, outer_length: 15}}\n",
        {"actuators.index.layers.tip": "fills the whole"},
    ),
    variant(
        "thick-thread",
        "actuators: {index: {thread: {material: x, diameter: 0.8, pitch: 0.7}}}\n",
        {"actuators.index.thread.diameter": "does not fit", "actuators.index.thread.pitch": "on each other"},
    ),
    variant(
        "no-room-for-a-turn",
        "actuators: {index: {thread: {material: x, diameter: 0.2, pitch: 20, "
        "held_back: 20}, outer_length: 60}}\n",
        {"actuators.index.thread.held_back": "less than one turn"},
    ),
    variant(
        "fat-tube",
        "seal: {tube_outer_diameter: 4.5}\nactuators: {little: {layers: "
        "{external: 0.8, thread: 0.2, internal: 0.8, tip: 4}}}\n",
        {"seal.tube_outer_diameter": "plug of opposition"},
    ),
    variant(
        "no-finger-and-no-actuator",
        "fingers: {index: null, middle: null, ring: null, little: null, thumb: null}\n"
        "actuators: {index: null, middle: null, ring: null, little: null, thumb: null, "
        "opposition_1: null, opposition_2: null}\npalm: null\nopposition: null\n",
        {"fingers": "no finger"},
    ),
    variant(
        "no-thumb-to-oppose",
        "fingers: {thumb: null}\nactuators: {thumb: null}\n",
        {"opposition": "needs a `thumb`"},
    ),
    variant("opposition-overlaps", "opposition: {spacing: 10}\n", {"opposition.spacing": "overlap"}),
    variant("long-plug", "seal: {plug_length: 35}\n", {"seal.plug_length": "reaches the tip"}),
    variant(
        "half-an-opposition", "actuators: {opposition_2: null}\n", {"actuators.opposition_2": "needs both"}
    ),
    variant("opposition-without-palm", "palm: null\n", {"opposition": "needs a `palm`"}),
    variant(
        "nothing-to-oppose",
        "opposition: null\n",
        {"actuators.opposition_1": "without", "actuators.opposition_2": "without"},
    ),
    variant("wrong-hand-length", "palm: {length: 190}\n", {"palm.length": "195|middle finger"}),
    variant(
        "unknown-role",
        "printing: {tooling: {part_adhesion: {plugg: brim}}}\n",
        {"printing.tooling.part_adhesion.plugg": "no part"},
    ),
    # Several at once, in different corners, each must be found
    variant(
        "many",
        "name: a/b\nside: up\ncolour: red\n"
        "fingers: {index: {outer_length: .nan, joints: 3}, midle: {}, ring: {inner_length: 102}}\n"
        "layers: {tip: true}\nthread: {pitch: 0}\n"
        "casting: {silicone: {density: '1'}}\nprinting: {build_volume: [1, 2, 3]}\npalm: {length: 180}\n"
        "assumed: {palmm: x}\n",
        {
            "name": "path separator",
            "side": "none of",
            "colour": "unknown",
            "fingers.index.outer_length": "finite",
            "fingers.index.joints": "list",
            "fingers.midle": "unknown",
            "fingers.ring.inner_length": "closed tip",
            "layers.tip": "number",
            "thread.pitch": "too small",
            "casting.silicone.density": "text",
            "printing.build_volume[0]": "too small",
            "printing.build_volume[1]": "too small",
            "printing.build_volume[2]": "too small",
            "palm.length": "middle finger",
            "assumed.palmm": "matches nothing",
        },
    ),
]

SAID_IN_BASE = {"no-thumb-to-oppose", "opposition-without-palm", "nothing-to-oppose"}
"""Variants that take away what a value of their base needs: the report names that value."""
