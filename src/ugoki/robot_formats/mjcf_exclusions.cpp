// <contact> of MJCF: pairs of bodies that do not collide.

#include "ugoki/robot_formats/mjcf_build.h"

namespace ugoki::robot_formats {

void read_mjcf_exclusions(MjcfBuild& build) {
  for (const MjcfPart& part : build.tree.parts)
    for (const MjcfElement& section : part.source->document().sections("contact"))
      for (const MjcfElement& e : part.source->document().children(section)) {
        if (e.kind() == "pair") e.note("Rules that let two shapes collide, whatever their groups are (<pair>), are left out.");
        if (e.kind() != "exclude") continue;
        const std::string names[2] = {e.text("body1"), e.text("body2")};
        for (const MjcfPart& copy : build.matching_parts(e, part, {{"body", names[0]}, {"body", names[1]}})) {
          const auto link = [&](const std::string& name) {
            return build.tree.bodies[static_cast<std::size_t>(build.find_body(copy, name))].link;
          };
          const int a = link(names[0]), b = link(names[1]);
          if (a < 0 || b < 0 || a == b) continue;  // the body has no link because it has no shapes; or both are the world
          build.spec.exclusions.push_back(
              {build.spec.links[static_cast<std::size_t>(a)].name, build.spec.links[static_cast<std::size_t>(b)].name});
        }
      }
}

}  // namespace ugoki::robot_formats
