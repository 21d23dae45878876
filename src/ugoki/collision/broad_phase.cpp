#include "ugoki/collision/broad_phase.h"

namespace ugoki::collision {
namespace {

// Up to this count of pairs (140 bodies), testing all pairs is as fast as the superior tree (docs/design/superior-tree.md).
constexpr std::size_t max_all_pairs = 10000;

}  // namespace

bool BroadPhase::covers(const Scene& scene, int system) {
  return scene.self_collision(system) && scene.self_pairs(system).size() > max_all_pairs;
}

bool BroadPhase::is_faster(const Scene& scene) {
  const std::size_t systems = scene.systems().size();
  if (scene.options().between_systems && systems * (systems - 1) / 2 > max_all_pairs) return true;
  for (std::size_t s = 0; s < systems; ++s)
    if (covers(scene, static_cast<int>(s))) return true;
  return false;
}

void BroadPhase::begin(const Scene& scene) {
  const auto systems = static_cast<int>(scene.systems().size());
  content_ = scene.content();
  covered_.clear();
  for (int s = 0; s < systems; ++s) covered_.push_back(covers(scene, s) ? 1 : 0);
  // All immovable shapes form one group. Pairs inside that group are not reported.
  std::vector<TreeBody> bodies;
  for (const SceneShape& s : scene.shapes()) bodies.push_back({{}, {s.bound, s.bound, s.bound}, s.bound, s.movable ? s.system : systems});
  tree_ = SuperiorTree(bodies);
  PairFilter filter;
  filter.inside_group = covered_;
  within_ = BoxesWithin(std::move(filter));
  centres_.assign(scene.shapes().size(), Pose{});
}

std::span<const BodyPair> BroadPhase::find(const Scene& scene, std::span<const Workspace::Ball> balls, double margin) {
  bool same = content_ == scene.content() && covered_.size() == scene.systems().size();
  for (std::size_t s = 0; same && s < covered_.size(); ++s) same = (covered_[s] != 0) == covers(scene, static_cast<int>(s));
  if (!same) begin(scene);
  for (std::size_t i = 0; i < centres_.size(); ++i) centres_[i].p = balls[i].c;
  tree_.update(centres_);
  within_.find(tree_, margin, found_);
  return found_;
}

}  // namespace ugoki::collision
