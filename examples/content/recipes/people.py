"""People and animals."""
import math

from recipes.common import post, r, turn, walk


def band():
    characters, colors = [], ["#b5483a", "#e6e6ea", "#39597d", "#e6e6ea"]
    ranks, files, distance, interval = 10, 10, 1.7, 1.25
    for rank in range(ranks):
        for file in range(files):
            n = rank * files + file + 1
            characters.append({
                "id": f"p{n}", "name": f"Player {n}", "mechanism": "human", "color": colors[rank % 4], "group": f"Rank {rank + 1}",
                "link_colors": {"Head": "#d8a98a", "LeftHand": "#f0f0f0", "RightHand": "#f0f0f0", "LeftUpLeg": "#23262d", "RightUpLeg": "#23262d", "LeftLeg": "#23262d", "RightLeg": "#23262d"},
                "place": {"x": r(-distance * rank, 3), "y": r(interval * (file - (files - 1) / 2), 3)},
                "track": [{"id": f"k{n}", "motion": "human-walk", "start": 0, "length": 12, "offset": r(0.034 * rank, 3), "loop": True}]})
    characters.append({"id": "leader", "name": "Leader", "mechanism": "human", "color": "#d9a441", "place": {"x": 3, "y": 0},
                       "track": [{"id": "k0", "motion": "human-walk", "start": 0, "length": 12, "loop": True}]})
    return {"scenario": {"version": 1, "name": "band", "duration": 12, "characters": characters,
                         "camera": {"follow": "p45", "distance": 22, "azimuth": 0.75, "elevation": 0.42}}}


def push_test():
    forces = [60, 120, 240]
    return {"scenario": {
        "version": 1, "name": "walk with pushes", "duration": 12,
        "characters": [{"id": "human", "name": "Human", "mechanism": "human", "color": "#e6e6ea", "place": {"x": 0, "y": 0}, "track": [walk(1)]}],
        "events": [{"id": f"push{i + 1}", "type": "push", "time": 2 + 3 * i, "duration": 0.2, "character": "human", "link": "chest", "force": [0, f, 0]} for i, f in enumerate(forces)],
        "markers": [{"id": f"m{i + 1}", "time": 2 + 3 * i, "name": f"{f} N"} for i, f in enumerate(forces)],
        "camera": {"follow": "human", "distance": 5, "azimuth": 0.7, "elevation": 0.2}}}


def rag_dolls():
    colors = ["#e6e6ea", "#c9a57b", "#9fb7c9"]
    return {"scenario": {
        "version": 1, "name": "rag dolls", "duration": 5,
        "characters": [{"id": f"doll{i + 1}", "name": f"Doll {i + 1}", "mechanism": "human", "color": colors[i], "place": {"x": r(0.2 * i), "y": r(1.1 * (i - 1)), "z": r(1.3 + 0.35 * i), "heading": 60 * i},
                        "control": {"mode": "passive"}} for i in range(3)],
        "camera": {"follow": "doll2", "distance": 5, "azimuth": 0.8, "elevation": 0.3}}}


def bar():
    height, half = 2.5, 0.9
    frame = {"name": "bar", "joint": {"type": "fixed"}, "inertia": {"mass": 30, "centre": [0, 0, 1.2], "about_centre": [10, 10, 5, 0, 0, 0]},
             "shapes": [{"type": "capsule", "radius": 0.016, "half_length": half, "position": [0, 0, height], "rotation": turn("x", math.pi / 2), "collides": False},
                        post(0, -half, height), post(0, half, height)]}
    hang = {"id": "l1", "name": "Hanging", "mode": "replace", "ease_in": None, "ease_out": None, "joints": [
        {"link": "LeftArm", "keys": [{"time": 0, "value": [1.45, 0, 0]}]}, {"link": "RightArm", "keys": [{"time": 0, "value": [-1.45, 0, 0]}]},
        {"link": "Hips", "part": "position", "keys": [{"time": 0, "value": [0, 0, 1.4167]}]}]}
    end = 10.0
    grip = lambda n, side, sign: {"id": f"g{n}", "type": "grab", "time": 0, "character": "gymnast", "link": f"hand {side}", "point": [0, 0.07 * sign, 0],
                                  "other": "bar", "other_link": "bar", "at": [-0.0079, 0.2669 * sign, height], "rigid": False, "limit": 1500, "reach": 0.1}
    release = lambda n, side: {"id": f"r{n}", "type": "release", "time": end, "character": "gymnast", "link": f"hand {side}"}
    return {"scenario": {
        "version": 1, "name": "two hands on a bar", "duration": 14, "step": 0.001,
        "characters": [
            {"id": "gymnast", "name": "Gymnast", "mechanism": "gymnast", "color": "#b5483a", "place": {"x": 0, "y": 0, "z": 0},
             "control": {"mode": "track", "tracking": 1, "balance": 1, "assist_limit": 0, "swing": 45},
             "track": [walk(1, "hang", end, layers=[hang]), {"id": "k2", "motion": "stand", "start": end, "length": 4, "blend": 0.3, "loop": True}]},
            {"id": "bar", "name": "Bar", "mechanism": "bar", "control": {"mode": "passive"}, "color": "#8b93a1"}],
        "events": [grip(1, "left", 1), grip(2, "right", -1), release(1, "left"), release(2, "right")],
        "camera": {"follow": "", "distance": 5, "azimuth": 0.6, "elevation": 0.1}},
        "mechanisms": {"gymnast": {"person": 1.7}, "bar": {"format": "ugoki-mechanism", "version": 1, "name": "bar", "links": [frame]}},
        "motions": {"hang": {"still": "gymnast", "duration": 2, "rate": 60, "name": "Hang"},
                    "stand": {"operation": "retarget", "motion": "human-stand", "of": "human", "for": "gymnast", "name": "Stand"}}}


def rider():
    sit = {"id": "l1", "name": "Sitting", "mode": "replace", "ease_in": None, "ease_out": None, "joints": [
        {"link": "rider LeftUpLeg", "keys": [{"time": 0, "value": [0.85, -0.35, 0]}]}, {"link": "rider RightUpLeg", "keys": [{"time": 0, "value": [-0.85, -0.35, 0]}]},
        {"link": "rider LeftLeg", "keys": [{"time": 0, "value": [0.6]}]}, {"link": "rider RightLeg", "keys": [{"time": 0, "value": [0.6]}]},
        {"link": "rider LeftArm", "keys": [{"time": 0, "value": [-1.0, 0, -0.5]}]}, {"link": "rider RightArm", "keys": [{"time": 0, "value": [1.0, 0, 0.5]}]},
        {"link": "rider LeftForeArm", "keys": [{"time": 0, "value": [0.9]}]}, {"link": "rider RightForeArm", "keys": [{"time": 0, "value": [0.9]}]}]}
    part = lambda color, *names: {f"rider {n}": color for n in names}
    both = lambda *names: [side + n for side in ("Left", "Right") for n in names]
    colors = {**part("#39597d", "Chest", "Spine", "Spine1", *both("Shoulder", "Arm", "ForeArm")), **part("#e3ddd0", "Hips", *both("UpLeg", "Leg")),
              **part("#23262d", *both("Foot", "ToeBase")), **part("#d8a98a", "Neck", "Head", *both("Hand"))}
    return {"scenario": {
        "version": 1, "name": "rider", "duration": 12,
        "characters": [{"id": "pair", "name": "Mount and rider", "mechanism": "pair", "color": "#8a6a4a", "link_colors": colors, "track": [walk(1, "trot", 12, layers=[sit])]}],
        "camera": {"follow": "pair", "distance": 6.5, "azimuth": 1.0, "elevation": 0.18}},
        "mechanisms": {"mount": {"scale": "dog", "factor": 2.1}, "rider": {"person": 1.5},
                       "pair": {"combine": "mount", "at": "Chest", "with": "rider", "to": "Hips", "joint": "fixed", "position": [-0.1, 0, 0.54], "name": "mount and rider", "prefix": "rider "}},
        "motions": {"mount-trot": {"operation": "retarget", "motion": "dog-trot", "of": "dog", "for": "mount"},
                    "trot": {"still": "pair", "with": "mount-trot", "of": "mount", "name": "Trot with rider"}}}


def retargeting():
    cast = [("human", "Measured: human", "human", "human-walk", "#e6e6ea"), ("child", "Child", "child", "walk-child", "#c9a57b"),
            ("giant", "Giant", "giant", "walk-giant", "#9fb7c9"), ("dog", "Dog", "dog", "walk-dog", "#8fb08c")]
    return {"scenario": {
        "version": 1, "name": "retargeting", "duration": 10,
        "characters": [{"id": i, "name": n, "mechanism": m, "color": c, "place": {"x": 0, "y": r(1.5 * (1.5 - k))}, "track": [walk(k + 1, motion, 10)]} for k, (i, n, m, motion, c) in enumerate(cast)],
        "camera": {"follow": "child", "distance": 7, "azimuth": 0.8, "elevation": 0.22}},
        "mechanisms": {"child": {"person": 1.1}, "giant": {"person": 2.2}},
        "motions": {f"walk-{b}": {"operation": "retarget", "motion": "human-walk", "of": "human", "for": b} for b in ("child", "giant", "dog")}}


def paths():
    walks = {"walk-human": ("human", {"speed": 1.25, "path": [[2.5, 0.4], [5, -0.8], [7.5, 0.6], [10, 0]]}),
             "walk-child": ("child", {"speed": 0.8, "style": "proud", "path": [[2, 1.5], [4, 0.5], [4.5, -1.5], [3, -2.5]]}),
             "trot-dog": ("dog", {"kind": "trot", "speed": 1.8, "path": [[4, 0], [8, 0.6], [12, 2]]})}
    cast = [("human", "Human", "human", "#e6e6ea", 0, 0), ("child", "Child", "child", "#c9a57b", 1, 2.6), ("dog", "Dog", "dog", "#8fb08c", -0.5, -1.6)]
    motion_of = {mechanism: motion for motion, (mechanism, _) in walks.items()}
    length = {"human": 12, "child": 14, "dog": 11}
    return {"scenario": {
        "version": 1, "name": "paths", "duration": 14,
        "characters": [{"id": i, "name": n, "mechanism": m, "color": c, "place": {"x": x, "y": y}, "control": {"assist_limit": 0.5 if i == "dog" else 0},
                        "track": [{"id": f"k{k + 1}", "motion": motion_of[m], "start": 0, "length": length[i], "loop": False}]} for k, (i, n, m, c, x, y) in enumerate(cast)],
        "camera": {"follow": "human", "distance": 7, "azimuth": 0.9, "elevation": 0.35}},
        "mechanisms": {"child": {"person": 1.1}},
        "motions": {motion: {"gait": gait, "of": m, "name": motion.replace("-", " of the ").capitalize()} for motion, (m, gait) in walks.items()}}


def natural():
    with open("capture.bvh", encoding="utf-8") as file:
        text = file.read()
    clip = lambda n, motion: {"id": f"k{n}", "motion": motion, "start": 0, "length": 3.2, "loop": False}
    return {"scenario": {
        "version": 1, "name": "measured to natural", "duration": 3.2,
        "characters": [{"id": "measured", "name": "Measured", "mechanism": "capture-body", "color": "#b5483a", "place": {"x": 0, "y": 0.7}, "track": [clip(1, "capture")]},
                       {"id": "natural", "name": "Natural", "mechanism": "capture-body", "color": "#8fb08c", "place": {"x": 0, "y": -0.7}, "track": [clip(2, "corrected")]}],
        "camera": {"follow": "natural", "distance": 5, "azimuth": 1.2, "elevation": 0.15}},
        "measured": {"capture": {"file": "capture.bvh", "text": text}},
        "motions": {"corrected": {"operation": "correct", "motion": "capture", "of": "capture-body", "name": "Capture, corrected"}}}


def game():
    pin = {"name": "pin", "joint": {"type": "floating", "position": [0, 0, 0.2]}, "inertia": {"mass": 0.9, "centre": [0, 0, 0], "about_centre": [0.0125, 0.0125, 0.0016, 0, 0, 0]},
           "shapes": [{"type": "cylinder", "radius": 0.06, "half_length": 0.2, "position": [0, 0, 0], "friction": 0.6, "restitution": 0.2}]}
    places = [(0, 0), (0.3, 0.17), (0.3, -0.17), (0.6, 0.34), (0.6, 0), (0.6, -0.34)]
    pins = [{"id": f"pin{i + 1}", "name": f"Pin {i + 1}", "mechanism": "pin", "group": "Pins", "control": {"mode": "passive"}, "color": "#e6e6ea", "place": {"x": r(6.5 + x), "y": y, "z": 0.2}} for i, (x, y) in enumerate(places)]
    key = lambda code: {"type": "key", "key": code}
    return {"scenario": {
        "version": 1, "name": "game", "duration": 60,
        "characters": [{"id": "player", "name": "Player", "mechanism": "human", "color": "#39597d", "link_colors": {"Head": "#d8a98a", "LeftHand": "#d8a98a", "RightHand": "#d8a98a"}, "place": {"x": 0, "y": 0}, "track": [walk(1, "human-stand", 60)]},
                       {"id": "dog", "name": "Dog", "mechanism": "dog", "color": "#c9a57b", "place": {"x": 0.4, "y": -1.3}, "track": [walk(2, "dog-stand", 60)]},
                       {"id": "ball", "name": "Ball", "mechanism": "ball", "color": "#ff8a3d", "control": {"mode": "passive"}, "place": {"x": 2.4, "y": 0.05, "z": 0.11}}, *pins],
        "rules": [{"id": "r1", "on": True, "mode": "while", "if": [key("KeyW")], "do": {"type": "play", "character": "player", "motion": "human-walk", "speed": 1, "blend": 0.25, "loop": True}},
                  {"id": "r2", "on": True, "mode": "while", "if": [key("KeyD")], "do": {"type": "play", "character": "dog", "motion": "dog-trot", "speed": 1, "blend": 0.25, "loop": True}},
                  {"id": "r3", "on": True, "mode": "when", "if": [{"type": "touch", "character": "player", "link": "", "other": "ball", "other_link": ""}],
                   "do": {"type": "push", "character": "ball", "link": "", "force": [26, 0, 5], "duration": 0.1}},
                  {"id": "r4", "on": True, "mode": "when", "if": [key("Space"), {"type": "near", "character": "player", "other": "ball", "distance": 1.0}],
                   "do": {"type": "push", "character": "ball", "link": "", "force": [45, 0, 22], "duration": 0.1}}],
        "camera": {"follow": "player", "distance": 6.5, "azimuth": -2.5, "elevation": 0.3}},
        "mechanisms": {"pin": {"format": "ugoki-mechanism", "version": 1, "name": "pin", "links": [pin]}}}
