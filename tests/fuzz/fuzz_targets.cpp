#include "fuzz_targets.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"

namespace ugoki {
namespace {

using namespace formats;

std::string_view text_of(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }

void check_error(const Error& error) {
  UGOKI_CHECK(!error.problems.empty());
  for (const Problem& p : error.problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
}

/// Checks a measured motion: complete, finite, parents before children, all rotations valid.
void check_motion(const MeasuredMotion& m) {
  UGOKI_CHECK(m.frames > 0 && m.joint_count() > 0 && m.rate > 0 && std::isfinite(m.rate));
  const std::size_t count = static_cast<std::size_t>(m.frames) * m.skeleton.joints.size();
  UGOKI_CHECK(m.translations.size() == count && m.rotations.size() == count);
  for (std::size_t i = 0; i < m.skeleton.joints.size(); ++i) {
    const SkeletonJoint& j = m.skeleton.joints[i];
    UGOKI_CHECK(j.parent >= -1 && j.parent < static_cast<int>(i));
    UGOKI_CHECK(!j.name.empty() && is_finite(j.offset));
    for (const Vec3& e : j.end_sites) UGOKI_CHECK(is_finite(e));
  }
  for (const Vec3& t : m.translations) UGOKI_CHECK(is_finite(t));
  for (const Quat& q : m.rotations) UGOKI_CHECK(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-9);
}

/// Checks that a motion that was read can be written and read again with the same number of frames.
void check_round_trip(const MeasuredMotion& m) {
  if (m.translations.size() > 20'000) return;
  for (const SkeletonJoint& j : m.skeleton.joints)  // written values may exceed the range that a reader accepts as measurements
    if (norm(j.offset) > 1e6 * m.skeleton.unit) return;
  for (const Vec3& t : m.translations)
    if (norm(t) > 1e6 * m.skeleton.unit) return;
  const auto back = read_bvh(write_bvh(m), "again.bvh", {.metres_per_unit = m.skeleton.unit});
  if (!back) {
    for (const Problem& p : back.error().problems)
      UGOKI_CHECK(p.code == ErrorCode::range);  // an extreme frame time or end site is out of range
    return;
  }
  UGOKI_CHECK(back->frames == m.frames && back->joint_count() == m.joint_count());
  const auto bytes = write_measured_motion(m);
  const auto stored = read_measured_motion(bytes, "stored");
  UGOKI_CHECK(stored.has_value() && write_measured_motion(*stored) == bytes);
}

}  // namespace

void fuzz_bvh(const std::uint8_t* data, std::size_t size) {
  ReadNotes notes;
  const auto m = read_bvh(text_of(data, size), "fuzz.bvh", {.z_up = size % 2 == 1}, &notes);
  if (!m) return check_error(m.error());
  check_motion(*m);
  check_round_trip(*m);
}

void fuzz_asf(const std::uint8_t* data, std::size_t size) {
  const auto asf = read_asf(text_of(data, size), "fuzz.asf");
  if (!asf) return check_error(asf.error());
  UGOKI_CHECK(asf->bones.size() == asf->skeleton.joints.size());
  for (const SkeletonJoint& j : asf->skeleton.joints) UGOKI_CHECK(is_finite(j.offset));
}

/// Input: a skeleton, a line "=====", and its motion.
void fuzz_amc(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = text_of(data, size);
  constexpr std::string_view divider = "=====\n";
  const std::size_t at = text.find(divider);
  if (at == std::string_view::npos) return;
  const auto asf = read_asf(text.substr(0, at), "fuzz.asf");
  if (!asf) return check_error(asf.error());
  ReadNotes notes;
  const auto m = read_amc(text.substr(at + divider.size()), "fuzz.amc", *asf, {}, &notes);
  if (!m) return check_error(m.error());
  check_motion(*m);
  check_round_trip(*m);
}

void fuzz_mechanism(const std::uint8_t* data, std::size_t size) {
  const auto m = read_mechanism(text_of(data, size), "fuzz.json");
  if (!m) return check_error(m.error());
  const std::string written = write_mechanism(**m);
  const auto back = read_mechanism(written, "again.json");
  UGOKI_CHECK(back.has_value());
  UGOKI_CHECK(write_mechanism(**back) == written);
}

void fuzz_motion(const std::uint8_t* data, std::size_t size) {
  // The checksum is corrected, so that the reader gets past it.
  std::vector<std::byte> bytes(size);
  if (size > 0) std::memcpy(bytes.data(), data, size);
  if (size >= 32) {
    Hash64 hash;
    hash.add_bytes(bytes.data() + 32, size - 32);
    const std::uint64_t rest = size - 32, sum = hash.value();
    std::memcpy(bytes.data() + 16, &rest, 8);
    std::memcpy(bytes.data() + 24, &sum, 8);
  }
  const auto motion = read_motion(bytes, "row");
  if (!motion) check_error(motion.error());
  const auto measured = read_measured_motion(bytes, "row");
  if (!measured) check_error(measured.error());
  if (motion) UGOKI_CHECK(read_motion(write_motion(*motion), "row").has_value());
  if (measured) UGOKI_CHECK(read_measured_motion(write_measured_motion(*measured), "row").has_value());
}

}  // namespace ugoki
