#include "mechanism_info.h"

#include <map>

#include "mesh_info.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/loop_diagnosis.h"

namespace ugoki::cli {
namespace {

constexpr long largest_analysis = 20'000'000;  // maximum number of matrix entries; larger analyses would take too long

std::string link_name(const Mechanism& m, int link) { return link < 0 ? "the world" : m.link(link).name; }

/// Name of a constraint row of a closed loop, for messages: "loop knee: rotation about y".
std::string row_text(const dynamics::ClosedWorkspace& cw, int row) {
  std::size_t i = 0;
  while (cw.rows.first[i + 1] <= row) ++i;
  return cw.loops[i].name + ": " + std::string(dynamics::row_name(cw.loops[i].type, row - cw.rows.first[i]));
}

/// Closes the loops, starting from the neutral position, and analyses the remaining degrees of freedom. Null: not analysed.
Json closure_json(const Mechanism& m, Json& findings) {
  long rows = 0;
  for (const Loop& loop : m.loops()) rows += loop.closed ? loop.rows() : 0;
  if (rows == 0) return nullptr;
  if (rows * m.nv() > largest_analysis) {
    findings.push_back("The loops were not analysed, because the mechanism is too large.");
    return nullptr;
  }
  dynamics::ClosedWorkspace cw(m);
  std::vector<double> q = m.neutral();
  const dynamics::Closure closure = dynamics::assemble(m, q, cw);
  if (!closure.closed) {
    for (const Problem& p : dynamics::explain_gap(m, cw, closure).problems) findings.push_back("The loops do not close: " + p.text());
    return Json{{"closes", false}, {"rows", rows}, {"gap", closure.gap}};
  }
  const dynamics::LoopDiagnosis d = dynamics::diagnose_loops(m, q, cw);
  Json redundant = Json::array();
  for (const int row : d.redundant) redundant.push_back(row_text(cw, row));
  findings.push_back(dynamics::describe(d, cw));
  if (d.dofs == 0) findings.push_back("The loops leave no degree of freedom: the mechanism cannot move.");
  return Json{{"closes", true}, {"degrees_of_freedom", d.dofs}, {"rows", d.rows}, {"rank", d.rank}, {"redundant", std::move(redundant)}};
}

/// Reports a joint that moves no inertia, so that its acceleration is undefined.
void find_weightless(const Mechanism& m, Json& findings) {
  dynamics::Workspace ws(m);
  const std::vector<double> q = m.neutral(), zero(static_cast<std::size_t>(m.nv()), 0.0);
  std::vector<double> vdot(zero.size());
  if (dynamics::calc_forward_dynamics(m, ws, q, zero, zero, {0, 0, -9.81}, {}, vdot)) return;
  std::string where = "a joint";
  if (static_cast<long>(m.nv()) * m.nv() <= largest_analysis) {
    dynamics::update_kinematics(m, q, zero, ws);
    dynamics::calc_inertia_rows(m, ws);
    if (const int i = dynamics::factor(ws, {}); i >= 0) where = "the joint of " + m.link(m.link_of_dof(i)).name;
  }
  findings.push_back("In the neutral position " + where +
                     " moves no inertia: its acceleration is undefined. Give a link behind it a mass, or the joint an armature.");
}

}  // namespace

Json mechanism_json(const Mechanism& m, const robot_formats::RobotModel* robot) {
  std::map<std::string, std::string> joint_of;
  if (robot)
    for (const robot_formats::JointName& j : robot->joints) joint_of[j.link] = j.joint;
  Json joints = Json::object(), links = Json::array(), loops = Json::array(), findings = Json::array();
  for (const Link& link : m.links()) {
    const std::string type(name_of(link.joint.type));
    joints[type] = joints.value(type, 0) + 1;
    Json row = {{"name", link.name},       {"label", link.label},          {"parent", link.parent},       {"joint", type},
                {"dofs", link.joint.nv()}, {"mass_kg", link.inertia.mass}, {"shapes", link.shapes.size()}};
    if (robot) row["joint_name"] = joint_of.contains(link.name) ? joint_of[link.name] : "";
    links.push_back(std::move(row));
  }
  for (const Loop& loop : m.loops())
    loops.push_back({{"name", loop.name},
                     {"type", name_of(loop.type)},
                     {"a", link_name(m, loop.link_a)},
                     {"b", link_name(m, loop.link_b)},
                     {"rows", loop.rows()},
                     {"closed", loop.closed}});
  Json json = {{"name", m.name()},      {"links_count", m.link_count()}, {"joints", std::move(joints)}, {"dofs", m.nv()},
               {"coordinates", m.nq()}, {"mass_kg", m.mass()},           {"loops", std::move(loops)}};
  if (Json closure = closure_json(m, findings); !closure.is_null()) json["closure"] = std::move(closure);
  find_weightless(m, findings);
  if (!findings.empty()) json["findings"] = std::move(findings);
  if (robot && !robot->driven.empty()) json["driven"] = robot->driven;
  if (Json meshes = meshes_json(m, robot); !meshes.is_null()) json["meshes"] = std::move(meshes);
  if (Json fields = height_fields_json(m); !fields.is_null()) json["height_fields"] = std::move(fields);
  json["links"] = std::move(links);
  return json;
}

}  // namespace ugoki::cli
