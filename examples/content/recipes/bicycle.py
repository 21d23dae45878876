"""A cyclist on a stand: closed loops through both legs and both arms."""
import math

from recipes.common import r, rounded, turn
from recipes.person import BALL, HIP, PALM, arm_keys, leg, reach

AXLE, CRANK = (0.0, 0.28), 0.17  # bottom bracket (x, z) and length of the crank, m
HUB, RADIUS = (-0.42, 0.34), 0.33  # rear hub and radius of the wheels, m
PELVIS = (-0.225, 1.06)  # m
BARS = (0.43, 0.22, 1.03)  # left grip of the handlebar, m
RATIO = 2.6  # turns of the wheel for one of the crank
SPINE = 0.27  # rad: pitch of each of three joints


def rod(a, b, radius):
    """Capsule between two points of space."""
    d = [q - p for p, q in zip(a, b)]
    length = math.sqrt(sum(c * c for c in d))
    # the shortest turn from z to the direction of the rod
    w, x, y = length + d[2], -d[1], d[0]
    size = math.sqrt(w * w + x * x + y * y)
    rotation = rounded([w / size, x / size, y / size, 0]) if size > 1e-9 else [0, 1, 0, 0]
    return {"type": "capsule", "radius": radius, "half_length": r(length / 2), "position": rounded([(p + q) / 2 for p, q in zip(a, b)]), "rotation": rotation, "collides": False}


def wheel(hub, spokes):
    """Tyre of 24 straight pieces with some spokes, around a point of the plane y = 0."""
    at = lambda k, n: [hub[0] + RADIUS * math.cos(2 * math.pi * k / n), 0, hub[1] + RADIUS * math.sin(2 * math.pi * k / n)]
    return [rod(at(k, 24), at(k + 1, 24), 0.016) for k in range(24)] + [rod([hub[0], 0, hub[1]], at(k, spokes), 0.003) for k in range(spokes)]


def bicycle():
    low, top, head, fork = (0, 0, AXLE[1]), (-0.19, 0, 0.9), (0.34, 0, 0.88), (0.54, 0, HUB[1])
    rear = lambda y: (HUB[0], y, HUB[1])
    tubes = [rod(low, top, 0.016), rod(top, head, 0.015), rod(low, head, 0.017), rod(head, fork, 0.014), rod(head, (0.32, 0, 1.01), 0.013)]
    tubes += [rod(rear(y), end, 0.009) for y in (-0.06, 0.06) for end in ((0, 0, AXLE[1]), (-0.17, 0, 0.83))]
    tubes += [rod((0.32, 0, 1.01), (0.36, BARS[1] * s, 1.02), 0.012) for s in (-1, 1)] + [rod((0.36, BARS[1] * s, 1.02), (0.47, BARS[1] * s, 1.025), 0.014) for s in (-1, 1)]
    tubes += [{"type": "box", "half_extents": [0.13, 0.06, 0.02], "position": [-0.23, 0, 0.93], "collides": False}]
    tubes += wheel((fork[0], fork[2]), 10)
    tubes += [rod(rear(0.06 * s), (HUB[0] + x, 0.26 * s, 0.015), 0.012) for s in (-1, 1) for x in (-0.16, 0.16)]
    small = lambda mass, size: {"mass": mass, "centre": [0, 0, 0], "about_centre": [size, size, size, 0, 0, 0]}
    side = lambda s: HIP[1] * s
    crank = [rod([0, -0.09, 0], [0, 0.09, 0], 0.012), {"type": "cylinder", "radius": 0.09, "half_length": 0.004, "position": [0, -0.05, 0], "rotation": turn("x", math.pi / 2), "collides": False}]
    crank += [rod([0, side(s) * 0.75, 0], [CRANK * s, side(s) * 0.75, 0], 0.012) for s in (1, -1)]
    pedal = {"type": "box", "half_extents": [0.05, 0.045, 0.009], "position": [0, 0, -0.01], "collides": False}
    hinge = lambda at, damping=0.0: {"type": "revolute", "axis": [0, 1, 0], "position": rounded(at), "dofs": [{"effort": 0, "damping": damping}]}
    return [
        {"name": "frame", "joint": {"type": "fixed"}, "inertia": {"mass": 9, "centre": [0, 0, 0.6], "about_centre": [0.8, 1.2, 0.6, 0, 0, 0]}, "shapes": tubes},
        {"name": "crank", "parent": "frame", "joint": hinge([AXLE[0], 0, AXLE[1]], 0.05), "inertia": small(0.9, 0.006), "shapes": crank},
        {"name": "pedal left", "parent": "crank", "joint": hinge([CRANK, side(1), 0], 0.002), "inertia": small(0.2, 0.0003), "shapes": [pedal]},
        {"name": "pedal right", "parent": "crank", "joint": hinge([-CRANK, side(-1), 0], 0.002), "inertia": small(0.2, 0.0003), "shapes": [pedal]},
        {"name": "wheel", "parent": "frame", "joint": hinge([HUB[0], 0, HUB[1]], 0.35), "inertia": {"mass": 4, "centre": [0, 0, 0], "about_centre": [0.2, 0.4, 0.2, 0, 0, 0]}, "shapes": wheel((0, 0), 10)}]


def turns(t):
    """Angle of the crank, rad: it starts slowly and reaches 72 turns a minute after 4 s."""
    rate, begin, rise = 2 * math.pi * 1.2, 0.12, 4.0
    s = min(t, rise) / rise
    # the rate grows as a smooth step from `begin` to 1
    return rate * (begin * min(t, rise) + (1 - begin) * rise * (s ** 3 - s ** 4 / 2) + max(0.0, t - rise))


def cycling():
    duration, names = 10.0, ("LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot", "crank", "pedal left", "pedal right", "wheel")
    keys = {n: [] for n in names}
    hip = (PELVIS[0] + HIP[0], PELVIS[1] + HIP[2])
    key = lambda name, t, *value: keys[name].append({"time": t, "value": [r(v, 4) for v in value]})
    t, count, step = 0.0, 0, 2 * math.pi / 16
    while t <= duration:
        phi = turns(t)
        key("crank", t, phi)
        key("wheel", t, RATIO * phi)
        for word, side in (("Left", 1), ("Right", -1)):
            # positive turns about y lead the front of the crank down; the toes point down most at the bottom
            pedal = (AXLE[0] + side * CRANK * math.cos(phi), AXLE[1] - side * CRANK * math.sin(phi))
            pitch = 0.30 + 0.16 * math.sin(phi + (0 if side > 0 else math.pi) - 2.6)
            thigh, knee, ankle = leg(pedal, pitch, hip)
            key(f"{word}UpLeg", t, 0, thigh, 0)
            key(f"{word}Leg", t, knee)
            key(f"{word}Foot", t, 0, ankle, 0)
            key(f"pedal {word.lower()}", t, pitch - phi)
        count += 1
        low, high = t, t + 2.0  # the time at which the crank has turned by another sixteenth
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if turns(middle) < count * step else (low, middle)
        t = r(low, 4)
    arm = reach([BARS[0] - PELVIS[0], BARS[1], BARS[2] - PELVIS[1]], SPINE, [-0.8, 0.3, -0.9, 0.3])
    lean = [{"link": n, "keys": [{"time": 0, "value": [0, SPINE, 0]}]} for n in ("Spine", "Spine1", "Chest")] + [{"link": "Head", "keys": [{"time": 0, "value": [0, -0.5, 0]}]}]
    layer = {"id": "l1", "name": "Pedalling", "mode": "replace", "ease_in": None, "ease_out": None,
             "joints": [{"link": n, "keys": k} for n, k in keys.items()] + lean + arm_keys(arm)}
    foot = lambda word: {"name": f"foot {word}", "type": "weld", "a": {"link": f"{word.capitalize()}Foot", "position": list(BALL)}, "b": {"link": f"pedal {word}"}}
    hand = lambda word, s: {"name": f"hand {word}", "type": "ball", "a": {"link": f"{word.capitalize()}Hand", "position": [0, PALM[1] * s, 0]}, "b": {"link": "frame", "position": [BARS[0], BARS[1] * s, BARS[2]]}}
    both = lambda *parts: [side + n for side in ("Left", "Right") for n in parts]
    colors = {**{n: "#d9a441" for n in ("Chest", "Spine", "Spine1", *both("Shoulder", "Arm"))}, **{n: "#23262d" for n in ("Hips", *both("UpLeg", "Foot", "ToeBase"))},
              **{n: "#d8a98a" for n in ("Neck", "Head", *both("ForeArm", "Hand", "Leg"))}, "frame": "#39597d", "crank": "#8b93a1", "wheel": "#4a5058", "pedal left": "#4a5058", "pedal right": "#4a5058"}
    return {"scenario": {
        "version": 1, "name": "cyclist", "duration": duration,
        "characters": [{"id": "cyclist", "name": "Cyclist", "mechanism": "cyclist", "color": "#39597d", "link_colors": colors,
                        "track": [{"id": "k1", "motion": "pedal", "start": 0, "length": duration, "loop": False, "layers": [layer]}]}],
        "camera": {"follow": "", "distance": 3.4, "azimuth": 1.35, "elevation": 0.12}},
        "mechanisms": {"person": {"person": 1.75}, "bicycle": {"format": "ugoki-mechanism", "version": 1, "name": "bicycle on a stand", "links": bicycle()},
                       "cyclist": {"combine": "bicycle", "at": "frame", "with": "person", "to": "Hips", "joint": "fixed", "position": [PELVIS[0], 0, PELVIS[1]], "name": "cyclist",
                                   "loops": [{"name": "chain", "type": "gear", "a": {"link": "wheel"}, "b": {"link": "crank"}, "polynomial": [0, RATIO, 0, 0, 0]},
                                             foot("left"), foot("right"), hand("left", 1), hand("right", -1)]}},
        "motions": {"pedal": {"still": "cyclist", "duration": duration, "rate": 60, "cyclic": False, "name": "Pedalling"}}}
