"""A doll whose surface is a glTF skin: a mesh of rings around its bones, with weights, a texture, and a motion in the file."""
import base64
import json
import math
import struct
import zlib

FORMATS = {"f": 5126, "B": 5121, "H": 5123}
SIDES = 18  # vertices of a ring, of which the first and the last are at the same place

# name, parent, place in the world at rest (m; Y up, Z forward, left is +X)
BONES = [("Hips", None, (0, 0.95, 0)), ("Spine", "Hips", (0, 1.07, 0)), ("Chest", "Spine", (0, 1.22, 0)),
         ("Neck", "Chest", (0, 1.46, 0)), ("Head", "Neck", (0, 1.56, 0.01)), ("HeadEnd", "Head", (0, 1.79, 0.02))]
for side, s in (("Left", 1), ("Right", -1)):
    BONES += [(side + "Shoulder", "Chest", (0.04 * s, 1.42, 0)), (side + "Arm", side + "Shoulder", (0.18 * s, 1.43, 0)),
              (side + "ForeArm", side + "Arm", (0.46 * s, 1.43, 0)), (side + "Hand", side + "ForeArm", (0.71 * s, 1.43, 0)),
              (side + "HandEnd", side + "Hand", (0.87 * s, 1.43, 0)), (side + "UpLeg", "Hips", (0.09 * s, 0.92, 0)),
              (side + "Leg", side + "UpLeg", (0.09 * s, 0.5, 0)), (side + "Foot", side + "Leg", (0.09 * s, 0.09, 0)),
              (side + "ToeBase", side + "Foot", (0.09 * s, 0.03, 0.13)), (side + "ToeEnd", side + "ToeBase", (0.09 * s, 0.02, 0.21))]
INDEX = {name: i for i, (name, _, _) in enumerate(BONES)}


def smooth(t):
    t = min(1, max(0, t))
    return t * t * (3 - 2 * t)


class Surface:
    """Vertices, triangles and weights; quadrants of the texture: 0 knitted, 1 trousers, 2 face and skin, 3 shoes."""

    def __init__(self):
        self.positions, self.uvs, self.joints, self.weights, self.triangles = [], [], [], [], []

    def vertex(self, p, uv, quadrant, shares):
        self.positions.append(p)
        margin = 0.02
        u, v = (margin + (1 - 2 * margin) * x for x in uv)
        self.uvs.append((0.5 * (quadrant % 2) + 0.5 * u, 0.5 * (quadrant // 2) + 0.5 * v))
        shares = sorted(((w, name) for name, w in shares.items() if w > 0.004), reverse=True)[:4]
        whole = [round(255 * w / sum(w for w, _ in shares)) for w, _ in shares]
        whole[0] += 255 - sum(whole)
        self.joints.append([INDEX[name] for _, name in shares] + [0] * (4 - len(shares)))
        self.weights.append(whole + [0] * (4 - len(shares)))
        return len(self.positions) - 1

    def tube(self, rings, quadrant, weights, round_ends=(True, True)):
        """rings: centre, two half axes as vectors, place along the tube 0 ... 1. weights(place of the centre): shares of bones."""
        rows = []
        for i, (centre, a, b, along) in enumerate(rings):
            row = []
            for k in range(SIDES):
                angle = 2 * math.pi * k / (SIDES - 1)
                c, s = math.cos(angle), math.sin(angle)
                p = tuple(x + c * u + s * v for x, u, v in zip(centre, a, b))
                row.append(self.vertex(p, (k / (SIDES - 1), along), quadrant, weights(centre)))
            rows.append(row)
        for low, high in zip(rows, rows[1:]):
            for k in range(SIDES - 1):
                self.triangles += [(low[k], low[k + 1], high[k + 1]), (low[k], high[k + 1], high[k])]
        for row, ring, closed, first in ((rows[0], rings[0], round_ends[0], True), (rows[-1], rings[-1], round_ends[1], False)):
            if not closed:
                continue
            tip = self.vertex(ring[0], (0.5, ring[3]), quadrant, weights(ring[0]))
            for k in range(SIDES - 1):
                self.triangles.append((tip, row[k + 1], row[k]) if first else (tip, row[k], row[k + 1]))

    def normals(self):
        sums = {}
        for t in self.triangles:
            a, b, c = (self.positions[i] for i in t)
            u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
            n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            for i in t:
                key = tuple(round(x, 5) for x in self.positions[i])
                sums[key] = tuple(x + y for x, y in zip(sums.get(key, (0, 0, 0)), n))
        out = []
        for p in self.positions:
            n = sums.get(tuple(round(x, 5) for x in p), (0, 1, 0))
            length = math.hypot(*n) or 1
            out.append(tuple(x / length for x in n))
        return out


def along(value, joints, width):
    """Shares of bones whose joints are at the values `joints`: [(value, bone)], blended over +-width around each joint."""
    shares, left = {}, 1.0
    for start, bone in reversed(joints):
        part = smooth((value - start + width) / (2 * width)) if start is not None else 1
        shares[bone] = left * part
        left *= 1 - part
    return shares


def table(value, rows):
    """Piecewise linear values of the rows (x, y, ...) at x = value."""
    for low, high in zip(rows, rows[1:]):
        if value <= high[0]:
            t = (value - low[0]) / (high[0] - low[0])
            return [a + t * (b - a) for a, b in zip(low[1:], high[1:])]
    return list(rows[-1][1:])


def steps(first, last, count):
    return [first + (last - first) * i / (count - 1) for i in range(count)]


def body():
    s = Surface()
    trunk = [(None, "Hips"), (1.07, "Spine"), (1.22, "Chest"), (1.48, "Neck")]
    rows = [(0.85, 0.06, 0.06), (0.88, 0.145, 0.1), (0.95, 0.172, 0.118), (1.05, 0.15, 0.105), (1.16, 0.152, 0.105), (1.3, 0.178, 0.118),
            (1.38, 0.176, 0.112), (1.43, 0.13, 0.09), (1.46, 0.075, 0.066), (1.48, 0.056, 0.054)]
    split = 1.0  # m, height of the hem of the pullover
    for low, high, quadrant, wide, ends in ((0.85, split, 1, 0, (True, False)), (split - 0.03, 1.48, 0, 0.008, (False, False))):
        rings = []
        for y in steps(low, high, 5 if quadrant else 15):
            a, b = table(y, rows)
            rings.append(((0, y, 0), (0, 0, b + wide), (a + wide, 0, 0), (y - low) / (high - low)))
        s.tube(rings, quadrant, lambda c: along(c[1], trunk, 0.07), ends)
    neck = [(None, "Chest"), (1.46, "Neck"), (1.57, "Head")]
    s.tube([((0, y, 0.005), (0, 0, 0.05), (0.048, 0, 0), 0.02) for y in steps(1.44, 1.6, 4)], 2, lambda c: along(c[1], neck, 0.03), (False, False))
    rings = []
    for i in range(13):
        phi = math.pi * i / 12
        y, r = -math.cos(phi), max(0.02, math.sin(phi))
        rings.append(((0, 1.675 + 0.125 * y, 0.022), (0, 0, 0.108 * r), (0.092 * r, 0, 0), 0.5 - 0.5 * math.cos(phi)))
    s.tube(rings, 2, lambda c: {"Head": 1})
    for side, sign in (("Left", 1), ("Right", -1)):
        arm = [(None, "Chest"), (0.13, side + "Shoulder"), (0.19, side + "Arm"), (0.46, side + "ForeArm"), (0.72, side + "Hand")]
        rows = [(0.1, 0.05), (0.14, 0.072), (0.2, 0.068), (0.33, 0.056), (0.45, 0.05), (0.56, 0.05), (0.67, 0.041), (0.7, 0.047), (0.72, 0.047)]
        rings = []
        for x in steps(0.1, 0.72, 20):
            (r,) = table(x, rows)
            rings.append(((sign * x, 1.425, 0), (0, r, 0), (0, 0, sign * r), (x - 0.1) / 0.62))
        s.tube(rings, 0, lambda c: along(abs(c[0]), arm, 0.045), (False, True))
        hand = [(None, side + "ForeArm"), (0.71, side + "Hand")]
        rows = [(0.69, 0.026, 0.03), (0.73, 0.024, 0.036), (0.78, 0.02, 0.047), (0.83, 0.017, 0.042), (0.86, 0.011, 0.026), (0.87, 0.003, 0.008)]
        rings = []
        for x in steps(0.69, 0.87, 10):
            a, b = table(x, rows)
            rings.append(((sign * x, 1.425, 0), (0, a, 0), (0, 0, sign * b), 0.03))
        s.tube(rings, 2, lambda c: along(abs(c[0]), hand, 0.02), (False, True))
        leg = [(None, side + "Foot"), (0.1, side + "Leg"), (0.5, side + "UpLeg"), (0.93, "Hips")]
        rows = [(0.07, 0.057), (0.09, 0.058), (0.2, 0.052), (0.36, 0.066), (0.48, 0.064), (0.62, 0.076), (0.8, 0.092), (0.93, 0.08)]
        rings = []
        for y in steps(0.075, 0.93, 22):
            (r,) = table(y, rows)
            rings.append(((sign * (0.09 if y < 0.8 else 0.09 - 0.1 * (y - 0.8)), y, -0.005), (0, 0, r), (r, 0, 0), (y - 0.07) / 0.86))
        s.tube(rings, 1, lambda c: along(c[1], leg, 0.06), (False, False))
        foot = [(None, side + "Foot"), (0.13, side + "ToeBase")]
        rows = [(-0.075, 0.012, 0.012, 0.04), (-0.06, 0.033, 0.038, 0.045), (-0.02, 0.044, 0.052, 0.056), (0.04, 0.045, 0.047, 0.05),
                (0.1, 0.048, 0.035, 0.036), (0.16, 0.046, 0.027, 0.027), (0.2, 0.033, 0.021, 0.022), (0.215, 0.01, 0.008, 0.02)]
        rings = []
        for z in steps(-0.075, 0.215, 15):
            a, b, y = table(z, rows)
            rings.append(((sign * 0.09, y, z), (a, 0, 0), (0, b, 0), (z + 0.075) / 0.29))
        s.tube(rings, 3, lambda c: along(c[2], foot, 0.03))
    return s


def texture(size=256):
    """The picture: stripes of wool, blue trousers, a face, shoes. Rows from the top."""
    half = size // 2
    rows = []
    for y in range(size):
        row = bytearray([0])
        for x in range(size):
            quadrant = (x >= half) + 2 * (y >= half)
            u, v = (x % half) / half, (y % half) / half
            if quadrant == 0:  # stripes, with the rows of the wool
                colour = (214, 72, 60) if int(v * 9) % 2 else (240, 226, 200)
                light = 0.9 + 0.1 * ((x // 2 + y // 2) % 2)
            elif quadrant == 1:  # trousers: a seam at the side
                colour, light = (58, 84, 128), 1.25 if u < 0.03 or u > 0.97 or 0.48 < u < 0.52 else 0.94 + 0.06 * ((x + y) % 2)
            elif quadrant == 2:
                # the ring begins at the front (z), so the face is at both ends of u
                a = 2 * math.pi * u
                forward, sideways, height = math.cos(a), math.sin(a), v
                hair = height > 0.8 + 0.1 * forward or (forward < -0.1 and height > 0.3)
                eye = forward > 0 and math.hypot(abs(sideways) - 0.36, 1.6 * (height - 0.58)) < 0.085
                mouth = forward > 0 and abs(height - 0.33 - 0.3 * sideways * sideways) < 0.02 and abs(sideways) < 0.3
                cheek = forward > 0 and math.hypot(abs(sideways) - 0.5, 1.4 * (height - 0.42)) < 0.1
                colour = (92, 60, 40) if hair else (40, 36, 40) if eye else (176, 62, 62) if mouth else (236, 168, 144) if cheek else (238, 196, 162)
                light = 0.92 + 0.08 * (int(u * 48) % 2) if hair else 1
            else:
                sole = 0.6 < u < 0.9
                colour, light = ((238, 236, 230) if sole or v > 0.86 else (74, 62, 58)), 1
            row += bytes(min(255, round(light * c)) for c in colour)
        rows.append(bytes(row))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) + chunk(b"IEND", b"")


def about(axis, angle):
    s = math.sin(0.5 * angle)
    return (axis[0] * s, axis[1] * s, axis[2] * s, math.cos(0.5 * angle))


def after(a, b):
    """The rotation b, and then a."""
    (x, y, z, w), (p, q, r, s) = a, b
    return (w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s, w * s - x * p - y * q - z * r)


def knee_bend(t):
    """Angle of the thighs, rad, at time t of 3 s."""
    return 0.07 + 0.05 * (1 - math.cos(2 * math.pi * t / 1.5))


def waving(t):
    """Rotations of the joints at time t (s) of 3 s: the right arm hangs, the left one waves; head and trunk sway, and the knees give way."""
    up = smooth(t / 0.7) * smooth((3 - t) / 0.7)
    wave = up * math.sin(2 * math.pi * 1.6 * t)
    x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    legs = {}
    for side in ("Left", "Right"):
        bend = knee_bend(t)
        legs |= {side + "UpLeg": about(x, -bend), side + "Leg": about(x, 2 * bend), side + "Foot": about(x, -bend)}
    sway = lambda size, phase: size * math.sin(2 * math.pi * t / 3 + phase) * math.sin(math.pi * t / 3)
    small = lambda size, phase: after(about(x, sway(size, phase)), after(about(y, sway(size, phase + 1)), about(z, sway(size, phase + 2))))
    return legs | {
        "RightArm": after(about(z, 1.32), small(0.12, 0)), "RightForeArm": after(about(y, -0.2 + sway(0.15, 1)), about(x, sway(0.1, 2))), "RightHand": small(0.1, 2),
        "LeftArm": after(about(z, -1.32 + 1.95 * up), small(0.12, 3)), "LeftForeArm": after(about(z, up * 0.5 + 0.35 * wave), about(y, 0.2 * (1 - up))),
        "LeftHand": after(about(z, 0.3 * wave), small(0.06, 1)), "Spine": small(0.03, 1), "Chest": after(about(z, -0.05 * up), small(0.03, 0)), "Neck": after(about(z, 0.05 * up), small(0.03, 2)),
        "Head": after(about(y, 0.25 * up), after(about(z, -0.06 * up), small(0.04, 1)))}


def gltf():
    """The doll as the text of a .gltf file that contains everything."""
    data = bytearray()
    root = {"asset": {"version": "2.0", "generator": "examples/content/recipes/doll.py"}, "scene": 0, "bufferViews": [], "accessors": []}

    def view(content):
        root["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": len(content)})
        data.extend(content + bytes(-len(content) % 4))
        return len(root["bufferViews"]) - 1

    def accessor(rows, kind, letter, normalised=False):
        flat = [x for row in rows for x in row]
        entry = {"bufferView": view(struct.pack("<%d%s" % (len(flat), letter), *flat)), "componentType": FORMATS[letter], "count": len(rows), "type": kind}
        if normalised:
            entry["normalized"] = True
        if letter == "f":
            entry["min"], entry["max"] = ([f(struct.unpack("<f", struct.pack("<f", x))[0] for x in c) for c in zip(*rows)] for f in (min, max))
        root["accessors"].append(entry)
        return len(root["accessors"]) - 1

    surface = body()
    attributes = {"POSITION": accessor(surface.positions, "VEC3", "f"), "NORMAL": accessor(surface.normals(), "VEC3", "f"),
                  "TEXCOORD_0": accessor(surface.uvs, "VEC2", "f"), "JOINTS_0": accessor(surface.joints, "VEC4", "B"),
                  "WEIGHTS_0": accessor(surface.weights, "VEC4", "B", True)}
    indices = accessor([(i,) for t in surface.triangles for i in t], "SCALAR", "H")
    root["meshes"] = [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}]
    root["images"] = [{"bufferView": view(texture()), "mimeType": "image/png"}]
    root["textures"] = [{"source": 0}]
    root["materials"] = [{"name": "doll", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}]
    place = {name: p for name, _, p in BONES}
    root["nodes"] = []
    for name, parent, p in BONES:
        node = {"name": name, "translation": [round(x - y, 6) for x, y in zip(p, place[parent] if parent else (0, 0, 0))]}
        children = [INDEX[n] for n, of, _ in BONES if of == name]
        if children:
            node["children"] = children
        root["nodes"].append(node)
    root["nodes"].append({"name": "doll", "mesh": 0, "skin": 0})
    root["scenes"] = [{"nodes": [0, len(BONES)]}]
    binds = [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -p[0], -p[1], -p[2], 1) for _, _, p in BONES]
    root["skins"] = [{"joints": list(range(len(BONES))), "inverseBindMatrices": accessor(binds, "MAT4", "f")}]
    times = [i / 20 for i in range(61)]
    turned = [waving(t) for t in times]
    animation = {"name": "wave", "channels": [], "samplers": []}
    input_times = accessor([(t,) for t in times], "SCALAR", "f")
    for name in turned[0]:
        animation["samplers"].append({"input": input_times, "output": accessor([pose[name] for pose in turned], "VEC4", "f")})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": INDEX[name], "path": "rotation"}})
    # thighs and shanks are about equally long, so the feet stay where they are
    lengths = place["LeftUpLeg"][1] - place["LeftFoot"][1]
    hips = [(0, 0.95 - lengths * (1 - math.cos(knee_bend(t))), 0) for t in times]
    animation["samplers"].append({"input": input_times, "output": accessor(hips, "VEC3", "f")})
    animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": 0, "path": "translation"}})
    root["animations"] = [animation]
    root["buffers"] = [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(bytes(data)).decode()}]
    return json.dumps(root, separators=(",", ":"))


def doll():
    """Two dolls with a skin: one waves as in its file, the other walks past by a computed gait."""
    return {
        "scenario": {
            "version": 1, "name": "doll", "duration": 9,
            "characters": [
                {"id": "waver", "name": "Doll that waves", "mechanism": "doll-body", "place": {"x": 3.2, "y": 1.1, "heading": -90},
                 "track": [{"id": f"k{i + 1}", "motion": "doll", "start": 3 * i, "length": 3} for i in range(3)]},
                {"id": "walker", "name": "Doll that walks", "mechanism": "doll-body", "place": {"x": 0, "y": -0.4},
                 "track": [{"id": "k4", "motion": "walk", "start": 0, "length": 9}]},
            ],
            "camera": {"follow": "walker", "distance": 4.5, "azimuth": -0.9, "elevation": 0.18},
        },
        "measured": {"doll": {"file": "doll.gltf", "text": gltf()}},
        "motions": {"walk": {"name": "Walk of the doll", "of": "doll-body", "gait": {"kind": "walk", "speed": 1.0, "seconds": 9}}},
    }


if __name__ == "__main__":
    import sys
    sys.stdout.write(gltf())
