"""Circuits: a controller, and a component that can leave as an FMU."""
import math

from recipes.common import execution, post, r, turn


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
