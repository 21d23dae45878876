// Rows of non-convex meshes: a bumpy torus and a knot, 1k, 10k and 100k triangles each, in coherent motion (1 degree and about 0.01 m per
// step), exact distances. A row's time is the mean time of one query over a trajectory back and forth.
//
// In scene `hole` the knot moves in the hole of the torus, in `near` next to the torus, in `far` several body sizes away.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>

#include "meshes.h"
#include "table.h"
#include "ugoki/collision/bubble.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::benchmarks {
namespace {

/// A closed tube of about n triangles. f returns its surface points [m] and has the period 2 pi in both arguments.
PlainMesh make_tube(int n, const std::function<Vec3(double, double)>& f) {
  const int around = static_cast<int>(std::sqrt(n / 8.0)), along = n / 2 / around;
  PlainMesh out;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      const Vec3 p = f(2 * pi * i / along, 2 * pi * j / around);
      out.vertices.insert(out.vertices.end(), {p.x, p.y, p.z});
      const int next = (i + 1) % along * around, next_j = (j + 1) % around;
      out.triangles.insert(out.triangles.end(),
                           {i * around + j, next + j, next + next_j, i * around + j, next + next_j, i * around + next_j});
    }
  return out;
}

PlainMesh bumpy_torus(int n) {
  return make_tube(n, [](double u, double v) {
    const double r = 0.4 * (1 + 0.08 * sin(7 * u) * sin(5 * v)), out = 1 + r * cos(v);
    return Vec3{out * cos(u), out * sin(u), r * sin(v)};
  });
}
PlainMesh torus_knot(int n) {
  const auto middle = [](double t) {
    const double q = 0.1 * (2 + cos(3 * t));
    return Vec3{q * cos(2 * t), q * sin(2 * t), 0.3 * sin(3 * t)};
  };
  return make_tube(n, [&](double u, double v) {
    const Vec3 along = normalized(middle(u + 1e-4) - middle(u - 1e-4)), a = normalized(cross(along, Vec3{0, 0, 1})), b = cross(along, a);
    const double r = 0.08 * (1 + 0.1 * sin(11 * u) * sin(3 * v));
    return middle(u) + a * (r * cos(v)) + b * (r * sin(v));
  });
}

collision::SphereTree tree_of(const PlainMesh& m) {
  std::vector<Vec3> vertices;
  for (std::size_t i = 0; i + 2 < m.vertices.size(); i += 3) vertices.push_back({m.vertices[i], m.vertices[i + 1], m.vertices[i + 2]});
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i + 2 < m.triangles.size(); i += 3) triangles.push_back({m.triangles[i], m.triangles[i + 1], m.triangles[i + 2]});
  auto made = collision::make_sphere_tree(vertices, triangles);
  if (!made) throw std::runtime_error(made.error().text());
  return std::move(*made);
}

struct Place {
  const char* name;
  Vec3 centre;       // m
  double amplitude;  // m, amplitude of the knot's motion
};
constexpr std::array<Place, 3> places{{{"hole", {0, 0, 0}, 0.06}, {"near", {1.88, 0, 0}, 0.04}, {"far", {4, 0, 0}, 0.3}}};

std::vector<Pose> make_path(const Place& location) {
  constexpr int steps = 50;
  std::vector<Pose> out;
  Mat3 R = Mat3::identity();
  for (int i = 0; i < steps; ++i) {
    const double s = 0.01 * i / location.amplitude;
    const Vec3 axis = normalized(Vec3{sin(0.05 * i), cos(0.08 * i), 0.5});
    R = rotation_about(axis, pi / 180) * R;
    out.push_back({R, location.centre + Vec3{sin(0.6 * s), cos(0.5 * s), sin(0.8 * s)} * location.amplitude});
  }
  for (int i = steps - 2; i > 0; --i) out.push_back(out[static_cast<std::size_t>(i)]);
  return out;
}

PlainPose plain(const Pose& X) { return {{X.R.xx, X.R.xy, X.R.xz, X.R.yx, X.R.yy, X.R.yz, X.R.zx, X.R.zy, X.R.zz}, {X.p.x, X.p.y, X.p.z}}; }

/// Returns for each function the mean over the trajectory of the minimum time of each pose, in ns. The functions alternate, each running
/// the complete trajectory. Disturbances by other processes then affect single poses, not the mean.
std::vector<double> measure_path(const std::vector<std::function<void(std::size_t)>>& functions, std::size_t poses) {
  using Clock = std::chrono::steady_clock;
  std::vector<std::vector<double>> minimum(functions.size(), std::vector<double>(poses, 1e300));
  const auto end = Clock::now() + std::chrono::seconds(2);
  for (int round = 0; round < 3 || Clock::now() < end; ++round)
    for (std::size_t f = 0; f < functions.size(); ++f)
      for (std::size_t i = 0; i < poses; ++i) {
        const auto start = Clock::now();
        functions[f](i);
        minimum[f][i] = std::min(minimum[f][i], std::chrono::duration<double, std::nano>(Clock::now() - start).count());
      }
  std::vector<double> out;
  for (const auto& times : minimum) out.push_back(std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(poses));
  return out;
}

void mesh_rows(Table& table, int triangles) {
  const PlainMesh torus = bumpy_torus(triangles), knot = torus_knot(triangles);
  const collision::SphereTree a = tree_of(torus), b = tree_of(knot);
  std::vector<std::unique_ptr<MeshPeer>> peers;
  for (const MeshBounds bounds : {MeshBounds::rss, MeshBounds::obb_rss}) {
    peers.push_back(make_fcl_meshes(torus, knot, bounds));
    peers.push_back(make_coal_meshes(torus, knot, bounds));
  }
  peers.push_back(make_pqp_meshes(torus, knot));
  std::erase(peers, nullptr);
  for (const Place& location : places) {
    const std::string row = "meshes of " + std::to_string(triangles / 1000) + "k triangles, " + location.name;
    const std::vector<Pose> path = make_path(location);
    std::vector<PlainPose> plain_path;
    for (const Pose& X : path) plain_path.push_back(plain(X));
    collision::TrianglePair warm;
    collision::BubbleWorkspace workspace;
    const auto ours = [&](const Pose& X) { return find_distance(a, {}, b, X, warm, workspace).distance; };
    std::vector<double> expected;
    for (const Pose& X : path) expected.push_back(ours(X));
    std::vector<std::function<void(std::size_t)>> functions{[&](std::size_t i) { (void)ours(path[i]); }};
    for (const auto& peer : peers) {
      std::vector<double> theirs;
      for (const PlainPose& X : plain_path) theirs.push_back(peer->distance(X));
      require_same(expected, theirs, 1e-9, row + ", " + peer->name());
      functions.push_back([&](std::size_t i) { (void)peer->distance(plain_path[i]); });
    }
    const std::vector<double> ns = measure_path(functions, path.size());
    if (peers.empty()) table.add({.row = row, .ours_ns = ns[0], .peer = {}});
    for (std::size_t i = 0; i < peers.size(); ++i)
      table.add({.row = row, .ours_ns = ns[0], .peer = peers[i]->name(), .peer_ns = ns[i + 1]});
  }
}

void of_1k(Table& table) { mesh_rows(table, 1000); }
void of_10k(Table& table) { mesh_rows(table, 10000); }
void of_100k(Table& table) { mesh_rows(table, 100000); }
const RowRegistration register_1k(200, of_1k);
const RowRegistration register_10k(210, of_10k);
const RowRegistration register_100k(220, of_100k);

}  // namespace
}  // namespace ugoki::benchmarks
