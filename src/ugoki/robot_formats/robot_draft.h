#pragma once
// A mechanism on its way from a description to a RobotModel: what all readers do at the end; internal to robot_formats.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/robot_model.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

/// What the description tells about one link beside its LinkSpec.
struct DraftLink {
  pugi::xml_node node = {};
  std::string joint = {};  ///< name of its joint in the file; empty: none
  bool base_open = false;  ///< nothing joins it to the world: the options decide
  Pose X_BF = {};          ///< RobotModel::X_BF
};

class RobotDraft {
 public:
  RobotDraft(XmlFields& xml, const RobotOptions& options) : xml_(xml), options_(options) {}

  MechanismSpec spec;
  std::vector<DraftLink> links;  ///< beside spec.links
  std::vector<JointName> loop_joints;
  std::vector<std::string> driven;

  /// Index of the new link; -1 with a problem where its name is taken.
  int add_link(LinkSpec link, DraftLink draft);
  /// -1: none.
  [[nodiscard]] int find_link(std::string_view name) const;
  [[nodiscard]] LinkSpec& link(int i) { return spec.links[static_cast<std::size_t>(i)]; }
  [[nodiscard]] DraftLink& draft(int i) { return links[static_cast<std::size_t>(i)]; }

  /// Decides open bases, repairs inertias, gives weightless joints an inertia (or refuses both), and makes the mechanism.
  /// Problems name the line of their link.
  [[nodiscard]] Result<RobotModel> finish();

 private:
  [[nodiscard]] std::vector<int> parents_first();
  void repair_inertias();
  void decide_bases(const std::vector<int>& order);
  void weigh_joints(const std::vector<int>& order);

  XmlFields& xml_;
  const RobotOptions& options_;
  std::map<std::string, int, std::less<>> index_;
  std::vector<int> parents_;
};

/// "a, b, c and 9 more"
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

}  // namespace ugoki::robot_formats
