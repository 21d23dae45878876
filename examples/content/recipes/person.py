"""Link frames of a person of 1.75 m ({"person": 1.75}), for contents that place hands and feet."""
import math

from recipes.common import r

# Position of each joint in the frame of its parent, m: x ahead, y to the left. Right limbs mirror left ones. `ugoki info` prints them.
HIP, THIGH, SHANK = (-0.0020, 0.0875, -0.0385), 0.4289, 0.4307
SPINE = [(-0.0087, 0, 0.0629), (0, 0, 0.1212), (0.0016, 0, 0.1211)]  # abdomen, upper abdomen, chest
SHOULDER, UPPER_ARM, ELBOW, WRIST = (0.0072, 0.0300, 0.1662), (-0.0082, 0.1661, -0.0047), (0, 0.3256, 0), (0, 0.2556, 0)
PALM = (0, 0.07, 0)  # point of the hand that holds
BALL = (0.125, 0, -0.075)  # point of the foot that stands on a pedal or in a stirrup, in the frame of the foot


def multiply(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def apply(R, p):
    return [sum(R[i][k] * p[k] for k in range(3)) for i in range(3)]


def add(*points):
    return [sum(c) for c in zip(*points)]


def rotation(vector):
    """Rotation matrix of a rotation vector (rad)."""
    angle = math.sqrt(sum(c * c for c in vector))
    if angle < 1e-12:
        return [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]
    x, y, z = (c / angle for c in vector)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


def leg(foot, pitch, hip):
    """Angles about y of hip, knee and ankle that put the ball of the foot at `foot` (x, z). @param pitch of the foot, toes down
    @param hip (x, z)"""
    c, s = math.cos(pitch), math.sin(pitch)
    ankle = (foot[0] - (BALL[0] * c + BALL[2] * s), foot[1] - (-BALL[0] * s + BALL[2] * c))
    dx, dz = ankle[0] - hip[0], ankle[1] - hip[1]
    d = math.hypot(dx, dz)
    knee = math.pi - math.acos((THIGH ** 2 + SHANK ** 2 - d * d) / (2 * THIGH * SHANK))
    inner = math.acos((THIGH ** 2 + d * d - SHANK ** 2) / (2 * THIGH * d))
    thigh = math.atan2(-dx, -dz) - inner
    return thigh, knee, pitch - thigh - knee


def palm(spine, arm, elbow):
    """Position of the left palm in the frame of the pelvis. @param spine pitch of each of the three joints of the spine
    @param arm rotation vector of the upper arm @param elbow angle"""
    R, p = rotation([0, 0, 0]), [0, 0, 0]
    for joint in SPINE:
        p = add(p, apply(R, joint))
        R = multiply(R, rotation([0, spine, 0]))
    p = add(p, apply(R, SHOULDER))
    p = add(p, apply(R, UPPER_ARM))
    R = multiply(R, rotation(arm))
    p = add(p, apply(R, ELBOW))
    R = multiply(R, rotation([0, 0, -elbow]))
    return add(p, apply(R, WRIST), apply(R, PALM))


def reach(target, spine, start):
    """Rotation vector of the left upper arm and angle of the elbow that put the palm at `target`, close to `start`: damped least squares."""
    x = list(start)
    for _ in range(200):
        now = palm(spine, x[:3], x[3])
        gap = [t - n for t, n in zip(target, now)]
        if max(abs(g) for g in gap) < 1e-10:
            break
        J = []
        for k in range(4):
            moved = x[:]
            moved[k] += 1e-6
            J.append([(m - n) / 1e-6 for m, n in zip(palm(spine, moved[:3], moved[3]), now)])
        A = [[sum(J[k][i] * J[k][j] for k in range(4)) + (1e-3 if i == j else 0) for j in range(3)] for i in range(3)]
        y = solve(A, gap)
        change = [sum(J[k][i] * y[i] for i in range(3)) for k in range(4)]
        scale = min(1.0, 0.1 / max(1e-12, max(abs(c) for c in change)))  # at most 0.1 rad
        x = [a + scale * c for a, c in zip(x, change)]
        x[3] = max(0.1, x[3])
    return [r(v, 4) for v in x]


def solve(A, b):
    """Solution of a system of three equations (Cramer)."""
    det = lambda M: sum(M[0][i] * (M[1][(i + 1) % 3] * M[2][(i + 2) % 3] - M[1][(i + 2) % 3] * M[2][(i + 1) % 3]) for i in range(3))
    whole = det(A)
    return [det([[b[i] if k == j else A[i][k] for k in range(3)] for i in range(3)]) / whole for j in range(3)]


def arm_keys(arm, prefix=""):
    """Keys of both arms at time 0, from those of the left one; the right arm mirrors it."""
    x, y, z, elbow = arm
    return [{"link": f"{prefix}LeftArm", "keys": [{"time": 0, "value": [x, y, z]}]}, {"link": f"{prefix}RightArm", "keys": [{"time": 0, "value": [r(-x), y, r(-z)]}]},
            {"link": f"{prefix}LeftForeArm", "keys": [{"time": 0, "value": [elbow]}]}, {"link": f"{prefix}RightForeArm", "keys": [{"time": 0, "value": [elbow]}]}]


def ball(thigh, knee, ankle):
    """Position of the ball of the left foot in the frame of the pelvis. @param thigh, ankle rotation vectors @param knee angle"""
    R, p = rotation(thigh), list(HIP)
    p = add(p, apply(R, (0, 0, -THIGH)))
    R = multiply(R, rotation([0, knee, 0]))
    p = add(p, apply(R, (0, 0, -SHANK)))
    return add(p, apply(multiply(R, rotation(ankle)), BALL))
