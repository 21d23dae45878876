#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"
#include "ugoki/robot_formats/xml_fields.h"
#include "ugoki/scene_formats/mvnx.h"

namespace ugoki::scene_formats {
namespace {

using robot_formats::Bounds;
using robot_formats::XmlFields;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The usual segments of MVN and their parents, for files without <joints>.
constexpr std::array<std::pair<std::string_view, std::string_view>, 23> usual_tree = {{{"Pelvis", ""},
                                                                                       {"L5", "Pelvis"},
                                                                                       {"L3", "L5"},
                                                                                       {"T12", "L3"},
                                                                                       {"T8", "T12"},
                                                                                       {"Neck", "T8"},
                                                                                       {"Head", "Neck"},
                                                                                       {"RightShoulder", "T8"},
                                                                                       {"RightUpperArm", "RightShoulder"},
                                                                                       {"RightForeArm", "RightUpperArm"},
                                                                                       {"RightHand", "RightForeArm"},
                                                                                       {"LeftShoulder", "T8"},
                                                                                       {"LeftUpperArm", "LeftShoulder"},
                                                                                       {"LeftForeArm", "LeftUpperArm"},
                                                                                       {"LeftHand", "LeftForeArm"},
                                                                                       {"RightUpperLeg", "Pelvis"},
                                                                                       {"RightLowerLeg", "RightUpperLeg"},
                                                                                       {"RightFoot", "RightLowerLeg"},
                                                                                       {"RightToe", "RightFoot"},
                                                                                       {"LeftUpperLeg", "Pelvis"},
                                                                                       {"LeftLowerLeg", "LeftUpperLeg"},
                                                                                       {"LeftFoot", "LeftLowerLeg"},
                                                                                       {"LeftToe", "LeftFoot"}}};

struct Segment {
  std::string name;
  int parent = -1;
  std::vector<Vec3> points;  // m, points on the segment, relative to its origin
};

/// Pose of all segments in one frame, world axes.
struct Frame {
  std::vector<Vec3> p;  // m
  std::vector<Quat> q;
};

class Reader {
 public:
  Reader(std::string_view file_name, formats::ReadNotes& notes) : fields_(file_name, "MVNX"), name_(file_name), notes_(notes) {}

  Result<MeasuredMotion> read(std::string_view text) {
    if (!fields_.parse(text)) return fail(fields_.take_problems());
    const pugi::xml_node root = fields_.root();
    const pugi::xml_node subject = root.child("subject");
    if (std::string_view(root.name()) != "mvnx" || !subject)
      fields_.problem(root, ErrorCode::syntax,
                      "The outermost element is <" + std::string(root.name()).substr(0, 40) + ">, not <mvnx> with a <subject>.",
                      "Export the recording as MVNX from MVN.");
    else if (read_segments(subject) && read_joints(subject) && sort_segments(subject))
      read_frames(subject);
    if (!fields_.failed() && root.select_nodes("subject").size() > 1)
      notes_.remarks.push_back("The file contains " + std::to_string(root.select_nodes("subject").size()) + " subjects; the first, " +
                               fields_.text(fields_.attribute(subject, "label")) + ", was read.");
    if (fields_.failed()) return fail(fields_.take_problems());
    return motion(subject);
  }

 private:
  bool read_segments(pugi::xml_node subject) {
    for (const pugi::xml_node node : subject.child("segments").children("segment")) {
      Segment s;
      s.name = fields_.required_text(fields_.attribute(node, "label"));
      if (index_.contains(s.name))
        fields_.problem(node, ErrorCode::duplicate, "Two segments are called '" + s.name + "'.", "Rename one of them.");
      index_.emplace(s.name, static_cast<int>(segments_.size()));
      for (const pugi::xml_node point : node.child("points").children("point"))
        for (const char* key : {"pos_b", "pos_s"})
          if (const auto field = fields_.element(point, key); field.present) s.points.push_back(fields_.vec3(field, {}));
      segments_.push_back(std::move(s));
      if (fields_.full()) return false;
    }
    if (segments_.empty())
      fields_.problem(subject, ErrorCode::structure, "The subject has no <segments>.", "Export the recording with its segments.");
    else if (segments_.size() > formats::max_joints)
      fields_.problem(subject, ErrorCode::range, "The subject has more than 10000 segments.", "Export fewer segments.");
    return !fields_.failed();
  }

  bool read_joints(pugi::xml_node subject) {
    const pugi::xml_node joints = subject.child("joints");
    if (!joints.child("joint")) {
      for (const auto& [name, parent] : usual_tree)
        if (const auto child = index_.find(name), above = index_.find(parent); child != index_.end() && above != index_.end())
          segments_[at(child->second)].parent = above->second;
      notes_.remarks.push_back("The file has no <joints>; the usual tree of MVN's segments is assumed.");
      return true;
    }
    for (const pugi::xml_node node : joints.children("joint")) {
      int ends[2] = {-1, -1};
      for (int k = 0; k < 2; ++k) {
        const auto field = fields_.element(node, k == 0 ? "connector1" : "connector2");
        const std::string text = fields_.required_text(field);
        const auto found = index_.find(text.substr(0, text.find('/')));
        if (found == index_.end())
          fields_.problem(node, ErrorCode::unknown, "The joint connects '" + text + "', but there is no such segment.",
                          "Correct the connectors.");
        else
          ends[k] = found->second;
      }
      if (fields_.full()) return false;
      if (ends[0] >= 0 && ends[1] >= 0) segments_[at(ends[1])].parent = ends[0];
    }
    return !fields_.failed();
  }

  /// Fills order_ with the segments, parents first.
  bool sort_segments(pugi::xml_node subject) {
    std::vector<char> done(segments_.size(), 0);
    while (order_.size() < segments_.size()) {
      const std::size_t before = order_.size();
      for (std::size_t i = 0; i < segments_.size(); ++i) {
        const int parent = segments_[i].parent;
        if (done[i] != 0 || (parent >= 0 && done[at(parent)] == 0)) continue;
        done[i] = 1;
        order_.push_back(i);
      }
      if (order_.size() > before) continue;
      fields_.problem(subject.child("joints"), ErrorCode::structure, "The joints form a loop of segments.", "Correct the connectors.");
      return false;
    }
    return true;
  }

  void read_frames(pugi::xml_node subject) {
    const std::size_t n = segments_.size();
    const pugi::xml_node list = subject.child("frames");
    std::size_t poses = 0;
    for (const pugi::xml_node node : list.children("frame")) {
      const std::string type = fields_.text(fields_.attribute(node, "type"));
      if (!type.empty() && type != "normal") {
        ++poses;
        continue;
      }
      const std::vector<double> q = fields_.list(fields_.element(node, "orientation"), 4 * n, 4 * n);
      const std::vector<double> p = fields_.list(fields_.element(node, "position"), 3 * n, 3 * n);
      if (q.empty() || p.empty()) {
        if (!fields_.failed())
          fields_.problem(node, ErrorCode::structure, "The frame has no <orientation> or no <position>.",
                          "Export the recording with orientations and positions of the segments.");
        if (fields_.full()) return;
        continue;
      }
      Frame f;
      for (std::size_t i = 0; i < n; ++i) {
        const Quat turn{q[4 * i], q[4 * i + 1], q[4 * i + 2], q[4 * i + 3]};
        const double size = std::sqrt(turn.w * turn.w + turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
        if (!(size > 0.5 && size < 2)) {
          fields_.problem(
              node, ErrorCode::range,
              "The orientation of segment '" + segments_[i].name + "' is a quaternion of length " + to_fixed(size, 3) + ", not 1.",
              "Export the file again.");
          if (fields_.full()) return;
        }
        f.q.push_back(size > 0.5 ? normalized(turn) : Quat{});
        f.p.push_back({p[3 * i], p[3 * i + 1], p[3 * i + 2]});
      }
      frames_.push_back(std::move(f));
    }
    if (frames_.empty() && !fields_.failed())
      fields_.problem(list ? list : subject, ErrorCode::truncated, "The file has no frames of type 'normal'.",
                      "Export the recording again.");
    if (poses > 0 && !frames_.empty()) notes_.remarks.push_back(std::to_string(poses) + " frames with calibration poses were left out.");
  }

  /// Offset [m] of segment i from its parent: the median over the frames, in the parent's frame. @param spread receives the largest
  /// deviation
  [[nodiscard]] Vec3 offset_of(std::size_t i, double& spread) const {
    const std::size_t parent = at(segments_[i].parent);
    std::array<std::vector<double>, 3> values;
    for (const Frame& f : frames_) {
      const Vec3 d = transpose_times(to_matrix(f.q[parent]), f.p[i] - f.p[parent]);
      for (int k = 0; k < 3; ++k) values[at(k)].push_back(d[k]);
    }
    Vec3 out;
    spread = 0;
    for (int k = 0; k < 3; ++k) {
      std::vector<double>& v = values[at(k)];
      const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
      std::nth_element(v.begin(), middle, v.end());
      out[k] = *middle;
      for (const double x : v) spread = std::max(spread, std::fabs(x - out[k]));
    }
    return out;
  }

  MeasuredMotion motion(pugi::xml_node subject) {
    MeasuredMotion m;
    m.name = formats::stem_of(name_);
    m.source = std::string(name_);
    m.skeleton.name = m.name;
    m.rate = fields_.number(fields_.attribute(subject, "frameRate"), 0, {0, 1e6});
    if (!(m.rate > 0)) {
      m.rate = 60;
      notes_.remarks.push_back("The file does not state its frame rate; 60 frames per second are assumed.");
    }
    m.frames = static_cast<int>(frames_.size());
    notes_.frame_time = 1 / m.rate;
    notes_.metres_per_unit = 1;
    notes_.z_up = true;
    std::vector<int> joint_of(segments_.size(), -1);
    std::vector<char> leaf(segments_.size(), 1);
    for (const Segment& s : segments_)
      if (s.parent >= 0) leaf[at(s.parent)] = 0;
    for (const std::size_t i : order_) {
      const Segment& s = segments_[i];
      SkeletonJoint j;
      j.name = s.name;
      j.parent = s.parent < 0 ? -1 : joint_of[at(s.parent)];
      double spread = 0;
      j.offset = s.parent < 0 ? frames_[0].p[i] : offset_of(i, spread);
      j.translates = s.parent < 0 || spread > 0.02;  // rounded positions and orientations of segments disagree by millimetres
      j.dofs = {{{0, 0, 1}}, {{0, 1, 0}}, {{1, 0, 0}}};
      if (leaf[i] != 0 && !s.points.empty()) {
        const Vec3 end = *std::ranges::max_element(s.points, {}, [](const Vec3& p) { return norm(p); });
        if (norm(end) > 0) j.end_sites.push_back(end);
      }
      joint_of[i] = static_cast<int>(m.skeleton.joints.size());
      m.skeleton.joints.push_back(std::move(j));
    }
    for (const Frame& f : frames_)
      for (const std::size_t i : order_) {
        const SkeletonJoint& j = m.skeleton.joints[at(joint_of[i])];
        if (j.parent < 0) {
          m.translations.push_back(f.p[i]);
          m.rotations.push_back(f.q[i]);
          continue;
        }
        const std::size_t parent = at(segments_[i].parent);
        m.translations.push_back(j.translates ? transpose_times(to_matrix(f.q[parent]), f.p[i] - f.p[parent]) : j.offset);
        m.rotations.push_back(f.q[parent].conjugate() * f.q[i]);
      }
    return m;
  }

  XmlFields fields_;
  std::string_view name_;
  formats::ReadNotes& notes_;
  std::vector<Segment> segments_;                  // in the order of the file
  std::map<std::string, int, std::less<>> index_;  // segment by name
  std::vector<std::size_t> order_;                 // segments, parents first
  std::vector<Frame> frames_;                      // [frames][segments]
};

}  // namespace

Result<MeasuredMotion> read_mvnx(std::string_view text, std::string_view file_name, formats::ReadNotes* notes) {
  formats::ReadNotes own;
  return Reader(file_name, notes != nullptr ? *notes : own).read(text);
}

}  // namespace ugoki::scene_formats
