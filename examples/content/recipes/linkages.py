"""Linkages and a robot with closed loops.

Every linkage is described in the position in which its loops are closed: the frame of each bar has its x axis along the bar, and the joint
frames are turned so that all coordinates are 0 in this position.
"""
import math

from recipes.common import bar_inertia, capsule, circles, execution, r, rounded, turn


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
