// Fuzz targets of the readers of marker files.
#include <cmath>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/trc.h"

namespace ugoki {
namespace {

void check_error(const Error& e) {
  UGOKI_CHECK(!e.problems.empty() && e.problems.size() <= 20);
  for (const Problem& p : e.problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.') && !p.remedy.empty());
}

void check_markers(const MarkerMotion& m) {
  const std::size_t count = static_cast<std::size_t>(m.frames) * m.labels.size();
  UGOKI_CHECK(m.frames > 0 && m.rate > 0 && std::isfinite(m.rate));
  UGOKI_CHECK(m.positions.size() == count && m.residuals.size() == count);
  UGOKI_CHECK(m.samples.size() == static_cast<std::size_t>(m.frames * m.samples_per_frame()) * m.analog.size());
  for (const Vec3& x : m.positions) UGOKI_CHECK(is_finite(x));
  for (const double x : m.samples) UGOKI_CHECK(std::isfinite(x));
  for (const ForcePlate& p : m.plates)
    for (const int c : p.channels) UGOKI_CHECK(c >= 0 && static_cast<std::size_t>(c) < m.analog.size());
}

}  // namespace

void fuzz_c3d(const std::uint8_t* data, std::size_t size) {
  const auto m = formats::read_c3d({reinterpret_cast<const std::byte*>(data), size}, "fuzz.c3d");
  if (!m) return check_error(m.error());
  check_markers(*m);
  if (m->positions.size() > 20'000) return;
  const auto bytes = formats::write_c3d(*m);
  if (!bytes) return check_error(bytes.error());
  const auto back = formats::read_c3d(*bytes, "again.c3d");
  UGOKI_CHECK(back.has_value() && back->frames == m->frames && back->marker_count() == m->marker_count());
}

void fuzz_trc(const std::uint8_t* data, std::size_t size) {
  const auto m = formats::read_trc({reinterpret_cast<const char*>(data), size}, "fuzz.trc");
  if (!m) return check_error(m.error());
  check_markers(*m);
  if (m->positions.size() > 20'000) return;
  const auto back = formats::read_trc(formats::write_trc(*m), "again.trc");
  if (!back) {
    return check_error(back.error());  // allowed: written names may be equal or empty, and lengths may be too long
  }
  UGOKI_CHECK(back->frames == m->frames && back->marker_count() == m->marker_count());
}

}  // namespace ugoki
