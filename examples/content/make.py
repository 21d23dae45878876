#!/usr/bin/env python3
"""Makes the contents of this folder that follow from formulas: linkages, robots, circuits, formations. Run it in this folder.

Every linkage is described in the position in which its loops are closed: the frame of each bar has its x axis along the bar, and the joint
frames are turned so that all coordinates are 0 in this position.
"""
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


# ---- Theo Jansen's leg

JANSEN = dict(a=38, b=41.5, c=39.3, d=40.1, e=55.8, f=39.4, g=36.7, h=65.7, i=49, j=50, k=61.9, l=7.8, m=15)


class Planar:
    """Links of a linkage in the x-z plane with hinges about y. Angles are measured from x towards z."""

    def __init__(self):
        self.links, self.loops, self.angle, self.origin = [], [], {}, {}

    def chassis(self, name, height, inertia, shapes):
        self.links.append({"name": name, "joint": {"type": "floating", "position": [0, 0, r(height)]}, "inertia": inertia, "shapes": shapes})
        self.angle[name], self.origin[name] = 0.0, (0.0, 0.0)

    def local(self, link, p):
        """A point of the plane in the frame of a link."""
        x, z = p[0] - self.origin[link][0], p[1] - self.origin[link][1]
        c, s = math.cos(self.angle[link]), math.sin(self.angle[link])
        return (c * x + s * z, -s * x + c * z)

    def add(self, name, parent, at, towards, y, mass_per_metre, radius, extra=(), foot=None, damping=0.0, depth=None):
        """A bar from `at` towards a point; `extra` are further bars (pairs of points) of the same rigid link."""
        angle = math.atan2(towards[1] - at[1], towards[0] - at[0])
        p = self.local(parent, at)
        level = y - (0 if depth is None else depth)
        joint = {"type": "revolute", "axis": [0, 1, 0], "position": rounded([p[0], level, p[1]]), "rotation": turn("y", -(angle - self.angle[parent]))}
        if damping:
            joint["dofs"] = [{"damping": damping}]
        self.angle[name], self.origin[name] = angle, at
        bars = [(at, towards), *extra]
        shapes, parts = [], []
        for p0, p1 in bars:
            a, b = self.local(name, p0), self.local(name, p1)
            shapes.append(capsule(a, b, radius))
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            parts.append((mass_per_metre * length, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, length))
        if foot:
            f = self.local(name, foot)
            shapes.append({"type": "sphere", "radius": 0.035, "position": rounded([f[0], 0, f[1]]), "friction": 1.0})
        mass = sum(q[0] for q in parts)
        cx, cz = sum(q[0] * q[1] for q in parts) / mass, sum(q[0] * q[2] for q in parts) / mass
        moment = sum(q[0] * (q[3] ** 2 / 12 + (q[1] - cx) ** 2 + (q[2] - cz) ** 2) for q in parts)
        small = mass * radius * radius
        self.links.append({"name": name, "parent": parent, "joint": joint,
                           "inertia": {"mass": r(mass), "centre": rounded([cx, 0, cz]), "about_centre": rounded([moment / 2 + small, moment + small, moment / 2 + small, 0, 0, 0])},
                           "shapes": shapes})

    def pin(self, name, link_a, link_b, p):
        a, b = self.local(link_a, p), self.local(link_b, p)
        self.loops.append({"name": name, "type": "revolute", "axis": [0, 1, 0],
                           "a": {"link": link_a, "position": rounded([a[0], 0, a[1]])}, "b": {"link": link_b, "position": rounded([b[0], 0, b[1]])}})


def jansen():
    size = 0.012  # m per unit
    d = {k: v * size for k, v in JANSEN.items()}
    rows = [(-0.42, 0.0), (-0.14, math.pi), (0.14, 0.0), (0.42, math.pi)]  # lateral position (m) and phase of each crank
    mechanism = Planar()
    base = d["a"]

    def leg_points(theta, side):
        """Points of a leg; side +1: to the left of the crank, -1: its mirror image."""
        angle = theta if side > 0 else math.pi - theta
        M = (d["m"] * math.cos(angle), d["m"] * math.sin(angle))
        B = (-d["a"], -d["l"])
        U = circles(M, d["j"], B, d["b"], -1)
        L = circles(M, d["k"], B, d["c"], 1)
        W = circles(U, d["e"], B, d["d"], -1)
        K = circles(W, d["f"], L, d["g"], -1)
        F = circles(K, d["h"], L, d["i"], -1)
        points = dict(M=M, B=B, U=U, L=L, W=W, K=K, F=F)
        return {n: (side * p[0], p[1]) for n, p in points.items()}

    start = 0.5
    lowest = min(leg_points(start + phase, side)["F"][1] for _, phase in rows for side in (1, -1))
    height = 0.035 - lowest + 0.002
    half = rows[-1][0] + 0.06
    chassis_shapes = [{"type": "box", "half_extents": [r(base), 0.02, 0.02], "position": [0, y, r(-d["l"])], "collides": False} for y in (-half, 0, half)]
    chassis_shapes += [{"type": "capsule", "radius": 0.018, "half_length": half, "position": rounded([x, 0, -d["l"] if x else 0]), "rotation": turn("x", math.pi / 2), "collides": False}
                       for x in (-base, 0, base)]
    mechanism.chassis("chassis", height, {"mass": 8, "centre": [0, 0, r(-d["l"])], "about_centre": [0.7, 0.5, 1.0, 0, 0, 0]}, chassis_shapes)
    # one shaft carries all cranks
    axle = []
    for y, phase in rows:
        a = start + phase
        axle.append({"type": "capsule", "radius": 0.016, "half_length": r(d["m"] / 2), "position": rounded([d["m"] / 2 * math.cos(a), y, d["m"] / 2 * math.sin(a)]),
                     "rotation": turn("y", math.pi / 2 - a), "collides": False})
    mechanism.links.append({"name": "crank", "parent": "chassis", "joint": {"type": "revolute", "axis": [0, 1, 0], "dofs": [{"armature": 0.02}]},
                            "inertia": {"mass": 1.5, "centre": [0, 0, 0], "about_centre": [0.1, 0.02, 0.1, 0, 0, 0]}, "shapes": axle})
    mechanism.angle["crank"], mechanism.origin["crank"] = 0.0, (0.0, 0.0)
    for row, (y, phase) in enumerate(rows):
        for side, word in ((1, "left"), (-1, "right")):
            p = leg_points(start + phase, side)
            n = lambda part: f"{part} {row + 1} {word}"
            mass, thick = 0.55, 0.014
            add = lambda name, parent, at, to, extra=(), foot=None, inner=False: mechanism.add(n(name), parent, at, to, y, mass, thick, extra, foot, 0.002, y if inner else None)
            add("upper rod", "crank", p["M"], p["U"])
            add("lower rod", "crank", p["M"], p["L"])
            add("rocker", "chassis", p["B"], p["U"], [(p["U"], p["W"]), (p["W"], p["B"])])
            add("strut", "chassis", p["B"], p["L"])
            add("tie", n("rocker"), p["W"], p["K"], inner=True)
            add("foot", n("strut"), p["L"], p["F"], [(p["F"], p["K"]), (p["K"], p["L"])], p["F"], inner=True)
            mechanism.pin(n("pin up"), n("upper rod"), n("rocker"), p["U"])
            mechanism.pin(n("pin down"), n("lower rod"), n("strut"), p["L"])
            mechanism.pin(n("pin tie"), n("tie"), n("foot"), p["K"])
    circuit = execution(
        [{"id": "forward", "type": "keyboard", "label": "W", "at": [480, 260], "parameters": {"key": "KeyW"}},
         {"id": "back", "type": "keyboard", "label": "S", "at": [480, 380], "parameters": {"key": "KeyS"}},
         {"id": "cruise", "type": "constant", "label": "speed without a key", "at": [480, 140], "parameters": {"value": 3}},
         {"id": "faster", "type": "gain", "at": [720, 260], "parameters": {"gain": 3}},
         {"id": "slower", "type": "gain", "at": [720, 380], "parameters": {"gain": -6}},
         {"id": "speed", "type": "sum", "at": [960, 260]},
         {"id": "motor", "type": "motor", "at": [1200, 160], "parameters": {"character": "walker", "link": "crank"}, "values": {"gain": 60}}],
        [("forward.pressed", "faster.in"), ("back.pressed", "slower.in"), ("cruise.out", "speed.in"), ("faster.out", "speed.in"), ("slower.out", "speed.in"),
         ("speed.out", "motor.velocity"), ("motor.torque", "dynamics.torque")],
        doc="A motor turns the crank; W makes it faster, S turns it back. All other joints are free.")
    return {
        "scenario": {"version": 1, "name": "jansen", "duration": 20, "step": 0.002,
                     "characters": [{"id": "walker", "name": "Walker", "mechanism": "jansen", "place": {"x": 0, "y": 0, "z": 0}, "control": {"mode": "passive"}, "color": "#d8b98a"}],
                     "camera": {"follow": "walker", "distance": 5, "azimuth": 1.2, "elevation": 0.25}},
        "mechanisms": {"jansen": {"format": "ugoki-mechanism", "version": 1, "name": "Theo Jansen's walker", "links": mechanism.links, "loops": mechanism.loops}},
        "circuit": circuit}


# ---- Andrews' squeezing mechanism

def andrews():
    """Twenty times larger and 120 times slower than the original: lengths times L, times T in time, so that forces are those of the
    original times L / T^2, moments times (L / T)^2."""
    L, T = 20.0, 120.0
    xa, ya, xb, yb, xc, yc = -.06934, -.00227, -.03635, .03273, .014, .072
    c0, l0, drive = 4530, .07785, .033
    d, da, e, ea, rr, ra, ss, sa, sb, sc, sd, ta, tb = .028, .0115, .02, .01421, .007, .00092, .035, .01874, .01043, .018, .02, .02308, .00916
    u, ua, ub, zf, zt, fa = .04, .01228, .00449, .02, .04, .01421
    beta, theta, gamma, phi, delta, omega, eps = (-0.0617138900142764496358948458001, 0, 0.455279819163070380255912382449, 0.222668390165885884674473185609,
                                                  0.487364979543842550225598953530, -0.222668390165885884674473185609, 1.23054744454982119249735015568)
    # joint angles at the start, in the order of the links below; angles of K4 and K6 are relative to K5 and K7
    names = ["K1", "K2", "K3", "K5", "K4", "K7", "K6"]
    parent = {"K2": "K1", "K4": "K5", "K6": "K7"}
    at = {"K1": (0, 0), "K2": (rr, 0), "K3": (xb, yb), "K5": (xa, ya), "K4": (zt, 0), "K7": (xa, ya), "K6": (0, -u)}
    first = {"K1": beta, "K2": theta, "K3": gamma, "K5": delta, "K4": phi, "K7": eps, "K6": omega}
    mass = {"K1": .04325, "K2": .00365, "K3": .02373, "K5": .07050, "K4": .00706, "K7": .05498, "K6": .00706}
    moment = {"K1": 2.194e-6, "K2": 4.410e-7, "K3": 5.255e-6, "K5": 1.169e-5, "K4": 5.667e-7, "K7": 1.912e-5, "K6": 5.667e-7}
    centre = {"K1": (ra, 0), "K2": (-da, 0), "K3": (sb, -sa), "K5": (ta, tb), "K4": (0, -(e - ea)), "K7": (ua, -ub), "K6": (zf - fa, 0)}
    drawn = {"K1": [((0, 0), (rr, 0))], "K2": [((0, 0), (-d, 0))], "K3": [((0, 0), (0, -ss)), ((0, -ss), (sd, -sc)), ((sd, -sc), (0, 0))],
             "K5": [((0, 0), (zt, 0)), ((0, 0), (ta, tb)), ((ta, tb), (zt, 0))], "K4": [((0, 0), (0, -e))],
             "K7": [((0, 0), (0, -u)), ((0, 0), (ua, -ub)), ((ua, -ub), (0, -u))], "K6": [((0, 0), (zf, 0))]}
    height = 1.7
    links = []
    for layer, n in enumerate(names):
        x, y = at[n]
        angle = first[n]
        c, s = math.cos(angle / 2), math.sin(angle / 2)
        if n in parent:
            joint = {"type": "revolute", "position": rounded([L * x, L * y, 0]), "rotation": rounded([c, 0, 0, s])}
        else:  # the plane of the mechanism is the x-z plane of the world: y becomes z
            h = math.sqrt(0.5)
            joint = {"type": "revolute", "position": rounded([L * x, 0, height + L * y]), "rotation": [r(v, 15) for v in (h * c, h * c, -h * s, h * s)]}
        joint["dofs"] = [{}]
        I = moment[n] * L * L
        shapes = []
        for p0, p1 in drawn[n]:
            dx, dy = L * (p1[0] - p0[0]), L * (p1[1] - p0[1])
            length = math.hypot(dx, dy)
            a = math.atan2(dy, dx)
            # the capsule's z axis along the bar: about y by 90 degrees, then about z by a
            q = [math.cos(a / 2) * math.sqrt(0.5), -math.sin(a / 2) * math.sqrt(0.5), math.cos(a / 2) * math.sqrt(0.5), math.sin(a / 2) * math.sqrt(0.5)]
            shapes.append({"type": "capsule", "radius": 0.016, "half_length": r(length / 2), "position": rounded([L * (p0[0] + p1[0]) / 2, L * (p0[1] + p1[1]) / 2, 0.03 * (layer - 3)]),
                           "rotation": rounded(q), "collides": False})
        link = {"name": n, "joint": joint, "inertia": {"mass": mass[n], "centre": rounded([L * centre[n][0], L * centre[n][1], 0]), "about_centre": [r(I / 2, 12), r(I / 2, 12), r(I, 12), 0, 0, 0]},
                "shapes": shapes}
        if n in parent:
            link["parent"] = parent[n]
        links.append(link)
    pin = lambda name, a, pa: {"name": name, "type": "revolute", "a": {"link": a, "position": rounded([L * pa[0], L * pa[1], 0])}, "b": {"link": "K2", "position": rounded([-L * d, 0, 0])}}
    loops = [pin("K2 to K3", "K3", (0, -ss)), pin("K2 to K4", "K4", (0, -e)), pin("K2 to K6", "K6", (zf, 0))]
    spring = {
        "name": "spring", "doc": "The spring between K3 and the frame: the moment about the hinge of K3.",
        "inputs": [{"name": "pose", "type": "pose", "to": "end.pose"}],
        "outputs": [{"name": "moment", "type": "scalar", "from": "moment.out"}],
        "lsis": [
            {"id": "end", "type": "transform point", "label": "end of the spring on K3", "at": [0, 0], "values": {"point": rounded([L * sd, -L * sc, 0])}},
            {"id": "stretch", "type": "subtract vectors", "label": "from the frame", "at": [220, 0], "values": {"b": rounded([L * xc, 0, height + L * yc])}},
            {"id": "length", "type": "length", "at": [440, 0]},
            {"id": "longer", "type": "subtract", "label": "elongation", "at": [660, 0], "values": {"b": r(L * l0)}},
            {"id": "force", "type": "gain", "label": "stiffness", "at": [880, 0], "parameters": {"gain": r(-c0 / (T * T))}},
            {"id": "along", "type": "direction", "at": [440, 140]},
            {"id": "pull", "type": "scale vector", "at": [1100, 60]},
            {"id": "arm", "type": "subtract vectors", "label": "lever arm", "at": [220, 220], "values": {"b": rounded([L * xb, 0, height + L * yb])}},
            {"id": "turn", "type": "cross product", "at": [1320, 120]},
            {"id": "parts", "type": "split vector", "at": [1540, 120]},
            {"id": "moment", "type": "gain", "label": "about the hinge", "at": [1760, 120], "parameters": {"gain": -1}}],
        "wires": [dict(zip(("from", "to"), w.split(" "))) for w in [
            "end.out stretch.a", "stretch.out length.in", "length.out longer.a", "longer.out force.in", "stretch.out along.in", "along.out pull.in", "force.out pull.factor",
            "end.out arm.a", "arm.out turn.a", "pull.out turn.b", "turn.out parts.in", "parts.y moment.in"]]}
    circuit = execution(
        [{"id": "K3", "type": "link pose", "at": [480, 200], "parameters": {"character": "squeezer", "link": "K3"}},
         {"id": "spring", "type": "spring", "at": [720, 200]},
         {"id": "spring motor", "type": "motor", "label": "spring on K3", "at": [960, 200], "parameters": {"character": "squeezer", "link": "K3"}},
         {"id": "drive", "type": "motor", "label": "drive", "at": [1200, 120], "parameters": {"character": "squeezer", "link": "K1"}, "values": {"force": r(drive * (L / T) ** 2, 12)}}],
        [("status.state", "K3.state"), ("K3.pose", "spring.pose"), ("spring.moment", "spring motor.force"), ("spring motor.torque", "drive.torque"), ("drive.torque", "dynamics.torque")],
        [spring], "Seven bodies and three loops with one degree of freedom. The circuit contains the drive and the spring.")
    for lsi in circuit["lsis"]:
        lsi["id"] = lsi["id"].replace(" ", "-")
    for wire in circuit["wires"]:
        for end in ("from", "to"):
            lsi, pin_name = wire[end].split(".")
            wire[end] = lsi.replace(" ", "-") + "." + pin_name
    return {
        "scenario": {"version": 1, "name": "andrews", "duration": 8, "step": 0.0005, "frame_rate": 60, "gravity": [0, 0, 0],
                     "characters": [{"id": "squeezer", "name": "Squeezer", "mechanism": "andrews", "control": {"mode": "passive"}, "color": "#8fb3c4",
                                     "link_colors": {"K1": "#ff8a3d", "K2": "#c9a57b", "K3": "#a7c3a0"}}],
                     "markers": [{"id": "m1", "time": 3.6, "name": "0.03 s"}],
                     "camera": {"follow": "", "distance": 4.5, "azimuth": 1.57, "elevation": 0.1}},
        "mechanisms": {"andrews": {"format": "ugoki-mechanism", "version": 1, "name": "Andrews' squeezing mechanism", "links": links, "loops": loops}},
        "circuit": circuit}


# ---- a robot of five bars

def five_bar():
    base, upper, lower, height = 0.18, 0.34, 0.5, 0.86  # half distance of the motors, lengths, m

    def solve(x, y):
        """Absolute angles of both upper arms and both forearms for the tool at x, y."""
        out = []
        for side in (-1, 1):
            elbow = circles((side * base, 0), upper, (x, y), lower, -side)
            out.append((math.atan2(elbow[1], elbow[0] - side * base), math.atan2(y - elbow[1], x - elbow[0])))
        return out

    def tool(t):
        a = 2 * math.pi * t
        return 0.2 * math.sin(a), 0.5 + 0.09 * math.sin(2 * a)

    start = solve(*tool(0))
    links = [{"name": "table", "joint": {"type": "fixed"}, "inertia": {"mass": 20, "centre": [0, 0, 0.5], "about_centre": [2, 2, 2, 0, 0, 0]},
              "shapes": [{"type": "box", "half_extents": [0.35, 0.12, 0.02], "position": [0, 0, height - 0.07], "collides": False},
                         {"type": "cylinder", "radius": 0.07, "half_length": r((height - 0.07) / 2), "position": [0, 0, r((height - 0.07) / 2)], "collides": False},
                         {"type": "cylinder", "radius": 0.055, "half_length": 0.03, "position": [-base, 0, height - 0.03], "collides": False},
                         {"type": "cylinder", "radius": 0.055, "half_length": 0.03, "position": [base, 0, height - 0.03], "collides": False},
                         {"type": "box", "half_extents": [0.45, 0.3, 0.012], "position": [0, 0.5, height - 0.12], "collides": False}]}]
    along = lambda length: {"type": "capsule", "radius": 0.018, "half_length": r(length / 2), "position": [r(length / 2), 0, 0], "rotation": turn("y", math.pi / 2), "collides": False}
    for side, word, (a, b), level in ((-1, "left", start[0], 0.0), (1, "right", start[1], 0.0)):
        links.append({"name": f"arm {word}", "parent": "table", "joint": {"type": "revolute", "position": [side * base, 0, height + level], "rotation": turn("z", a), "dofs": [{"effort": 40, "armature": 0.01, "damping": 0.02}]},
                      "inertia": bar_inertia(0.8, upper, 0.018), "shapes": [along(upper)]})
        shapes = [along(lower)]
        if word == "left":
            shapes.append({"type": "capsule", "radius": 0.008, "half_length": 0.045, "position": [lower, 0, -0.055], "collides": False})
        links.append({"name": f"forearm {word}", "parent": f"arm {word}", "joint": {"type": "revolute", "position": [upper, 0, 0.04], "rotation": turn("z", b - a), "dofs": [{"effort": 0, "damping": 0.002}]},
                      "inertia": bar_inertia(0.4, lower, 0.018), "shapes": shapes})
    loops = [{"name": "tool", "type": "revolute", "a": {"link": "forearm left", "position": [lower, 0, 0]}, "b": {"link": "forearm right", "position": [lower, 0, 0]}}]
    keys = {n: [] for n in ("arm left", "forearm left", "arm right", "forearm right")}
    period, count = 3.0, 48
    near = lambda x: math.remainder(x, 2 * math.pi)
    for i in range(count + 1):
        now = solve(*tool(i / count))
        for (a, b), (a0, b0), word in ((now[0], start[0], "left"), (now[1], start[1], "right")):
            t = round(period * i / count, 6)
            keys[f"arm {word}"].append({"time": t, "value": [r(near(a - a0), 6)]})
            keys[f"forearm {word}"].append({"time": t, "value": [r(near((b - a) - (b0 - a0)), 6)]})
    layer = {"id": "l1", "name": "Loop of eight", "mode": "replace", "ease_in": None, "ease_out": None, "joints": [{"link": n, "keys": k} for n, k in keys.items()]}
    return {
        "scenario": {"version": 1, "name": "five bars", "duration": 12, "step": 0.001,
                     "characters": [{"id": "robot", "name": "Robot", "mechanism": "five-bar", "color": "#c8ccd4", "link_colors": {"table": "#4a5058", "forearm left": "#ff8a3d", "forearm right": "#ff8a3d"},
                                     "track": [{"id": "k1", "motion": "still", "start": 0, "length": 12, "loop": True, "layers": [layer]}]}],
                     "camera": {"follow": "", "distance": 2.6, "azimuth": 0.9, "elevation": 0.6}},
        "mechanisms": {"five-bar": {"format": "ugoki-mechanism", "version": 1, "name": "robot of five bars", "links": links, "loops": loops}},
        "motions": {"still": {"still": "five-bar", "duration": period, "rate": 60, "name": "Loop of eight"}}}


# ---- a marching band

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


# ---- a controller of your own

def balance_gains(cart, pole, half, dt=0.01):
    """Gains of the linear quadratic regulator of a cart with a pole: [x, v, angle, rate] -> force. Riccati iteration."""
    g = 9.81
    # linear model with the angle from the upright position; uniform rod of mass `pole` and length 2 * half
    total, inertia = cart + pole, pole * half * half / 3 + pole * half * half
    det = total * inertia - (pole * half) ** 2
    A = [[1, dt, 0, 0], [0, 1, -dt * (pole * half) ** 2 * g / det, 0], [0, 0, 1, dt], [0, 0, dt * total * pole * g * half / det, 1]]
    B = [0, dt * inertia / det, 0, -dt * pole * half / det]
    Q, R = [40, 4, 60, 4], 0.01
    P = [[Q[i] if i == j else 0.0 for j in range(4)] for i in range(4)]
    for _ in range(40000):
        PA = [[sum(P[i][k] * A[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
        PB = [sum(P[i][k] * B[k] for k in range(4)) for i in range(4)]
        s = R + sum(B[i] * PB[i] for i in range(4))
        K = [sum(B[i] * PA[i][j] for i in range(4)) / s for j in range(4)]
        new = [[(Q[i] if i == j else 0) + sum(A[k][i] * PA[k][j] for k in range(4)) - K[i] * sum(B[k] * PA[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
        new = [[0.5 * (new[i][j] + new[j][i]) for j in range(4)] for i in range(4)]
        change = max(abs(new[i][j] - P[i][j]) for i in range(4) for j in range(4))
        P = new
        if change < 1e-10 * P[0][0]:
            break
    return K


def own_controller():
    cart, pole, half, height = 6.0, 1.2, 0.6, 0.5
    gains = balance_gains(cart, pole, half)
    I = pole * (2 * half) ** 2 / 12
    lean = 0.12
    links = [
        {"name": "rail", "joint": {"type": "fixed"}, "inertia": {"mass": 10, "centre": [0, 0, 0], "about_centre": [1, 1, 1, 0, 0, 0]},
         "shapes": [{"type": "box", "half_extents": [2.2, 0.03, 0.02], "position": [0, 0, height - 0.1], "collides": False},
                    {"type": "box", "half_extents": [0.03, 0.2, r((height - 0.1) / 2)], "position": [-2, 0, r((height - 0.1) / 2)], "collides": False},
                    {"type": "box", "half_extents": [0.03, 0.2, r((height - 0.1) / 2)], "position": [2, 0, r((height - 0.1) / 2)], "collides": False}]},
        {"name": "cart", "parent": "rail", "joint": {"type": "prismatic", "axis": [1, 0, 0], "position": [0, 0, height], "dofs": [{"lower": -2, "upper": 2, "effort": 200}]},
         "inertia": {"mass": cart, "centre": [0, 0, 0], "about_centre": [0.03, 0.06, 0.07, 0, 0, 0]}, "shapes": [{"type": "box", "half_extents": [0.17, 0.1, 0.06]}]},
        {"name": "pole", "parent": "cart", "joint": {"type": "revolute", "axis": [0, 1, 0], "position": [0, -0.13, 0.02], "rotation": turn("y", lean), "dofs": [{"damping": 0.002}]},
         "inertia": {"mass": pole, "centre": [0, 0, half], "about_centre": [r(I, 9), r(I, 9), 0.0003, 0, 0, 0]},
         "shapes": [{"type": "capsule", "radius": 0.025, "half_length": r(half - 0.025), "position": [0, 0, half], "collides": False},
                    {"type": "sphere", "radius": 0.06, "position": [0, 0, 2 * half]}]}]
    controller = {
        "name": "balance", "doc": "Your own LSI, made of other LSIs: the force that keeps the pole upright is a sum of four gains.",
        "inputs": [{"name": "x", "type": "scalar", "unit": "m", "to": "x.in"}, {"name": "v", "type": "scalar", "unit": "m/s", "to": "v.in"},
                   {"name": "angle", "type": "scalar", "unit": "rad", "to": "angle.in"}, {"name": "rate", "type": "scalar", "unit": "rad/s", "to": "rate.in"}],
        "outputs": [{"name": "force", "type": "scalar", "unit": "N", "from": "limit.out"}],
        "lsis": [{"id": n, "type": "gain", "at": [0, 110 * i], "parameters": {"gain": r(-k, 4)}} for i, (n, k) in enumerate(zip(("x", "v", "angle", "rate"), gains))]
        + [{"id": "sum", "type": "sum", "at": [260, 160]}, {"id": "limit", "type": "clamp", "at": [480, 160], "parameters": {"minimum": -200, "maximum": 200}}],
        "wires": [{"from": f"{n}.out", "to": "sum.in"} for n in ("x", "v", "angle", "rate")] + [{"from": "sum.out", "to": "limit.in"}]}
    who = {"character": "cart"}
    circuit = execution(
        [{"id": "joints", "type": "coordinates", "at": [480, 160], "parameters": who},
         {"id": "x", "type": "joint value", "at": [720, 60]}, {"id": "v", "type": "joint value", "at": [720, 170]},
         {"id": "from-start", "type": "joint value", "at": [720, 280], "parameters": {"index": 1}},
         {"id": "angle", "type": "add", "label": "angle from upright", "at": [940, 280], "values": {"b": lean}},
         {"id": "rate", "type": "joint value", "at": [720, 390], "parameters": {"index": 1}},
         {"id": "balance", "type": "balance", "at": [1160, 200]},
         {"id": "motor", "type": "motor", "at": [1300, 60], "parameters": {"character": "cart", "link": "cart"}}],
        [("status.state", "joints.state"), ("joints.q", "x.in"), ("joints.v", "v.in"), ("joints.q", "from-start.in"), ("from-start.out", "angle.a"), ("joints.v", "rate.in"),
         ("x.out", "balance.x"), ("v.out", "balance.v"), ("angle.out", "balance.angle"), ("rate.out", "balance.rate"), ("balance.force", "motor.force"), ("motor.torque", "dynamics.torque")],
        [controller], "State feedback: positions and velocities of the cart and the pole give the force on the cart.")
    push = lambda i, t, f: {"id": f"push{i}", "type": "push", "time": t, "duration": 0.15, "character": "cart", "link": "pole", "force": [f, 0, 0]}
    return {"scenario": {"version": 1, "name": "own LSI", "duration": 14,
                         "characters": [{"id": "cart", "name": "Cart", "mechanism": "cart", "control": {"mode": "passive"}, "color": "#c8ccd4", "link_colors": {"pole": "#ff8a3d", "rail": "#4a5058"}}],
                         "events": [push(1, 4, 6), push(2, 8, -10)],
                         "camera": {"follow": "", "distance": 4.6, "azimuth": 1.35, "elevation": 0.15}},
            "mechanisms": {"cart": {"format": "ugoki-mechanism", "version": 1, "name": "cart with a pole", "links": links}},
            "circuit": circuit}


# ---- people and animals

def walk(n, motion="human-walk", length=12, **fields):
    return {"id": f"k{n}", "motion": motion, "start": 0, "length": length, "loop": True, **fields}


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


def post(x, y, height):
    return {"type": "cylinder", "radius": 0.03, "half_length": r(height / 2), "position": [x, y, r(height / 2)], "collides": False}


def bar():
    height, half = 2.5, 0.9
    frame = {"name": "bar", "joint": {"type": "fixed"}, "inertia": {"mass": 30, "centre": [0, 0, 1.2], "about_centre": [10, 10, 5, 0, 0, 0]},
             "shapes": [{"type": "capsule", "radius": 0.016, "half_length": half, "position": [0, 0, height], "rotation": turn("x", math.pi / 2), "collides": False},
                        post(0, -half, height), post(0, half, height)]}
    # legs forward and back at the rhythm of the swing
    period = 2.35
    swing = [(0.0, 0.25), (0.25, -0.55), (0.5, 0.25), (0.75, 0.45), (1.0, 0.25)]
    legs = [{"link": f"{side}UpLeg", "keys": [{"time": r(period * t, 4), "value": [0, v, 0]} for t, v in swing]} for side in ("Left", "Right")]
    hang = {"id": "l1", "name": "Hanging", "mode": "replace", "ease_in": None, "ease_out": None, "joints": [
        {"link": "LeftArm", "keys": [{"time": 0, "value": [1.45, 0, 0]}]}, {"link": "RightArm", "keys": [{"time": 0, "value": [-1.45, 0, 0]}]},
        {"link": "Hips", "part": "position", "keys": [{"time": 0, "value": [0, 0, 1.31]}]}, *legs]}
    grip = lambda n, side, y: {"id": f"g{n}", "type": "grab", "time": 0, "character": "gymnast", "link": f"hand {side.lower()}", "point": [0, 0.07 if side == "Left" else -0.07, 0],
                               "other": "bar", "other_link": "bar", "at": [0, y, height], "rigid": False, "limit": 5000, "reach": 0.4}
    release = lambda n, side: {"id": f"r{n}", "type": "release", "time": 8, "character": "gymnast", "link": f"hand {side.lower()}"}
    return {"scenario": {
        "version": 1, "name": "two hands on a bar", "duration": 10,
        "characters": [
            {"id": "gymnast", "name": "Gymnast", "mechanism": "gymnast", "color": "#b5483a", "place": {"x": 0, "y": 0, "z": 0},
             "control": {"mode": "track", "tracking": 1, "balance": 0, "assist_limit": 0.01}, "track": [walk(1, "hang", 10, layers=[hang])]},
            {"id": "bar", "name": "Bar", "mechanism": "bar", "control": {"mode": "passive"}, "color": "#8b93a1"}],
        "events": [grip(1, "Left", 0.24), grip(2, "Right", -0.24), release(1, "Left"), release(2, "Right")],
        "camera": {"follow": "", "distance": 5, "azimuth": 0.6, "elevation": 0.1}},
        "mechanisms": {"gymnast": {"person": 1.7}, "bar": {"format": "ugoki-mechanism", "version": 1, "name": "bar", "links": [frame]}},
        "motions": {"hang": {"still": "gymnast", "duration": period, "rate": 60, "name": "Hang and swing"}}}


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


# ---- a component that can leave as an FMU

def oscillator():
    return {
        "name": "oscillator", "doc": "Van der Pol's oscillator: swings with an amplitude of about 2 from any start. Export it as an FMU, and take the FMU in its place.",
        "inputs": [], "outputs": [{"name": "angle", "type": "scalar", "from": "x.out"}],
        "lsis": [{"id": "x", "type": "integrator", "at": [720, 0], "parameters": {"initial": 0.2}}, {"id": "v", "type": "integrator", "at": [480, 0]},
                 {"id": "square", "type": "multiply", "at": [0, 140]}, {"id": "rest", "type": "subtract", "at": [160, 140], "values": {"a": 1}},
                 {"id": "pump", "type": "multiply", "at": [320, 140]}, {"id": "growth", "type": "gain", "at": [480, 140], "parameters": {"gain": 1.2}},
                 {"id": "spring", "type": "gain", "at": [0, 0], "parameters": {"gain": -6}}, {"id": "sum", "type": "add", "at": [320, 0]}],
        "wires": [dict(zip(("from", "to"), w.split(" "))) for w in ["v.out x.in", "x.out square.a", "x.out square.b", "square.out rest.b", "rest.out pump.a", "v.out pump.b", "pump.out growth.in",
                                                                    "x.out spring.in", "spring.out sum.a", "growth.out sum.b", "sum.out v.in"]]}


def fmu():
    """Two pendulums on one axle; a component of the circuit, made of integrators, computes the wanted angle."""
    bob = lambda name, y: {"name": name, "parent": "stand", "joint": {"type": "revolute", "axis": [0, 1, 0], "position": [0, y, 1.6], "dofs": [{"damping": 0.05}]},
                           "inertia": {"mass": 2, "centre": [0, 0, -0.8], "about_centre": [0.05, 0.05, 0.02, 0, 0, 0]},
                           "shapes": [{"type": "capsule", "radius": 0.015, "half_length": 0.4, "position": [0, 0, -0.4], "collides": False}, {"type": "sphere", "radius": 0.1, "position": [0, 0, -0.85], "collides": False}]}
    stand = {"name": "stand", "joint": {"type": "fixed"}, "inertia": {"mass": 20, "centre": [0, 0, 0.8], "about_centre": [5, 5, 5, 0, 0, 0]},
             "shapes": [{"type": "capsule", "radius": 0.02, "half_length": 0.55, "position": [0, 0, 1.6], "rotation": turn("x", math.pi / 2), "collides": False}, post(0, -0.55, 1.6), post(0, 0.55, 1.6)]}
    who = {"character": "pendulums"}
    circuit = execution(
        [{"id": "oscillator", "type": "oscillator", "at": [240, 400]},
         {"id": "wanted", "type": "gain", "label": "wanted angle", "at": [480, 400], "parameters": {"gain": 0.3}},
         {"id": "joints", "type": "coordinates", "at": [480, 220], "parameters": who},
         {"id": "angle", "type": "joint value", "at": [720, 220], "parameters": {"index": 0}},
         {"id": "error", "type": "subtract", "at": [940, 300]},
         {"id": "stiffness", "type": "gain", "at": [1120, 300], "parameters": {"gain": 60}},
         {"id": "motor", "type": "motor", "at": [1280, 160], "parameters": {**who, "link": "driven"}, "values": {"gain": 6, "velocity": 0}}],
        [("status.state", "joints.state"), ("joints.q", "angle.in"), ("oscillator.angle", "wanted.in"), ("wanted.out", "error.a"), ("angle.out", "error.b"), ("error.out", "stiffness.in"), ("stiffness.out", "motor.force"), ("motor.torque", "dynamics.torque")],
        [oscillator()], "A component gives the wanted angle of the first pendulum; the second one swings freely.")
    return {"scenario": {"version": 1, "name": "FMU inside", "duration": 20,
                         "characters": [{"id": "pendulums", "name": "Pendulums", "mechanism": "pendulums", "control": {"mode": "passive"}, "color": "#8fb3c4", "link_colors": {"driven": "#ff8a3d", "stand": "#4a5058"}}],
                         "events": [{"id": "push1", "type": "push", "time": 1, "duration": 0.2, "character": "pendulums", "link": "free", "force": [25, 0, 0]}],
                         "camera": {"follow": "", "distance": 4.5, "azimuth": 1.2, "elevation": 0.1}},
            "mechanisms": {"pendulums": {"format": "ugoki-mechanism", "version": 1, "name": "two pendulums", "links": [stand, bob("driven", -0.25), bob("free", 0.25)]}},
            "circuit": circuit}


if __name__ == "__main__":
    for made in (jansen, andrews, five_bar, band, own_controller, push_test, rag_dolls, bar, rider, retargeting, paths, natural, game, fmu):
        name = {"own_controller": "own-lsi", "push_test": "push-test", "rag_dolls": "rag-dolls", "five_bar": "five-bar"}.get(made.__name__, made.__name__)
        write(name, made())
    write("../fmu/oscillator", {"version": 2, **oscillator()})
