#include "ugoki/robot_formats/osim.h"

#include <cmath>
#include <cstdio>

#include "ugoki/robot_formats/osim_model.h"
#include "ugoki/robot_formats/robot_draft.h"

namespace ugoki::robot_formats {
namespace {

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

}  // namespace

Result<RobotModel> read_osim(std::string_view text, std::string_view file_name, const RobotOptions& options) {
  XmlFields xml(file_name, "OpenSim");
  if (!xml.parse(text)) return fail(xml.take_problems());
  OsimModel model;
  if (!read_osim_model(xml, model)) return fail(xml.take_problems());

  RobotDraft draft(xml, options);
  draft.spec.name = model.name;
  std::vector<Pose> X_BF(model.bodies.size());  // the body's frame in its link's frame
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const OsimBody& body = model.bodies[i];
    const Pose ground{model.to_world, {}};
    if (body.joint.empty()) {
      LinkSpec link;
      link.name = body.name;
      link.joint.X_PJ = ground;
      link.inertia = body.inertia;
      (void)draft.add_link(std::move(link), {.node = body.node, .base_open = true});
      continue;
    }
    const OsimJointFit fit = fit_joint(model, body);
    if (fit.deviation > 1e-4 || fit.turn > 1e-3)
      xml.note(body.node, "The joint " + formats::in_quotes(body.joint) +
                              " moves along curves; it is replaced by the nearest joint, which differs by up to " +
                              rounded(1000 * fit.deviation) + " mm and " + rounded(fit.turn * 57.29577951308232) + " degrees.");
    X_BF[i] = fit.X_LM * body.X_BM.inverse();
    const auto parent = static_cast<std::size_t>(body.parent < 0 ? 0 : body.parent);
    Pose X_PJ = (body.parent < 0 ? ground : X_BF[parent]) * body.X_PF;
    std::string above = body.parent < 0 ? std::string() : model.bodies[parent].name;
    for (std::size_t s = 0; s < fit.chain.size(); ++s) {
      const bool last = s + 1 == fit.chain.size();
      LinkSpec link;
      link.name = last ? body.name : body.name + ":" + std::to_string(s + 1);
      link.parent = above;
      link.joint = fit.chain[s].joint;
      link.joint.X_PJ = X_PJ * link.joint.X_PJ;
      if (last) {
        link.inertia = body.inertia.in_parent(X_BF[i]);
        for (const OsimBody::Sphere& c : body.contacts) {
          link.shapes.push_back(Shape::sphere(c.radius, {Mat3::identity(), X_BF[i] * c.centre}));
        }
      }
      above = link.name;
      X_PJ = {};
      (void)draft.add_link(std::move(link), {.node = body.node, .joint = last ? body.joint : std::string(), .X_BF = X_BF[i]});
    }
  }
  return draft.finish();
}

}  // namespace ugoki::robot_formats
