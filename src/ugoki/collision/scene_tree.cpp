#include "ugoki/collision/scene_tree.h"

#include <algorithm>

#include "ugoki/base/check.h"

namespace ugoki::collision {
namespace {

std::vector<TreeBody> bodies_of(const Scene& scene) {
  std::vector<TreeBody> out;
  for (const SceneShape& s : scene.shapes()) out.push_back(make_tree_body(s, s.system));
  return out;
}

/// The pairs (a, b), a < b, of shapes inside a system that cannot collide, sorted by (a, b).
std::vector<BodyPair> non_colliding_pairs(const Scene& scene, int system) {
  std::vector<BodyPair> colliding, out;
  for (const ShapePair& p : scene.self_pairs(system)) colliding.push_back({std::min(p.a, p.b), std::max(p.a, p.b)});
  std::ranges::sort(colliding);
  for (int i = scene.first_shape(system); i < scene.first_shape(system + 1); ++i)
    for (int j = i + 1; j < scene.first_shape(system + 1); ++j)
      if (!std::ranges::binary_search(colliding, BodyPair{i, j})) out.push_back({i, j});
  return out;
}

PairFilter filter_of(const Scene& scene) {
  PairFilter out;
  out.between_groups = scene.options().between_systems;
  std::vector<BodyPair> excluded;
  std::vector<int> fixed;
  for (int i = 0; i < static_cast<int>(scene.shapes().size()); ++i)
    if (!scene.shapes()[static_cast<std::size_t>(i)].movable) fixed.push_back(i);
  for (std::size_t i = 0; i < fixed.size(); ++i)
    for (std::size_t j = i + 1; j < fixed.size(); ++j) excluded.push_back({fixed[i], fixed[j]});
  for (int s = 0; s < static_cast<int>(scene.systems().size()); ++s) {
    out.inside_group.push_back(scene.self_collision(s) ? 1 : 0);
    if (!scene.self_collision(s)) continue;
    const std::vector<BodyPair> apart = non_colliding_pairs(scene, s);
    excluded.insert(excluded.end(), apart.begin(), apart.end());
  }
  out.exclude(std::move(excluded));
  return out;
}

}  // namespace

class SceneTree::Distances final : public PairFunction {
 public:
  Distances(const Scene& scene, const std::vector<Pose>& poses) : scene_(scene), poses_(poses) {}
  PairDistance distance(int a, int b, double cutoff, PairCache& cache) override {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    return find_pair_distance(scene_.shapes()[i], poses_[i], scene_.shapes()[j], poses_[j], cutoff, cache, workspace_);
  }

 private:
  const Scene& scene_;
  const std::vector<Pose>& poses_;
  DistanceWorkspace workspace_;
};

SceneTree::SceneTree(const Scene& scene)
    : scene_(scene),
      poses_(scene.shapes().size()),
      tree_(bodies_of(scene)),
      distances_(std::make_unique<Distances>(scene, poses_)),
      within_(filter_of(scene)) {}

SceneTree::~SceneTree() = default;

void SceneTree::update(std::span<const std::span<const Pose>> X_WB) {
  UGOKI_CHECK(X_WB.size() == scene_.systems().size());
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const SceneShape& s = scene_.shapes()[i];
    poses_[i] = X_WB[static_cast<std::size_t>(s.system)][static_cast<std::size_t>(s.link)] * s.shape.X_BS;
  }
  tree_.update(poses_);
}

const NearPair& SceneTree::nearest(int system_a, int system_b) {
  for (const auto& q : queries_)
    if (q->a == system_a && q->b == system_b) return q->query.find(tree_, *distances_);
  PairFilter filter;
  if (system_a == system_b) filter.exclude(non_colliding_pairs(scene_, system_a));
  queries_.push_back(std::make_unique<Query>(Query{system_a, system_b, ClosestPair(system_a, system_b, std::move(filter))}));
  return queries_.back()->query.find(tree_, *distances_);
}

void SceneTree::pairs_within(double margin, std::vector<NearPair>& out) { within_.find(tree_, margin, *distances_, out); }

}  // namespace ugoki::collision
