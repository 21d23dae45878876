// Fuzz targets of the readers of MVNX, SMPL, OpenSim, USD and DeepMimic motions.
#include <cmath>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/robot_formats/osim.h"
#include "ugoki/scene_formats/deepmimic.h"
#include "ugoki/scene_formats/mvnx.h"
#include "ugoki/scene_formats/npz.h"
#include "ugoki/scene_formats/opensim.h"
#include "ugoki/scene_formats/smpl.h"
#include "ugoki/scene_formats/usd.h"

namespace ugoki {
namespace {

void check_error(const Error& e) {
  UGOKI_CHECK(!e.problems.empty() && e.problems.size() <= 20);
  for (const Problem& p : e.problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.') && !p.remedy.empty());
}

void check_motion(const MeasuredMotion& m) {
  const std::size_t count = static_cast<std::size_t>(m.frames) * m.skeleton.joints.size();
  UGOKI_CHECK(m.frames > 0 && m.rate > 0 && std::isfinite(m.rate));
  UGOKI_CHECK(m.translations.size() == count && m.rotations.size() == count);
  for (const Vec3& x : m.translations) UGOKI_CHECK(is_finite(x));
  for (const Quat& q : m.rotations) UGOKI_CHECK(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-6);
  for (std::size_t i = 0; i < m.skeleton.joints.size(); ++i) UGOKI_CHECK(m.skeleton.joints[i].parent < static_cast<int>(i));
}

}  // namespace

void fuzz_mvnx(const std::uint8_t* data, std::size_t size) {
  const auto m = scene_formats::read_mvnx({reinterpret_cast<const char*>(data), size}, "fuzz.mvnx");
  if (!m) return check_error(m.error());
  check_motion(*m);
}

void fuzz_usda(const std::uint8_t* data, std::size_t size) {
  const auto m = scene_formats::read_usd({reinterpret_cast<const char*>(data), size}, "fuzz.usda");
  if (!m) return check_error(m.error());
  check_motion(*m);
}

/// The bytes are an .npz file, or a single .npy array, which mutation reaches more easily than one inside a zip with its checksums.
void fuzz_smpl(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text.starts_with("\x93NUMPY")) {
    const auto array = scene_formats::read_npy(text, "fuzz.npy");
    if (!array) return check_error(array.error());
    for (const double x : array->values) UGOKI_CHECK(std::isfinite(x));
    return;
  }
  const auto m = scene_formats::read_smpl(std::as_bytes(std::span(data, size)), "fuzz.npz");
  if (!m) return check_error(m.error());
  check_motion(*m);
}

/// The bytes are a model, or a table of its coordinates.
void fuzz_opensim(const std::uint8_t* data, std::size_t size) {
  static constexpr std::string_view model = R"(<OpenSimDocument Version="40000"><Model name="m"><BodySet><objects>
<Body name="pelvis"><mass>10</mass><mass_center>0 0 0</mass_center><inertia>1 1 1 0 0 0</inertia></Body></objects></BodySet><JointSet><objects>
<PlanarJoint name="root"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>pelvis</socket_child_frame><coordinates>
<Coordinate name="tilt"/><Coordinate name="tx"/><Coordinate name="ty"/></coordinates></PlanarJoint></objects></JointSet></Model></OpenSimDocument>)";
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text.find('<') == std::string_view::npos) {
    const auto m = scene_formats::read_opensim(text, "fuzz.mot", model, "m.osim");
    if (!m) return check_error(m.error());
    return check_motion(*m);
  }
  const auto robot = robot_formats::read_osim(text, "fuzz.osim");
  if (!robot) return check_error(robot.error());
  UGOKI_CHECK(robot->mechanism && std::isfinite(robot->mechanism->mass()));
  const auto m = scene_formats::read_opensim("endheader\ntime\ttilt\ttx\tty\n0\t0\t0\t1\n0.1\t1\t0.1\t1\n", "fuzz.mot", text, "fuzz.osim");
  if (!m) return check_error(m.error());
  check_motion(*m);
}

/// The bytes are a motion, or a character file if they contain "Skeleton".
void fuzz_deepmimic(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const bool character = text.find("Skeleton") != std::string_view::npos;
  const auto m = character ? scene_formats::read_deepmimic(R"({"Frames": [[0.1, 0,0.5,0, 1,0,0,0, 0.2], [0, 0,0.6,0, 1,0,0,0, 0.2]]})",
                                                           "fuzz.txt", text, "character.txt")
                           : scene_formats::read_deepmimic(text, "fuzz.txt");
  if (!m) return check_error(m.error());
  check_motion(*m);
}

}  // namespace ugoki
