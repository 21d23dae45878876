# Tests the add-on integrations/blender/ugoki_blender.py: imports a BVH file, simulates it with and without a push, and prints measured
# values.   addon.py -- ADDON.py MOTION.bvh      (UGOKI_BIN is the path of `ugoki`)
import importlib.util
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import old_blender  # noqa: F401,E402  (before anything that needs numpy)
import bpy  # noqa: E402

addon_file, motion = sys.argv[sys.argv.index("--") + 1:][:2]
spec = importlib.util.spec_from_file_location("ugoki_blender", addon_file)
addon = importlib.util.module_from_spec(spec)
spec.loader.exec_module(addon)
addon.register()

bpy.ops.import_anim.bvh(filepath=motion, global_scale=0.056444, update_scene_fps=True, update_scene_duration=True)
armature = bpy.context.object
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 3, 92  # frame 1 is a calibration pose


def heads():
    out = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        out.append({b.name: (armature.matrix_world @ b.matrix).translation.copy() for b in armature.pose.bones})
    return out


def distance(a, b):
    return [max((x[name] - y[name]).length for name in x) for x, y in zip(a, b)]


measured = heads()
measured_action = armature.animation_data.action
print("STATUS", bpy.ops.ugoki.simulate())
simulated = heads()
apart = distance(measured, simulated)
print(f"START {apart[0]:.6f}")
print(f"MEAN {sum(apart) / len(apart):.6f}")
print(f"WORST {max(apart):.6f}")
print("ACTIONS", len(bpy.data.actions))
lengths = [abs((s[b.name] - s[b.parent.name]).length - (m[b.name] - m[b.parent.name]).length)
           for m, s in zip(measured, simulated) for b in armature.pose.bones if b.parent]
print(f"STRETCH {max(lengths):.6f}")
armature.animation_data.action = measured_action
print(f"KEPT {max(distance(measured, heads())):.6f}")
scene.ugoki.push = 400
scene.ugoki.push_time = 0.2
print("STATUS", bpy.ops.ugoki.simulate())
pushed = heads()
apart = distance(simulated, pushed)
early = int(0.15 * scene.render.fps / scene.render.fps_base)
print(f"BEFORE {max(apart[:early]):.6f}")
print(f"AFTER {max(apart):.6f}")
