#include "ugoki/retarget/mapping.h"

#include <cmath>

#include "ugoki/json/json.h"

namespace ugoki::retarget {
namespace {

using json::Json;

/// Reads one mapping file and collects its problems (at most 50).
class Reader {
 public:
  explicit Reader(std::string_view file) : file_(file) {}

  Result<Mapping> read(const Json& root) {
    Mapping out;
    if (!root.is_object()) {
      problem("", "The mapping is " + std::string(json::type_of(root)) + ", not an object.", "Write a JSON object (docs/retarget.md).");
      return fail(std::move(error_));
    }
    for (const auto& [key, value] : root.items()) {
      if (key == "source")
        read_character(value, "/source", out.source);
      else if (key == "target")
        read_character(value, "/target", out.target);
      else if (key == "links")
        read_links(value, out);
      else if (key == "soles")
        read_soles(value, out);
      else if (key == "speed")
        out.speed = number(value, "/speed");
      else if (key == "speeds")
        read_speeds(value, out);
      else
        problem("/" + key, "This key is unknown.", "Use one of source, target, links, soles, speed and speeds.");
    }
    if (!error_.empty()) return fail(std::move(error_));
    return out;
  }

 private:
  void problem(const std::string& path, std::string message, std::string remedy) {
    if (error_.problems.size() < 50) error_.add(ErrorCode::syntax, file_ + path, std::move(message), std::move(remedy));
  }
  std::string text(const Json& value, const std::string& path) {
    if (value.is_string()) return value.get<std::string>();
    problem(path, "A link name is expected, not " + std::string(json::type_of(value)) + ".", "Write it in quotation marks.");
    return {};
  }
  double number(const Json& value, const std::string& path) {
    if (value.is_number() && std::isfinite(value.get<double>()) && value.get<double>() > 0) return value.get<double>();
    problem(path, "A number above zero is expected.", "Give the speed in rad/s (m/s for sliding joints).");
    return 0;
  }
  bool object(const Json& value, const std::string& path) {
    if (value.is_object()) return true;
    problem(path, "An object is expected, not " + std::string(json::type_of(value)) + ".", "See docs/retarget.md.");
    return false;
  }
  bool array(const Json& value, const std::string& path) {
    if (value.is_array()) return true;
    problem(path, "A list is expected, not " + std::string(json::type_of(value)) + ".", "See docs/retarget.md.");
    return false;
  }

  void read_character(const Json& value, const std::string& path, AnatomyNames& out) {
    if (!object(value, path)) return;
    for (const auto& [key, item] : value.items()) {
      const std::string here = path + "/" + key;
      int limb = -1;
      for (int k = 0; k < limb_count; ++k)
        if (key == name_of(static_cast<LimbName>(k))) limb = k;
      if (limb >= 0)
        read_limb(item, here, out.limbs[static_cast<std::size_t>(limb)]);
      else if (key == "pelvis")
        out.pelvis = text(item, here);
      else if (key == "chest")
        out.chest = text(item, here);
      else if (key == "head")
        out.head = text(item, here);
      else if (key == "tail" && array(item, here))
        for (const Json& name : item) out.tail.push_back(text(name, here));
      else if (key == "legs" && item.is_number_integer() && (item == 2 || item == 4))
        out.four_legs = item == 4 ? 1 : 0;
      else if (key != "tail")
        problem(here, "This key is unknown in a character.",
                "Use one of pelvis, chest, head, tail, legs (2 or 4), left leg, right leg, left arm and right arm.");
    }
  }
  void read_limb(const Json& value, const std::string& path, std::array<std::string, slot_count>& out) {
    if (!object(value, path)) return;
    for (const auto& [key, item] : value.items()) {
      int slot = -1;
      for (int s = 0; s < slot_count; ++s)
        if (key == name_of(static_cast<Slot>(s))) slot = s;
      if (slot < 0)
        problem(path + "/" + key, "This is not a section of a limb.", "Use one of girdle, upper, lower, end and tip.");
      else
        out[static_cast<std::size_t>(slot)] = text(item, path + "/" + key);
    }
    if (out[1].empty() || out[2].empty())
      problem(path, "The upper or the lower section of the limb is missing.", "Name the first link of both sections.");
  }
  void read_links(const Json& value, Mapping& out) {
    if (!object(value, "/links")) return;
    for (const auto& [target, source] : value.items()) out.links.emplace_back(text(source, "/links/" + target), target);
  }
  void read_speeds(const Json& value, Mapping& out) {
    if (!object(value, "/speeds")) return;
    for (const auto& [link, speed] : value.items()) out.link_speeds.emplace_back(link, number(speed, "/speeds/" + link));
  }
  void read_soles(const Json& value, Mapping& out) {
    if (!object(value, "/soles")) return;
    for (const auto& [link, points] : value.items()) {
      const std::string path = "/soles/" + link;
      SoleSpec sole{link, {}};
      if (!array(points, path)) continue;
      for (const Json& p : points) {
        bool good = p.is_array() && p.size() == 3;
        for (std::size_t i = 0; good && i < 3; ++i) good = p[i].is_number() && std::isfinite(p[i].get<double>());
        if (good)
          sole.points.push_back({p[0].get<double>(), p[1].get<double>(), p[2].get<double>()});
        else
          problem(path, "A point of the sole is not a list of three finite numbers.", "Give x, y and z in m in the link's frame.");
      }
      if (sole.points.empty()) problem(path, "The sole has no points.", "Give the points that bear on the ground.");
      out.soles.push_back(std::move(sole));
    }
  }

  std::string file_;
  Error error_;
};

}  // namespace

Result<Mapping> read_mapping(std::string_view text, std::string_view file_name) {
  const Result<Json> root = json::parse_json(text, file_name, 1u << 20);
  if (!root) return fail(root.error());
  return Reader(file_name).read(*root);
}

}  // namespace ugoki::retarget
