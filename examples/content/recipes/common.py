"""Parts that several contents use: writing, numbers, circuits, bars, clips."""
import json
import math


def write(name, content):
    """Writes NAME.json with one line for each character, event, wire and so on."""

    def flat(value, depth):
        if depth == 0 or not isinstance(value, (dict, list)) or not value:
            return json.dumps(value, ensure_ascii=False)
        pad = " " * (4 - depth)
        if isinstance(value, dict):
            inner = [f"{pad}{json.dumps(k)}: {flat(v, depth - 1)}" for k, v in value.items()]
            return "{\n" + ",\n".join(inner) + "\n" + pad[1:] + "}"
        return "[\n" + ",\n".join(pad + flat(v, 0) for v in value) + "\n" + pad[1:] + "]"

    text = flat(content, 3)
    assert json.loads(text) == content
    with open(f"{name}.json", "w", encoding="utf-8") as file:
        file.write(text + "\n")


def r(x, digits=9):
    return round(x, digits) + 0.0


def rounded(p):
    return [r(v) for v in p]


def circles(a, ra, b, rb, side):
    """Intersection of two circles; side +1: left of the direction from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    d = math.hypot(dx, dy)
    along = (ra * ra - rb * rb + d * d) / (2 * d)
    across = math.sqrt(ra * ra - along * along)
    return (a[0] + (along * dx - side * across * dy) / d, a[1] + (along * dy + side * across * dx) / d)


# ---- circuits

def execution(lsis, wires, circuits=None, doc=""):
    """An execution circuit around the given LSIs: `state` is status.state, drives are wired to dynamics.torque."""
    base = [
        {"id": "event", "type": "event", "at": [0, 0]},
        {"id": "status", "type": "status", "at": [240, 0]},
        {"id": "collision", "type": "collision analysis", "at": [240, 160]},
        {"id": "dynamics", "type": "dynamics", "at": [1440, 0]},
        {"id": "display", "type": "display", "at": [1680, 0], "every": 0},
    ]
    links = ["event.events dynamics.events", "event.events status.events", "status.state collision.state", "status.state dynamics.state",
             "collision.contacts dynamics.contacts", "dynamics.next status.next", "status.state display.state"]
    circuit = {
        "version": 2, "name": "execution", "doc": doc,
        "inputs": [{"name": "live", "type": "event", "to": "event.live"}],
        "outputs": [{"name": n, "type": t, "from": f} for n, t, f in [
            ("state", "state", "status.state"), ("contacts", "contacts", "dynamics.contacts"), ("events", "event", "event.events"),
            ("poses", "pose", "display.poses"), ("characters", "joint values", "display.characters"),
            ("measures", "joint values", "display.measures")]],
        "lsis": base + lsis,
        "wires": [dict(zip(("from", "to"), w.split(" "))) for w in links] + [{"from": a, "to": b} for a, b in wires],
    }
    if circuits:
        circuit["circuits"] = circuits
    return circuit


# ---- bars

def turn(axis, angle):
    """Quaternion of a rotation about x, y or z."""
    q = [math.cos(angle / 2), 0, 0, 0]
    q["xyz".index(axis) + 1] = math.sin(angle / 2)
    return rounded(q)


def bar_inertia(mass, length, radius):
    across = mass * (length * length / 12 + radius * radius / 4)
    return {"mass": r(mass), "centre": rounded([length / 2, 0, 0]), "about_centre": rounded([mass * radius * radius / 2, across, across, 0, 0, 0])}


def capsule(a, b, radius, y=0.0, collides=False):
    """Capsule between two points of the plane of the link (x, z), at depth y."""
    dx, dz = b[0] - a[0], b[1] - a[1]
    length = math.hypot(dx, dz)
    return {"type": "capsule", "radius": radius, "half_length": r(length / 2), "position": rounded([(a[0] + b[0]) / 2, y, (a[1] + b[1]) / 2]),
            "rotation": turn("y", math.atan2(dx, dz)), "collides": collides}


# ---- clips and posts

def walk(n, motion="human-walk", length=12, **fields):
    return {"id": f"k{n}", "motion": motion, "start": 0, "length": length, "loop": True, **fields}


def post(x, y, height):
    return {"type": "cylinder", "radius": 0.03, "half_length": r(height / 2), "position": [x, y, r(height / 2)], "collides": False}
