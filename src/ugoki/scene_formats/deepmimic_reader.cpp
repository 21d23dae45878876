#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "ugoki/formats/text.h"
#include "ugoki/json/json.h"
#include "ugoki/scene_formats/deepmimic.h"

namespace ugoki::scene_formats {
namespace {

using json::Json;

enum class Kind { root, fixed, revolute, spherical };
struct Joint {
  std::string name;
  int parent = -1;
  Kind kind = Kind::fixed;
  Vec3 offset;  // m, in the file's axes: X forward, Y up, Z right
  Vec3 end;     // m, from the joint to the far end of its body; zero: unknown
};

std::size_t at(int i) { return static_cast<std::size_t>(i); }
int values_of(Kind kind) { return kind == Kind::root ? 7 : kind == Kind::spherical ? 4 : kind == Kind::revolute ? 1 : 0; }
Vec3 to_z_up(const Vec3& v) { return {v.x, -v.z, v.y}; }

/// The humanoid to which the published motions belong. Lengths in metres.
std::vector<Joint> humanoid() {
  std::vector<Joint> joints = {{"root", -1, Kind::root, {}, {}},
                               {"chest", 0, Kind::spherical, {0, 0.236151, 0}, {}},
                               {"neck", 1, Kind::spherical, {0, 0.223894, 0}, {0, 0.28, 0}}};
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? "right_" : "left_";
    const int first = static_cast<int>(joints.size());
    joints.push_back({s + "hip", 0, Kind::spherical, {0, 0, 0.084887 * side}, {}});
    joints.push_back({s + "knee", first, Kind::revolute, {0, -0.421546, 0}, {}});
    joints.push_back({s + "ankle", first + 1, Kind::spherical, {0, -0.40987, 0}, {0.133, -0.05, 0}});
    joints.push_back({s + "shoulder", 1, Kind::spherical, {-0.02405, 0.2435, 0.18311 * side}, {}});
    joints.push_back({s + "elbow", first + 3, Kind::revolute, {0, -0.274788, 0}, {}});
    joints.push_back({s + "wrist", first + 4, Kind::fixed, {0, -0.258947, 0}, {0, -0.08, 0}});
  }
  return joints;
}

Error problem(std::string_view file, const std::string& where, ErrorCode code, std::string message, std::string remedy) {
  return {code, std::string(file) + (where.empty() ? "" : ":" + where), std::move(message), std::move(remedy)};
}

double number_in(const Json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_number() ? it->get<double>() : 0.0;
}

std::string text_in(const Json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

Result<std::vector<Joint>> read_character(std::string_view text, std::string_view file) {
  Result<Json> json = json::parse_json(text, file);
  if (!json) return fail(std::move(json.error()));
  const auto bad = [&](const std::string& where, std::string what) {
    return fail(problem(file, where, ErrorCode::structure, std::move(what), "Give a character file of DeepMimic."));
  };
  const Json* list = nullptr;
  if (json->is_object())
    if (const auto skeleton = json->find("Skeleton"); skeleton != json->end() && skeleton->is_object())
      if (const auto found = skeleton->find("Joints"); found != skeleton->end() && found->is_array()) list = &*found;
  if (list == nullptr || list->empty() || list->size() > formats::max_joints)
    return bad("Skeleton/Joints", "The character has no joints, or more than 10000.");
  std::vector<Joint> out;
  for (const Json& j : *list) {
    const std::string where = "Skeleton/Joints/" + std::to_string(out.size());
    if (!j.is_object()) return bad(where, "The joint is not an object.");
    Joint joint;
    joint.name = text_in(j, "Name");
    if (joint.name.empty()) joint.name = "joint " + std::to_string(out.size());
    const double parent = number_in(j, "Parent");
    const std::string type = text_in(j, "Type");
    if (out.empty())
      joint.kind = Kind::root;
    else if (type == "spherical" || type == "revolute" || type == "fixed")
      joint.kind = type[0] == 's' ? Kind::spherical : type[0] == 'r' ? Kind::revolute : Kind::fixed;
    else
      return bad(where, "The joint type " + formats::in_quotes(type) + " is not supported.");
    if (!out.empty() && !(parent >= 0 && parent < static_cast<double>(out.size())))
      return bad(where, "The parent of the joint must stand before it in the list.");
    joint.parent = out.empty() ? -1 : static_cast<int>(parent);
    joint.offset = {number_in(j, "AttachX"), number_in(j, "AttachY"), number_in(j, "AttachZ")};
    for (const char* key : {"AttachThetaX", "AttachThetaY", "AttachThetaZ"})
      if (number_in(j, key) != 0) return bad(where, "A joint with a turned frame (" + std::string(key) + ") is not supported.");
    if (!is_finite(joint.offset) || norm(joint.offset) > 1e4) return bad(where, "The position of the joint is out of range.");
    out.push_back(std::move(joint));
  }
  // The far end of a body is twice as far as its centre.
  if (const auto bodies = json->find("BodyDefs"); bodies != json->end() && bodies->is_array())
    for (std::size_t i = 0; i < std::min(bodies->size(), out.size()); ++i)
      if (const Json& b = (*bodies)[i]; b.is_object()) {
        const Vec3 centre{number_in(b, "AttachX"), number_in(b, "AttachY"), number_in(b, "AttachZ")};
        if (is_finite(centre) && norm(centre) < 1e4) out[i].end = centre * 2;
      }
  return out;
}

/// One frame: values after its duration.
Result<std::vector<double>> numbers_of(const Json& frame, std::string_view file, std::size_t index, std::size_t count) {
  const std::string where = "Frames/" + std::to_string(index);
  if (!frame.is_array() || frame.size() != count)
    return fail(problem(file, where, ErrorCode::structure,
                        "The frame has " + std::to_string(frame.is_array() ? frame.size() : 0) + " numbers, but the character needs " +
                            std::to_string(count) + ".",
                        "Give the character file of this motion with --skeleton FILE."));
  std::vector<double> out;
  for (const Json& n : frame) {
    if (!n.is_number() || !(std::fabs(n.get<double>()) <= formats::max_magnitude))
      return fail(problem(file, where, ErrorCode::syntax, "The frame contains something that is not a usable number.", "Correct it."));
    out.push_back(n.get<double>());
  }
  return out;
}

}  // namespace

Result<MeasuredMotion> read_deepmimic(std::string_view text, std::string_view file_name, std::string_view character,
                                      std::string_view character_name, formats::ReadNotes* notes) {
  Result<Json> json = json::parse_json(text, file_name);
  if (!json) return fail(std::move(json.error()));
  const auto frames = json->is_object() ? json->find("Frames") : json->end();
  if (!json->is_object() || frames == json->end() || !frames->is_array() || frames->empty() || frames->size() > 10'000'000)
    return fail(problem(file_name, "", ErrorCode::structure, "The text has no list 'Frames', so it is not a motion of DeepMimic.",
                        "Give a motion file of DeepMimic."));
  std::vector<Joint> joints = humanoid();
  if (!character.empty()) {
    Result<std::vector<Joint>> own = read_character(character, character_name);
    if (!own) return fail(std::move(own.error()));
    joints = std::move(*own);
  }
  std::size_t count = 1;
  for (const Joint& j : joints) count += at(values_of(j.kind));
  if (frames->size() * joints.size() > formats::max_numbers / 8)
    return fail(problem(file_name, "Frames", ErrorCode::range, "The motion is too large.", "Give a shorter motion."));

  std::vector<std::vector<double>> rows;
  std::vector<double> times;
  double time = 0;
  for (std::size_t f = 0; f < frames->size(); ++f) {
    Result<std::vector<double>> row = numbers_of((*frames)[f], file_name, f, count);
    if (!row) return fail(std::move(row.error()));
    const double duration = (*row)[0];
    if (f + 1 < frames->size() && !(duration > 1e-5 && duration < 3600))
      return fail(problem(file_name, "Frames/" + std::to_string(f), ErrorCode::range, "The duration of the frame is not above zero.",
                          "Correct the first number of the frame (seconds)."));
    times.push_back(time);
    time += duration;
    rows.push_back(std::move(*row));
  }
  const std::size_t n = rows.size();
  bool even = true;
  for (std::size_t f = 0; f + 1 < n; ++f) even = even && std::fabs(rows[f][0] - rows[0][0]) < 0.01 * rows[0][0];
  MeasuredMotion out;
  out.name = formats::stem_of(file_name);
  out.source = std::string(file_name);
  out.skeleton.name = character.empty() ? "humanoid" : formats::stem_of(character_name);
  out.rate = n > 1 && even ? static_cast<double>(n - 1) / times.back() : 60;
  if (std::fabs(out.rate - std::round(out.rate)) < 1e-3 * out.rate) out.rate = std::round(out.rate);
  const double length = n > 1 ? times.back() : 0;
  if (length > 7200 || out.rate > 2000)
    return fail(problem(file_name, "Frames", ErrorCode::range,
                        "The motion is longer than two hours, or has more than 2000 frames per second.",
                        "Correct the durations of the frames."));
  if (!even && notes != nullptr)
    notes->remarks.push_back("The frames have different durations; the motion is interpolated to 60 frames per second.");
  out.frames = even ? static_cast<int>(n) : static_cast<int>(std::floor(length * out.rate + 1e-6)) + 1;

  std::vector<Vec3> ends;
  for (const Joint& j : joints) {
    SkeletonJoint joint;
    joint.name = j.name;
    joint.parent = j.parent;
    joint.offset = to_z_up(j.offset);
    joint.translates = j.kind == Kind::root;
    if (j.kind == Kind::revolute) joint.dofs.push_back({{0, -1, 0}, false, 0, 0});
    if (j.kind == Kind::root || j.kind == Kind::spherical)
      for (const Vec3& axis : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}) joint.dofs.push_back({axis, false, 0, 0});
    const bool leaf = std::none_of(joints.begin(), joints.end(),
                                   [&](const Joint& o) { return o.parent == static_cast<int>(out.skeleton.joints.size()); });
    if (leaf && norm(j.end) > 0) joint.end_sites.push_back(to_z_up(j.end));
    out.skeleton.joints.push_back(std::move(joint));
  }
  // World axes: (x, y, z) of the file is (x, -z, y). The same rotation turns the vector part of a quaternion.
  const auto quaternion = [](const std::vector<double>& row, std::size_t i) {
    const Vec3 v = to_z_up({row[i + 1], row[i + 2], row[i + 3]});
    // Scaled first, because the squares of values above 1e154 overflow.
    const double size = std::max({std::fabs(row[i]), std::fabs(v.x), std::fabs(v.y), std::fabs(v.z), 1e-300});
    return normalized(Quat{row[i] / size, v.x / size, v.y / size, v.z / size});
  };
  std::size_t low = 0;
  for (int f = 0; f < out.frames; ++f) {
    std::size_t a = at(f), b = a;
    double part = 0;
    if (!even) {
      const double t = f / out.rate;
      while (low + 2 < n && times[low + 1] <= t) ++low;
      a = low;
      b = low + 1;
      part = std::clamp((t - times[a]) / (times[b] - times[a]), 0.0, 1.0);
    }
    std::size_t i = 1;
    for (const Joint& j : joints) {
      Vec3 p = to_z_up(j.offset);
      Quat q;
      const auto at_row = [&](const std::vector<double>& row, Vec3& position) {
        if (j.kind == Kind::root) position = to_z_up({row[i], row[i + 1], row[i + 2]});
        if (j.kind == Kind::root || j.kind == Kind::spherical) return quaternion(row, j.kind == Kind::root ? i + 3 : i);
        return j.kind == Kind::revolute ? axis_angle({0, -1, 0}, std::remainder(row[i], 2 * pi)) : Quat{};
      };
      q = at_row(rows[a], p);
      if (part > 0) {
        Vec3 p2 = p;
        q = slerp(q, at_row(rows[b], p2), part);
        p += (p2 - p) * part;
      }
      i += at(values_of(j.kind));
      out.translations.push_back(p);
      out.rotations.push_back(q);
    }
  }
  return out;
}

}  // namespace ugoki::scene_formats
