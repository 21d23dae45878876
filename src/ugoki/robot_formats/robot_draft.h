#pragma once
// A mechanism under construction, and the steps that all readers share after their file is parsed. Internal to robot_formats.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/robot_model.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

/// Data of one link in addition to its LinkSpec.
struct DraftLink {
  pugi::xml_node node = {};  ///< element of the link, for error locations
  std::string joint = {};    ///< name of the link's joint in the file; empty: none
  bool base_open = false;    ///< true: no joint of the file connects the link to the world, so options.base decides
  Pose X_BF = {};            ///< see RobotModel::X_BF
};

/// Collects links and loops, then completes and checks them and makes the mechanism.
class RobotDraft {
 public:
  RobotDraft(XmlFields& xml, const RobotOptions& options) : xml_(xml), options_(options) {}

  MechanismSpec spec;
  std::vector<DraftLink> links;  ///< [spec.links]
  std::vector<JointName> loop_joints;
  std::vector<std::string> driven;

  /// Adds a link and returns its index. If there is a link of the same name, adds a problem and returns -1.
  int add_link(LinkSpec link, DraftLink draft);
  /// Index of the link; -1: none.
  [[nodiscard]] int find_link(std::string_view name) const;
  [[nodiscard]] LinkSpec& link(int i) { return spec.links[static_cast<std::size_t>(i)]; }
  [[nodiscard]] DraftLink& draft(int i) { return links[static_cast<std::size_t>(i)]; }

  /// Makes the mechanism. Before that, repairs impossible inertias, connects the bases to the world by fixed or floating joints, and gives
  /// an armature to joints that move no mass. With Inertias::strict such inertias and joints are refused. Problems contain the link's line.
  [[nodiscard]] Result<RobotModel> finish();

 private:
  [[nodiscard]] std::vector<int> parents_first();
  void repair_inertias();
  void decide_bases(const std::vector<int>& order);
  void add_armature_to_massless_joints(const std::vector<int>& order);

  XmlFields& xml_;
  const RobotOptions& options_;
  std::map<std::string, int, std::less<>> index_;
  std::vector<int> parents_;
};

/// Returns the names as one phrase: "a, b, c, d and 9 more".
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

}  // namespace ugoki::robot_formats
