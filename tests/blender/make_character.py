"""Makes a skinned, animated character in Blender, exports it, and writes the positions of its joints.

blender -b --factory-startup --python-exit-code 3 --python make_character.py -- FILE(.fbx|.dae) EXPECTED SEED
EXPECTED: lines "rate R", then for each frame "frame F" and for each joint "x y z name": heads of bones in the world, Blender's axes, metres.
"""
import math
import random
import sys

from old_blender import bpy
from mathutils import Euler, Quaternion, Vector

path, expected, seed = sys.argv[sys.argv.index("--") + 1 :]
dice = random.Random(int(seed))
FRAMES, RATE, BONES = 40, 30, 12


def direction(size):
    return Vector([dice.uniform(-1, 1) for _ in range(3)]).normalized() * size


scene = bpy.context.scene
scene.render.fps, scene.render.fps_base = RATE, 1.0
scene.frame_start, scene.frame_end = 1, FRAMES
for item in list(bpy.data.objects):
    bpy.data.objects.remove(item)

# A tree of bones with individual rolls; some start at the end of their parent, some at another position.
data = bpy.data.armatures.new("character")
character = bpy.data.objects.new("character", data)
scene.collection.objects.link(character)
bpy.context.view_layer.objects.active = character
character.select_set(True)
bpy.ops.object.mode_set(mode="EDIT")
bones = []
for i in range(BONES):
    bone = data.edit_bones.new(f"bone {i}" if i % 3 == 0 else f"bone.{i}")
    parent = bones[(i - 1) // 2] if i else None
    connected = i % 2 == 1
    bone.head = (Vector((0, 0, 1)) if parent is None else parent.tail if connected else parent.tail + direction(0.1))
    bone.tail = bone.head + direction(dice.uniform(0.15, 0.35))
    bone.roll = dice.uniform(-3, 3)
    bone.parent = parent
    bone.use_connect = connected
    bones.append(bone)
names = [bone.name for bone in bones]
places = {bone.name: (bone.head.copy(), bone.tail.copy()) for bone in bones}
bpy.ops.object.mode_set(mode="OBJECT")

# A tetrahedron for every bone, skinned to it.
vertices, faces = [], []
for name in names:
    head, tail = places[name]
    side = (tail - head).orthogonal() * 0.2
    n = len(vertices)
    vertices += [head + side, head - side, head + side.cross(tail - head).normalized() * 0.04, tail]
    faces += [(n, n + 1, n + 2), (n, n + 1, n + 3), (n + 1, n + 2, n + 3), (n + 2, n, n + 3)]
mesh = bpy.data.meshes.new("skin")
mesh.from_pydata(vertices, [], faces)
skin = bpy.data.objects.new("skin", mesh)
scene.collection.objects.link(skin)
for i, name in enumerate(names):
    skin.vertex_groups.new(name=name).add(range(4 * i, 4 * i + 4), 1.0, "REPLACE")
skin.parent = character
skin.modifiers.new("skin", "ARMATURE").object = character

# The character has a position and rotation in the world; with seed 3 it is scaled, with seed 2 its object is animated as well. All bones
# rotate in every frame, and the first bone also translates.
character.location, character.rotation_euler = (0.7, -0.4, 0.2), (0.1, -0.2, 0.9)
character.scale = (0.8,) * 3 if seed == "3" else (1,) * 3
waves = {name: (direction(1), dice.uniform(0.3, 1.4), dice.uniform(0.5, 2)) for name in names}
for frame in range(1, FRAMES + 1):
    t = (frame - 1) / RATE
    for name in names:
        bone = character.pose.bones[name]
        axis, size, speed = waves[name]
        turn = Quaternion(axis, size * math.sin(2 * math.pi * speed * t + size))
        if name.endswith("5"):
            bone.rotation_mode = "XYZ"
            bone.rotation_euler = turn.to_euler("XYZ", bone.rotation_euler if frame > 1 else Euler())
            bone.keyframe_insert("rotation_euler", frame=frame)
        else:
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = turn
            bone.keyframe_insert("rotation_quaternion", frame=frame)
    if seed == "2":
        character.location.x, character.rotation_euler.z = 0.7 + 0.5 * t, 0.9 - 0.6 * t
        character.keyframe_insert("location", frame=frame)
        character.keyframe_insert("rotation_euler", frame=frame)
    first = character.pose.bones[names[0]]
    first.location = (0.3 * t, 0.1 * math.sin(4 * t), -0.2 * t)
    first.keyframe_insert("location", frame=frame)

with open(expected, "w", encoding="utf-8") as out:
    out.write(f"rate {RATE}\n")
    for frame in range(FRAMES):
        scene.frame_set(1 + frame)
        out.write(f"frame {frame}\n")
        for name in names:
            at = character.matrix_world @ character.pose.bones[name].head
            out.write("%.9f %.9f %.9f %s\n" % (*at, name))
scene.frame_set(1)
if path.endswith(".fbx"):
    bpy.ops.export_scene.fbx(filepath=path, bake_anim_simplify_factor=0.0, bake_anim_use_nla_strips=False, bake_anim_use_all_actions=False)
else:
    bpy.ops.wm.collada_export(filepath=path)
