"""A rider on a walking mount: the seat and the feet in stirrups are held by grips, the hands hold reins."""
import math

from recipes.common import r, rounded
from recipes.bicycle import rod
from recipes.person import BALL, arm_keys, ball, reach

FACTOR = 2.1  # of the dog's lengths
CHEST, BIT = (0.494, 0.966), (1.52, 0.07, 1.30)  # m, world, at the start of the gait: the mount's chest (x, z), and the left end of the bit
SEAT = (0.394, 1.51)  # m, world: pelvis of the rider (x, z)
SADDLE = (-0.1, 0.42)  # m: in the frame of the chest
PALM = (0.42, 0.16, 0.12)  # m: left palm in the frame of the rider's pelvis
THIGH, KNEE, ANKLE = [0.5, -0.6, 0.0], 0.8, [-0.3, -0.15, 0.0]
PIECES = 4  # of each rein


def stirrup(side):
    """Strap and stirrup under the saddle. The strap swings about its upper end; the foot stands on its lower end."""
    foot = ball(THIGH, KNEE, ANKLE)
    offset = (SEAT[0] - CHEST[0] - SADDLE[0], 0, SEAT[1] - CHEST[1] - SADDLE[1])
    low = [foot[0] + offset[0], (foot[1] + offset[1]), foot[2] + offset[2]]
    top = [low[0] - 0.02, 0.8 * low[1], -0.02]
    mirrored = lambda p: rounded([p[0], p[1] * side, p[2]])
    down = [a - b for a, b in zip(low, top)]
    word = "left" if side > 0 else "right"
    joint = {"type": "universal", "axis": [1, 0, 0], "axis2": [0, 1, 0], "position": mirrored(top), "dofs": [{"effort": 0, "damping": 1}] * 2}
    return {"name": f"stirrup {word}", "parent": "saddle", "joint": joint, "inertia": {"mass": 1.0, "centre": mirrored([0.8 * c for c in down]), "about_centre": [0.02, 0.02, 0.005, 0, 0, 0]},
            "shapes": [rod([0, 0, 0], mirrored(down), 0.03)]}, mirrored(down)


def rein(side, start, end):
    """A chain of rods with universal joints from the bit to the hand, with some slack: its middle hangs down at the start."""
    mirrored = lambda p: [p[0], p[1] * side, p[2]]
    point = lambda k: mirrored([a + (b - a) * k / PIECES - (0.2 * math.sin(math.pi * k / PIECES) if i == 2 else 0) for i, (a, b) in enumerate(zip(start, end))])
    links = []
    for k in range(PIECES):
        d = [b - a for a, b in zip(point(k), point(k + 1))]
        before = [b - a for a, b in zip(point(k - 1), point(k))] if k else [0, 0, 0]
        joint = {"type": "floating", "position": [0, 0, 0]} if k == 0 else {"type": "spherical", "position": rounded(before), "dofs": [{"damping": 0.02}] * 3}
        links.append({"name": f"rein {k + 1}", **({"parent": f"rein {k}"} if k else {}), "joint": joint,
                      "inertia": {"mass": 0.1, "centre": rounded([c / 2 for c in d]), "about_centre": [0.001, 0.001, 0.001, 0, 0, 0]}, "shapes": [rod([0, 0, 0], d, 0.01)]})
    return {"format": "ugoki-mechanism", "version": 1, "name": "rein", "links": links}, rounded(d)


def riding():
    duration = 20.0
    arm = reach(PALM, 0, [-0.6, 0.3, -0.6, 1.2])
    legs = [{"link": f"{word}{part}", "keys": [{"time": 0, "value": v}]} for word, s in (("Left", 1), ("Right", -1))
            for part, v in (("UpLeg", [r(THIGH[0] * s), THIGH[1], r(THIGH[2] * s)]), ("Leg", [KNEE]), ("Foot", [r(ANKLE[0] * s), ANKLE[1], r(ANKLE[2] * s)]))]
    sit = {"id": "l1", "name": "Sitting", "mode": "replace", "ease_in": None, "ease_out": None,
           "joints": legs + arm_keys(arm) + [{"link": "Hips", "part": "position", "keys": [{"time": 0, "value": [SEAT[0], 0, SEAT[1]]}]}]}
    saddle = {"name": "saddle", "joint": {"type": "floating", "position": [0, 0, 0]}, "inertia": {"mass": 6, "centre": [0, 0, 0], "about_centre": [0.1, 0.1, 0.1, 0, 0, 0]},
              "shapes": [{"type": "box", "half_extents": [0.2, 0.15, 0.04], "position": [0, 0, 0], "collides": False}]}
    straps = [stirrup(1), stirrup(-1)]
    hand = [SEAT[0] + PALM[0], PALM[1], SEAT[1] + PALM[2]]
    reins = {word: rein(s, BIT, hand) for word, s in (("left", 1), ("right", -1))}
    chain = [{"id": f"rein-{word}", "name": f"Rein {word}", "mechanism": f"rein-{word}", "color": "#4a3424", "place": {"x": BIT[0], "y": BIT[1] * s, "z": BIT[2]}, "control": {"mode": "passive"}}
             for word, s in (("left", 1), ("right", -1))]
    grab = lambda n, who, link, point, other, other_link, at=None, rigid=False, limit=5000: {
        "id": f"g{n}", "type": "grab", "time": 0, "character": who, "link": link, "point": point, "other": other, "other_link": other_link, "at": at, "rigid": rigid, "limit": limit, "reach": 2}
    events = [grab(1, "rider", "pelvis", [0, 0, -0.1], "mount", "saddle", rigid=True)]
    for n, (word, s) in enumerate((("left", 1), ("right", -1))):
        side = lambda p: [p[0], p[1] * s, p[2]]
        events += [grab(2 + 3 * n, "rider", f"foot {word}", side(BALL), "mount", f"stirrup {word}", straps[n][1]),
                   grab(3 + 3 * n, f"rein-{word}", "rein 1", [0, 0, 0], "mount", "Head"),
                   grab(4 + 3 * n, "rider", f"hand {word}", [0, 0.07 * s, 0], f"rein-{word}", f"rein {PIECES}", reins[word][1])]
    both = lambda *names: [side + n for side in ("Left", "Right") for n in names]
    colors = {**{n: "#39597d" for n in ("Chest", "Spine", "Spine1", *both("Shoulder", "Arm", "ForeArm"))}, **{n: "#e3ddd0" for n in ("Hips", *both("UpLeg"))},
              **{n: "#23262d" for n in both("Leg", "Foot", "ToeBase")}}
    return {"scenario": {
        "version": 1, "name": "rider with reins", "duration": duration,
        "characters": [
            {"id": "mount", "name": "Mount", "mechanism": "mount", "color": "#8a6a4a", "link_colors": {"saddle": "#4a3424", "stirrup left": "#4a3424", "stirrup right": "#4a3424"}, "place": {"x": 0, "y": 0},
             "control": {"mode": "track", "assist_limit": 0.1}, "track": [{"id": "k1", "motion": "walk", "start": 0, "length": duration, "loop": False}]},
            {"id": "rider", "name": "Rider", "mechanism": "rider", "color": "#d8a98a", "link_colors": colors, "place": {"x": SEAT[0], "y": 0}, "control": {"mode": "track", "assist_limit": 0},
             "track": [{"id": "k2", "motion": "sit", "start": 0, "length": duration, "loop": True, "layers": [sit]}]}, *chain],
        "events": events,
        "camera": {"follow": "mount", "distance": 6.5, "azimuth": 1.0, "elevation": 0.18}},
        "mechanisms": {"horse": {"scale": "dog", "factor": FACTOR}, "rider": {"person": 1.75},
                       "tack": {"format": "ugoki-mechanism", "version": 1, "name": "saddle and stirrups", "links": [saddle, *(s[0] for s in straps)]},
                       "mount": {"combine": "horse", "at": "Chest", "with": "tack", "to": "saddle", "joint": "fixed", "position": [SADDLE[0], 0, SADDLE[1]], "name": "mount with a saddle"},
                       **{f"rein-{word}": m[0] for word, m in reins.items()}},
        "motions": {"walk": {"gait": {"kind": "walk", "speed": 1.2, "seconds": duration}, "of": "mount", "name": "Walk of the mount"},
                    "sit": {"still": "rider", "duration": 2, "rate": 60, "name": "Sit"}}}
