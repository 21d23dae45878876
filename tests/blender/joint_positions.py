"""Opens a BVH or GLB file in Blender and prints the maximum distance [m] of a joint from its expected position.

blender -b --factory-startup --python-exit-code 3 --python joint_positions.py -- FILE EXPECTED
EXPECTED: lines "rate R", then "frame F" and for each joint "x y z name" in Blender's axes, metres.
"""
import sys

from old_blender import bpy, plain_open

path, expected = sys.argv[sys.argv.index("--") + 1 :]
frames, rate = {}, 30.0
with plain_open(expected, encoding="utf-8") as lines:
    for line in lines:
        word, rest = line.rstrip("\n").split(" ", 1)
        if word == "rate":
            rate = float(rest)
        elif word == "frame":
            joints = frames.setdefault(int(rest), {})
        else:
            y, z, name = rest.split(" ", 2)
            joints[name] = (float(word), float(y), float(z))

scene = bpy.context.scene
scene.render.fps = round(rate)
scene.render.fps_base = round(rate) / rate
for item in list(bpy.data.objects):
    bpy.data.objects.remove(item)
if path.endswith(".bvh"):
    bpy.ops.import_anim.bvh(filepath=path, frame_start=1)
    first = 1
else:
    bpy.ops.import_scene.gltf(filepath=path)
    first = 0
armature = next(o for o in bpy.data.objects if o.type == "ARMATURE")
worst, where, found = 0.0, "", 0
for frame, joints in frames.items():
    scene.frame_set(first + frame)
    for name, at in joints.items():
        bone = armature.pose.bones.get(name) or armature.pose.bones.get(name[:63])
        if bone is None:
            print("MISSING", name)
            sys.exit(4)
        head = armature.matrix_world @ bone.head
        found += 1
        distance = sum((a - b) ** 2 for a, b in zip(head, at)) ** 0.5
        if distance > worst:
            worst, where = distance, f"{name} in frame {frame}"
print(f"WORST {worst:.9f} FOUND {found} AT {where}")
