"""Blender add-on: simulates the motion of the selected armature with Ugoki and puts the simulated motion back on it as a new action.

Install the add-on in Blender under Edit > Preferences > Add-ons > Install, and enter the path of the program `ugoki` in its preferences. The
panel is in the sidebar of the 3D view (N), tab Ugoki. The add-on needs Blender 3.4 or newer. `ugoki` runs on this computer and sends no data
to other computers.
"""

import csv
import json
import os
import shutil
import subprocess
import tempfile

import bpy
import numpy
from mathutils import Matrix, Quaternion, Vector

bl_info = {
    "name": "Ugoki: physically natural motion",
    "author": "the Ugoki project",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "View3D > Sidebar > Ugoki",
    "description": "Simulates the motion of an armature and puts the result back as a new action",
    "category": "Animation",
}


class UgokiPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: bpy.props.StringProperty(name="Program ugoki", subtype="FILE_PATH", default="ugoki")

    def draw(self, _context):
        self.layout.prop(self, "program")


class UgokiSettings(bpy.types.PropertyGroup):
    push: bpy.props.FloatProperty(name="Push", description="Force of a push, N; 0: none", default=0, min=-10000, max=10000)
    push_time: bpy.props.FloatProperty(name="at", description="Time of the push after the start, s", default=1, min=0, max=86400)
    push_direction: bpy.props.FloatVectorProperty(name="Direction", description="Direction of the push in Blender's world", size=2, default=(1, 0))
    push_bone: bpy.props.StringProperty(name="Bone", description="Bone that is pushed; empty: the root bone", default="")


def program_of(context):
    """Returns the path of the program from the preferences (searched on $PATH if it has no folder), or from $UGOKI_BIN."""
    addon = context.preferences.addons.get(__name__)
    wanted = addon.preferences.program if addon else "ugoki"
    found = shutil.which(bpy.path.abspath(wanted) if os.sep in wanted else wanted) or shutil.which(os.environ.get("UGOKI_BIN", ""))
    if not found:
        raise RuntimeError(f"The program '{wanted}' was not found. Enter its path in the preferences of the add-on.")
    return found


def run(program, *words):
    """Runs ugoki and returns its output. If ugoki fails, raises a RuntimeError with its error message."""
    done = subprocess.run([program, *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip() or f"ugoki ended with status {done.returncode}.")
    return done.stdout


def read_table(path):
    """Reads the poses of the links from the table of `ugoki export --csv`. Returns {link: [4x4 matrix for each frame]}, world axes of Ugoki."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    columns = {}
    for index, name in enumerate(rows[0]):
        if name.endswith(" x") and not name.endswith("centre of mass x"):
            columns[name.split("/", 1)[1][:-2]] = index
    poses = {}
    for link, at in columns.items():
        poses[link] = []
        for row in rows[1:]:
            x = [float(v) for v in row[at:at + 7]]
            poses[link].append(Matrix.Translation(x[:3]) @ Quaternion(x[3:]).to_matrix().to_4x4())
    return poses


def rigid_fit(points, targets):
    """Returns the rotation and translation that move `points` onto `targets` with the least squares error (Kabsch 1976), as a 4x4 matrix,
    and the maximum remaining distance."""
    a, b = numpy.array(points, dtype=float), numpy.array(targets, dtype=float)
    u, _, v = numpy.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
    sign = numpy.sign(numpy.linalg.det(v.T @ u.T))
    rotation = v.T @ numpy.diag([1, 1, sign]) @ u.T
    shift = b.mean(axis=0) - rotation @ a.mean(axis=0)
    left = numpy.linalg.norm((rotation @ a.T).T + shift - b, axis=1).max()
    out = Matrix(rotation.tolist()).to_4x4()
    out.translation = Vector(shift.tolist())
    return out, left


def bone_of_link(armature, link):
    """Returns the bone that has the name of the link, or None."""
    return armature.pose.bones.get(link)


def set_rotation(bone, turn, is_first):
    """Sets a bone's rotation in the bone's rotation mode, close to the previous rotation. Returns the name of the property. The mode is not
    changed, so that the measured action still works."""
    if bone.rotation_mode == "QUATERNION":
        if not is_first and turn.dot(bone.rotation_quaternion) < 0:
            turn.negate()
        bone.rotation_quaternion = turn
        return "rotation_quaternion"
    if bone.rotation_mode == "AXIS_ANGLE":
        axis, angle = turn.to_axis_angle()
        bone.rotation_axis_angle = (angle, *axis)
        return "rotation_axis_angle"
    bone.rotation_euler = turn.to_euler(bone.rotation_mode) if is_first else turn.to_euler(bone.rotation_mode, bone.rotation_euler)
    return "rotation_euler"


def simulate(context, armature, settings):
    """Simulates the armature's motion in the scene's frame range. Returns the new action and the number of moved bones."""
    program = program_of(context)
    scene = context.scene
    first, last = scene.frame_start, scene.frame_end
    rate = scene.render.fps / scene.render.fps_base
    bones = list(armature.pose.bones)
    # The poses of the measured motion. Bones that Ugoki does not move keep these poses.
    basis, start = {b.name: [] for b in bones}, {}
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        for b in bones:
            basis[b.name].append(b.matrix_basis.copy())
            if frame == first:
                start[b.name] = armature.matrix_world @ b.matrix
    with tempfile.TemporaryDirectory(prefix="ugoki-") as folder:
        motion, table, inputs = (os.path.join(folder, name) for name in ("motion.glb", "motion.csv", "inputs.json"))
        for other in context.selected_objects:
            other.select_set(False)
        armature.select_set(True)
        with context.temp_override(active_object=armature, object=armature, selected_objects=[armature]):
            # The motion is exported as glTF, because glTF, unlike BVH, defines the unit and the up axis.
            bpy.ops.export_scene.gltf(filepath=motion, export_format="GLB", use_selection=True, export_animations=True, export_frame_range=True,
                                      export_force_sampling=True, export_nla_strips=False)
        words = ["export", motion, "--csv", table, "--rate", f"{rate:.9g}"]
        run(program, *words)
        poses = read_table(table)
        pairs = [(link, bone_of_link(armature, link)) for link in poses]
        pairs = [(link, bone) for link, bone in pairs if bone is not None]
        if len(pairs) < 3:
            raise RuntimeError("Fewer than three bones of the armature were found in the simulated body.")
        # Ugoki's axes, unit and floor differ from Blender's. The first frame is equal in both, so it gives the transformation.
        to_blender, left = rigid_fit([poses[link][0].translation for link, _ in pairs], [start[bone.name].translation for _, bone in pairs])
        if left > 0.05:
            raise RuntimeError(f"In the first frame the simulated body differs from the armature by {left:.3f} m (limit 0.05 m). Begin the "
                               "frame range after a calibration pose, apply the scale of the armature (Ctrl+A), and use metres.")
        if settings.push != 0:
            link = settings.push_bone or pairs[0][0]
            if link not in poses:
                raise RuntimeError(f"The simulated body has no bone '{settings.push_bone}'. Choose another bone for the push.")
            direction = to_blender.to_3x3().inverted() @ Vector((*settings.push_direction, 0)).normalized()
            step = round(settings.push_time / 0.002)  # steps of 2 ms, the default of a motion file
            push = {"step": step, "type": "push", "character": 0, "link": link, "force": list(direction * settings.push), "duration": 0.2}
            with open(inputs, "w", encoding="utf-8") as file:
                json.dump({"inputs": [push]}, file)
            run(program, *words, "--inputs", inputs)
            poses = read_table(table)

    action = bpy.data.actions.new(f"{armature.name} Ugoki")
    old = armature.animation_data.action if armature.animation_data else None
    if old:
        old.use_fake_user = True  # Blender keeps the measured action in the file
    (armature.animation_data or armature.animation_data_create()).action = action
    simulated = {bone.name: [to_blender @ x for x in poses[link]] for link, bone in pairs}
    world = armature.matrix_world.inverted()
    count = min(last - first + 1, min(len(x) for x in simulated.values()))
    for i in range(count):
        pose = {}
        for b in bones:  # parents come before their children
            rest = b.bone.matrix_local
            parent = pose[b.parent.name] @ b.parent.bone.matrix_local.inverted() @ rest if b.parent else rest
            if b.name in simulated:
                # From the first frame on, a link and its bone move as one rigid body.
                moved = world @ simulated[b.name][i] @ simulated[b.name][0].inverted() @ start[b.name]
                own = parent.inverted() @ moved
                if b.parent and b.parent.name in simulated:  # the joint only rotates the bone, so that bones keep their lengths
                    own.translation = basis[b.name][i].translation
            else:
                own = basis[b.name][i]
            pose[b.name] = parent @ own
            place, turn, _ = own.decompose()
            b.location = place
            b.keyframe_insert(set_rotation(b, turn, i == 0), frame=first + i)
            if b.name in simulated and not (b.parent and b.parent.name in simulated):
                b.keyframe_insert("location", frame=first + i)
    scene.frame_set(first)
    return action, len(simulated)


class UGOKI_OT_simulate(bpy.types.Operator):
    bl_idname = "ugoki.simulate"
    bl_label = "Simulate with Ugoki"
    bl_description = "Simulate the motion of the armature in the frame range of the scene, and put the result on it as a new action"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "ARMATURE"

    def execute(self, context):
        try:
            action, moved = simulate(context, context.object, context.scene.ugoki)
        except RuntimeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{moved} bones simulated; the new action is '{action.name}'.")
        return {"FINISHED"}


class UGOKI_PT_panel(bpy.types.Panel):
    bl_label = "Ugoki"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Ugoki"

    def draw(self, context):
        settings = context.scene.ugoki
        column = self.layout.column()
        column.operator(UGOKI_OT_simulate.bl_idname)
        if not UGOKI_OT_simulate.poll(context):
            column.label(text="Select an armature.", icon="INFO")
        column.separator()
        column.prop(settings, "push")
        if settings.push != 0:
            column.prop(settings, "push_time")
            column.prop(settings, "push_direction")
            if context.object and context.object.type == "ARMATURE":
                column.prop_search(settings, "push_bone", context.object.data, "bones")


classes = (UgokiPreferences, UgokiSettings, UGOKI_OT_simulate, UGOKI_PT_panel)


def register():
    for one in classes:
        bpy.utils.register_class(one)
    bpy.types.Scene.ugoki = bpy.props.PointerProperty(type=UgokiSettings)


def unregister():
    del bpy.types.Scene.ugoki
    for one in reversed(classes):
        bpy.utils.unregister_class(one)


if __name__ == "__main__":
    register()
