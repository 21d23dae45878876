#include <string>
#include <string_view>
#include <vector>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/robot_formats/mjcf.h"

namespace ugoki {
namespace {

using namespace robot_formats;

/// Splits the input at lines "=====" into the model and the files a.xml, b.xml ..., which it may include, attach or use as meshes.
std::vector<std::string> parts_of(std::string_view text) {
  constexpr std::string_view divider = "=====\n";
  std::vector<std::string> out;
  for (std::size_t at = text.find(divider); at != std::string_view::npos; at = text.find(divider)) {
    out.emplace_back(text.substr(0, at));
    text.remove_prefix(at + divider.size());
  }
  out.emplace_back(text);
  return out;
}

}  // namespace

void fuzz_mjcf(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::string> parts = parts_of({reinterpret_cast<const char*>(data), size});
  RobotOptions options;
  options.meshes = size % 3 == 0 ? Meshes::none : size % 3 == 1 ? Meshes::exact : Meshes::hull;
  options.base = size % 5 == 0 ? Base::floating : Base::by_file;
  options.inertias = size % 2 == 0 ? Inertias::strict : Inertias::repair;
  options.read_asset = [&](const std::string& path) -> Result<std::string> {
    const std::size_t i = path.empty() ? 0 : static_cast<std::size_t>(path[0] - 'a') + 1;
    if (path[0] < 'a' || i >= parts.size()) return fail(ErrorCode::io, path, "the file does not exist.");
    return parts[i];
  };
  const auto m = read_mjcf(parts[0], "fuzz.xml", options);
  if (!m) {
    UGOKI_CHECK(!m.error().problems.empty() && m.error().problems.size() <= 20);
    for (const Problem& p : m.error().problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
    return;
  }
  const Mechanism& k = *m->mechanism;
  UGOKI_CHECK(m->X_BF.size() == static_cast<std::size_t>(k.link_count()));
  for (const NamedPosition& position : m->positions) UGOKI_CHECK(position.q.size() == static_cast<std::size_t>(k.nq()));
  for (const JointName& j : m->joints) UGOKI_CHECK(k.find_link(j.link) >= 0 || k.find_loop(j.link) >= 0);
  for (const std::string& link : m->driven) UGOKI_CHECK(k.find_link(link) >= 0);
  UGOKI_CHECK(Mechanism::make(k.spec()).has_value());
}

}  // namespace ugoki
