// Fuzz targets of the readers of MVNX, USD and SMPL motions.
#include <cmath>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/scene_formats/mvnx.h"
#include "ugoki/scene_formats/npz.h"
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

}  // namespace ugoki
