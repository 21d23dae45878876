// FBX and Alembic files of `ugoki export`: Blender opens the content as GLB and saves it in the other format.

#include "child.h"
#include "export.h"
#include "output.h"
#include "ugoki/files/files.h"
#include "ugoki/files/temporary_folder.h"

#include <unistd.h>

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

// Python program for Blender. Exit status 5: this Blender cannot write the format (Debian's Blender 3.4 is built without Alembic).
constexpr const char* script = R"(import sys
import bpy
import numpy

if not hasattr(numpy, "bool"):
    numpy.bool = bool  # the glTF reader of Blender 3.4 uses this name, which newer versions of NumPy have removed
source, target, rate = sys.argv[sys.argv.index("--") + 1:]
for item in list(bpy.data.objects):
    bpy.data.objects.remove(item)
scene = bpy.context.scene
scene.render.fps = round(float(rate))
scene.render.fps_base = scene.render.fps / float(rate)
bpy.ops.import_scene.gltf(filepath=source)
frames = [end for action in bpy.data.actions for end in action.frame_range]
scene.frame_start, scene.frame_end = (int(min(frames)), int(max(frames))) if frames else (0, 0)
if target.endswith(".abc"):
    if "alembic_export" not in dir(bpy.ops.wm):
        sys.exit(5)
    bpy.ops.wm.alembic_export(filepath=target, start=scene.frame_start, end=scene.frame_end, as_background_job=False)
else:
    if "fbx" not in dir(bpy.ops.export_scene):
        sys.exit(5)
    bpy.ops.export_scene.fbx(filepath=target, object_types={"ARMATURE", "MESH", "CAMERA"}, add_leaf_bones=False, bake_anim=True,
                             bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False, bake_anim_simplify_factor=0)
)";

}  // namespace

Result<void> export_with_blender(std::span<const std::byte> glb, double rate, const std::string& file, const std::string& blender) {
  const Result<std::string> program =
      find_program(blender, {"blender"}, "Install Blender (`apt-get install blender`), or name it with --blender.");
  if (!program) return fail(program.error());
  const Result<files::TemporaryFolder> scratch = files::TemporaryFolder::make("blender", "temporary folder");
  if (!scratch) return fail(scratch.error());
  const fs::path folder = scratch->path();
  const bool alembic = fs::path(file).extension() == ".abc";
  const std::string source = (folder / "content.glb").string(), code = (folder / "write.py").string(),
                    written = (folder / (alembic ? "content.abc" : "content.fbx")).string(), log = (folder / "blender.log").string();
  if (Result<void> done = files::write_file(source, glb); !done) return done;
  if (Result<void> done = files::write_file(code, std::string_view(script)); !done) return done;
  catch_interrupt();
  const Result<std::unique_ptr<Child>> child = Child::start(
      {*program, "-b", "--factory-startup", "--python-exit-code", "3", "--python", code, "--", source, written, std::to_string(rate)},
      false, log);
  if (!child) return fail(child.error());
  const bool good = (*child)->wait();
  if (interrupted()) return fail(interrupted_error());
  if ((*child)->status() == 5)
    return fail(ErrorCode::unsupported, *program,
                std::string("This Blender was built without a writer for ") + (alembic ? "Alembic" : "FBX") + ".",
                "Use the Blender of blender.org with --blender, or another format, for example --glb.");
  if (!good || !fs::exists(written))
    return fail(ErrorCode::io, *program, "Blender reported an error." + tail_of(log), "Check that Blender is version 3.4 or newer.");
  const Result<std::string> bytes = files::read_file(written, std::size_t{1} << 34);
  if (!bytes) return fail(bytes.error());
  return files::write_file(file, *bytes);
}

}  // namespace ugoki::cli
