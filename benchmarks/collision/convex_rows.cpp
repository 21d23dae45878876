// Rows of convex pairs: two hulls of 16 ... 16384 vertices on ellipsoids, separated by about their size; in coherent motion (1 degree and
// 0.01 of the size per step) and in independent random poses. A row's time is that of one query with witness points.

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "convex.h"
#include "table.h"
#include "ugoki/collision/gilbert.h"
#include "ugoki/geometry/make_hull.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::benchmarks {
namespace {

using collision::GilbertCache;
using collision::Hull;
using collision::Support;

constexpr int poses = 2000;
constexpr double apart = 1.5;  // m, distance between the centres of two hulls that are about 1 m long

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Vec3 unit() {
    for (;;) {
      const Vec3 v{in(-1, 1), in(-1, 1), in(-1, 1)};
      if (norm(v) > 0.1 && norm(v) < 1) return v / norm(v);
    }
  }

 private:
  std::mt19937_64 engine_;
};

Hull ellipsoid(int vertices, unsigned seed) {
  Draw draw(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < vertices; ++i) {
    const Vec3 u = draw.unit();
    points.push_back({0.5 * u.x, 0.4 * u.y, 0.3 * u.z});
  }
  Result<Hull> hull = geometry::make_hull(points);
  if (!hull || static_cast<int>(hull->vertices.size()) != vertices)
    throw std::runtime_error("convex rows: the hull has not the requested number of vertices");
  return std::move(*hull);
}

PlainHull plain(const Hull& h) {
  PlainHull out;
  for (const Vec3& v : h.vertices) out.vertices.insert(out.vertices.end(), {v.x, v.y, v.z});
  for (int f = 0; f < h.faces(); ++f) out.faces.emplace_back(h.face(f).begin(), h.face(f).end());
  return out;
}

PlainPlace plain(const Pose& X) {
  return {{X.R.xx, X.R.xy, X.R.xz, X.R.yx, X.R.yy, X.R.yz, X.R.zx, X.R.zy, X.R.zz}, {X.p.x, X.p.y, X.p.z}};
}

struct Places {
  std::vector<Pose> a, b;
  std::vector<PlainPlace> plain_a, plain_b;
  void add(const Pose& one, const Pose& two) {
    a.push_back(one);
    b.push_back(two);
    plain_a.push_back(plain(one));
    plain_b.push_back(plain(two));
  }
};

/// Poses along a trajectory back and forth, so that the first pose can follow the last.
Places coherent() {
  Draw draw(7);
  Quat qa, qb;
  Vec3 axis_a, axis_b;
  Places out;
  for (int i = 0; i < poses / 2; ++i) {
    if (i % 50 == 0) axis_a = draw.unit(), axis_b = draw.unit();
    qa = normalized(axis_angle(axis_a, pi / 180) * qa);
    qb = normalized(axis_angle(axis_b, pi / 180) * qb);
    const SinCos round = sin_cos(i * 0.01 / apart), up = sin_cos(i * 0.0025);
    out.add({to_matrix(qa), {}}, {to_matrix(qb), {apart * round.cos, apart * round.sin, 0.3 * up.sin}});
  }
  for (int i = poses / 2; i-- > 0;) out.add(out.a[static_cast<std::size_t>(i)], out.b[static_cast<std::size_t>(i)]);
  return out;
}

Places incoherent() {
  Draw draw(9);
  Places out;
  for (int i = 0; i < poses; ++i)
    out.add({rotation_about(draw.unit(), draw.in(-pi, pi)), draw.unit() * 0.1},
            {rotation_about(draw.unit(), draw.in(-pi, pi)), draw.unit() * apart});
  return out;
}

/// Checks the results. Our distance must be certified at every pose (at most 1e-9 m above its lower bound). A peer's distance must agree
/// within its accuracy at nine of ten poses, because each peer sometimes stops too early.
void check(const Support& a, const Support& b, const Places& places, ConvexPeer* peer, const std::string& row) {
  GilbertCache cache;
  int off = 0;
  for (std::size_t i = 0; i < places.a.size(); ++i) {
    const collision::GilbertResult r = collision::gilbert_distance(a, places.a[i], b, places.b[i], cache);
    if (r.status != collision::GilbertStatus::separated || r.distance - r.lower > 1e-9) throw std::runtime_error(row + ": not certified");
    if (peer != nullptr && i % 20 == 0 && !(std::fabs(peer->distance(places.plain_a[i], places.plain_b[i]) - r.distance) < 1e-3)) ++off;
  }
  if (off > static_cast<int>(places.a.size()) / 20 / 10)
    throw std::runtime_error(row + ": " + peer->name() + " finds different distances at " + std::to_string(off) + " poses");
}

void add_row(Table& table, const std::string& row, const Hull& ha, const Hull& hb, const Places& places, bool warm) {
  const Support a = Support::of(ha), b = Support::of(hb);
  ConvexPeers peers;
  add_fcl_convex(peers, plain(ha), plain(hb));
  add_bullet_convex(peers, plain(ha), plain(hb));
  add_coal_convex(peers, plain(ha), plain(hb));
  check(a, b, places, nullptr, row);
  GilbertCache cache;
  std::size_t step = 0;
  double sum = 0;
  std::vector<std::function<void()>> functions{[&] {
    step = step + 1 < places.a.size() ? step + 1 : 0;
    if (!warm) cache = {};
    sum += collision::gilbert_distance(a, places.a[step], b, places.b[step], cache).distance;
  }};
  std::vector<std::size_t> steps(peers.size(), 0);
  for (std::size_t k = 0; k < peers.size(); ++k) {
    check(a, b, places, peers[k].get(), row);
    functions.emplace_back([&, k] {
      steps[k] = steps[k] + 1 < places.a.size() ? steps[k] + 1 : 0;
      sum += peers[k]->distance(places.plain_a[steps[k]], places.plain_b[steps[k]]);
    });
  }
  const std::vector<double> ns = measure(functions, 0.4);
  if (std::isnan(sum)) throw std::runtime_error(row + ": the sum of distances is NaN");
  if (peers.empty()) table.add({.row = row, .ours_ns = ns[0], .peer = {}});
  for (std::size_t k = 0; k < peers.size(); ++k) table.add({.row = row, .ours_ns = ns[0], .peer = peers[k]->name(), .peer_ns = ns[k + 1]});
}

void add_convex_rows(Table& table) {
  const Places near = coherent(), random = incoherent();
  for (const int n : {16, 64, 256, 1024, 4096, 16384}) {
    const Hull a = ellipsoid(n, static_cast<unsigned>(n) + 1), b = ellipsoid(n, static_cast<unsigned>(n) + 2);
    add_row(table, "convex coherent " + std::to_string(n), a, b, near, true);
    add_row(table, "convex random " + std::to_string(n), a, b, random, false);
  }
}

const RowRegistration registration(100, add_convex_rows);

}  // namespace
}  // namespace ugoki::benchmarks
