#include "ugoki/collision/polytope.h"

#include <cmath>

#include "ugoki/collision/double_double.h"

namespace ugoki::collision {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Sign of det(b - a, c - a, p - a): 1 if p is on the outer side of the face a, b, c; -1 on the inner side; 0 in its plane. Computed in
/// doubles if the result exceeds their rounding error (2e-15 of the product of sizes), otherwise in double-double.
int side_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 e = b - a, f = c - a, g = p - a, n = cross(e, f);
  const double volume = dot(n, g);
  const double scale = (std::fabs(e.x) + std::fabs(e.y) + std::fabs(e.z)) * (std::fabs(f.x) + std::fabs(f.y) + std::fabs(f.z)) *
                       (std::fabs(g.x) + std::fabs(g.y) + std::fabs(g.z));
  if (std::fabs(volume) > 2e-15 * scale) return volume > 0 ? 1 : -1;
  const DoubleDouble exact = dot(cross(exact_difference(b, a), exact_difference(c, a)), exact_difference(p, a));
  if (std::fabs(exact.high) <= 1e-29 * scale) return 0;
  return exact.high > 0 ? 1 : -1;
}

}  // namespace

bool Polytope::sees(std::int32_t face, const Vec3& p) const {
  const PolytopeFace& f = faces_[at(face)];
  return side_of(corner(f.corner[0]).w, corner(f.corner[1]).w, corner(f.corner[2]).w, p) > 0;
}

void Polytope::set_plane(PolytopeFace& f) const {
  const Vec3 &a = corner(f.corner[0]).w, &b = corner(f.corner[1]).w, &c = corner(f.corner[2]).w;
  const Vec3 e = b - a, g = c - a;
  Vec3 n = cross(e, g);
  if (dot(n, n) < 1e-8 * dot(e, e) * dot(g, g)) {  // a sliver, sine of its angle below 1e-4: double-double keeps the normal accurate
    const DoubleDoubleVec exact = cross(exact_difference(b, a), exact_difference(c, a));
    n = {exact.x.high, exact.y.high, exact.z.high};
  }
  const double big = std::fmax(std::fabs(n.x), std::fmax(std::fabs(n.y), std::fabs(n.z)));
  n = n / (big > 0 ? big : 1);
  f.n = n / norm(n);
  f.d = dot(f.n, a);
}

bool Polytope::start(const Corner& a, const Corner& b, const Corner& c, const Corner& e) {
  corners_.assign({a, b, c, e});
  faces_.clear();
  free_.clear();
  starts_.assign(4, -1);
  const int side = side_of(a.w, b.w, c.w, e.w);
  if (side == 0) return false;
  if (side > 0) std::swap(corners_[1], corners_[2]);
  // Outward faces of a tetrahedron whose last corner is on the inner side of the first three.
  static constexpr std::int32_t corners[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  static constexpr std::int32_t across[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int f = 0; f < 4; ++f) {
    PolytopeFace face;
    for (int k = 0; k < 3; ++k) face.corner[k] = corners[f][k], face.across[k] = across[f][k];
    set_plane(face);
    faces_.push_back(face);
  }
  return true;
}

bool Polytope::find_horizon(const Vec3& p, std::int32_t seed) {
  seen_.assign(faces_.size(), 0);
  visible_.assign(1, seed);
  horizon_.clear();
  seen_[at(seed)] = 1;
  for (std::size_t next = 0; next < visible_.size(); ++next) {
    const PolytopeFace& f = faces_[at(visible_[next])];
    for (int k = 0; k < 3; ++k) {
      const std::int32_t g = f.across[k];
      if (seen_[at(g)] == 0) {
        seen_[at(g)] = sees(g, p) ? 1 : 2;
        if (seen_[at(g)] == 1) visible_.push_back(g);
      }
      if (seen_[at(g)] == 2) horizon_.push_back({f.corner[k], f.corner[(k + 1) % 3], g});
    }
  }
  // The horizon must be one closed cycle of edges: each of its corners is the start of exactly one edge.
  bool simple = horizon_.size() >= 3;
  for (const HorizonEdge& e : horizon_) {
    simple = simple && starts_[at(e.from)] < 0;
    starts_[at(e.from)] = 0;
  }
  std::size_t steps = 0;
  if (simple)
    for (std::int32_t c = horizon_[0].to; c != horizon_[0].from && steps <= horizon_.size(); ++steps) {
      bool found = false;
      for (const HorizonEdge& e : horizon_)
        if (e.from == c) {
          c = e.to;
          found = true;
          break;
        }
      if (!found) break;
    }
  for (const HorizonEdge& e : horizon_) starts_[at(e.from)] = -1;
  return simple && steps + 1 == horizon_.size();
}

bool Polytope::add_beyond(const Corner& c, std::int32_t seed) {
  if (corners_.size() >= max_corners || !find_horizon(c.w, seed)) return false;
  const auto added = static_cast<std::int32_t>(corners_.size());
  corners_.push_back(c);
  starts_.push_back(-1);
  for (const std::int32_t f : visible_) {
    faces_[at(f)].alive = false;
    free_.push_back(f);
  }
  for (const HorizonEdge& e : horizon_) {
    std::int32_t f;
    if (free_.empty()) {
      f = static_cast<std::int32_t>(faces_.size());
      faces_.emplace_back();
    } else {
      f = free_.back();
      free_.pop_back();
    }
    PolytopeFace& face = faces_[at(f)];
    face = {};
    face.corner[0] = e.from, face.corner[1] = e.to, face.corner[2] = added;
    face.across[0] = e.outside;
    set_plane(face);
    starts_[at(e.from)] = f;
    PolytopeFace& outside = faces_[at(e.outside)];
    for (int k = 0; k < 3; ++k)
      if (outside.corner[k] == e.to && outside.corner[(k + 1) % 3] == e.from) outside.across[k] = f;
  }
  for (const HorizonEdge& e : horizon_) {
    const std::int32_t f = starts_[at(e.from)], g = starts_[at(e.to)];
    faces_[at(f)].across[1] = g;
    faces_[at(g)].across[2] = f;
  }
  for (const HorizonEdge& e : horizon_) starts_[at(e.from)] = -1;
  return true;
}

bool Polytope::add(const Corner& c) {
  for (std::size_t f = 0; f < faces_.size(); ++f)
    if (faces_[f].alive && sees(static_cast<std::int32_t>(f), c.w)) return add_beyond(c, static_cast<std::int32_t>(f));
  return true;
}

std::int32_t Polytope::nearest() const {
  std::int32_t best = -1;
  for (std::size_t f = 0; f < faces_.size(); ++f)
    if (faces_[f].alive && (best < 0 || faces_[f].d < faces_[at(best)].d)) best = static_cast<std::int32_t>(f);
  return best;
}

}  // namespace ugoki::collision
