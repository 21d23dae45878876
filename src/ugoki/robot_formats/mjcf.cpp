#include "ugoki/robot_formats/mjcf.h"

#include "ugoki/robot_formats/mjcf_build.h"

namespace ugoki::robot_formats {
namespace {

/// Converts a location in the mechanism ("link foot", "loop knee") to the location in the file: "m.xml:12, link foot".
std::string location_in_file(const std::string& location, const std::vector<std::string>& link_names,
                             const std::vector<std::string>& loop_names, const MjcfBuild& build, const MjcfElement& root) {
  const auto line = [&](const MjcfElement& e) { return e.file->location(e.node) + ", " + location; };
  for (std::size_t i = 0; i < link_names.size(); ++i)
    if (location == "link " + link_names[i]) return line(build.link_elements[i]);
  for (std::size_t i = 0; i < loop_names.size(); ++i)
    if (location == "loop " + loop_names[i]) return line(build.loop_elements[i]);
  return line(root);
}

}  // namespace

Result<RobotModel> read_mjcf(std::string_view text, std::string_view file_name, const RobotOptions& options) {
  MjcfFiles files(options.read_asset);
  MjcfSource source;
  if (!source.load(text, std::string(file_name), files)) return fail(files.take_problems());
  const MjcfElement root = source.document().root();

  MjcfBuild build{.tree = read_mjcf_tree(source, files), .options = options};
  build.spec.name = root.has("model") ? root.text("model") : formats::stem_of(file_name);
  if (!files.full()) {
    make_mjcf_links(build);
    set_mjcf_springs(build);
    read_mjcf_loops(build);
    read_mjcf_exclusions(build);
    read_mjcf_drives(build);
    read_mjcf_keyframes(build);
  }
  if (build.tree.bodies.size() == 1 && !files.failed())
    root.problem(ErrorCode::structure, "The model has no body.", "Check that the file is complete.");
  if (files.failed()) return fail(files.take_problems());
  note_mjcf_left_out(build);

  std::vector<std::string> link_names, loop_names;
  for (const LinkSpec& l : build.spec.links) link_names.push_back(l.name);
  for (const LoopSpec& l : build.spec.loops) loop_names.push_back(l.name);
  Result<MechanismPtr> mechanism = Mechanism::make(std::move(build.spec));
  if (!mechanism) {
    for (Problem& p : mechanism.error().problems) p.location = location_in_file(p.location, link_names, loop_names, build, root);
    if (mechanism.error().problems.size() > 20) mechanism.error().problems.resize(20);
    return fail(std::move(mechanism.error()));
  }
  RobotModel model;
  model.mechanism = std::move(*mechanism);
  model.joints = std::move(build.joints);
  model.X_BF = std::move(build.X_BF);
  model.driven = std::move(build.driven);
  model.positions = std::move(build.positions);
  model.meshes = std::move(build.meshes);
  model.notes = files.take_notes();
  return model;
}

}  // namespace ugoki::robot_formats
