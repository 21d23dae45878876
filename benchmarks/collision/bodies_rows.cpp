// Rows of the superior tree (box hierarchy over groups of bodies): the closest pair of two groups, and all pairs within a margin, in
// coherent motion. A row's time is the time of one step: all bodies are moved, then the query runs.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "motion_scenes.h"
#include "table.h"
#include "ugoki/collision/pair_queries.h"

namespace ugoki::benchmarks {
namespace {

using collision::PairCache;
using collision::PairDistance;

class Distances final : public collision::PairFunction {
 public:
  explicit Distances(const Motion& motion) : motion_(motion) {}
  void set(int step) { poses_ = motion_.at(step); }
  PairDistance distance(int a, int b, double enough, PairCache& cache) override {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    return find_pair_distance(motion_.colliders[i], poses_[i], motion_.colliders[j], poses_[j], enough, cache, workspace_);
  }

 private:
  const Motion& motion_;
  std::span<const Pose> poses_;
  collision::DistanceWorkspace workspace_;
};

std::vector<collision::TreeBody> tree_bodies(const Motion& motion) {
  std::vector<collision::TreeBody> out;
  for (std::size_t i = 0; i < motion.colliders.size(); ++i) out.push_back(make_tree_body(motion.colliders[i], motion.groups[i]));
  return out;
}

/// Counter of steps: next() returns the steps 0 to count - 1 in order, periodically.
struct Steps {
  int count, now = 0;
  int next() { return now = now + 1 < count ? now + 1 : 0; }
};

void compare(Table& table, const std::string& row, const std::function<void()>& ours,
             const std::vector<std::pair<std::string, std::function<void()>>>& peers) {
  std::vector<std::function<void()>> functions{ours};
  for (const auto& p : peers) functions.push_back(p.second);
  const std::vector<double> ns = measure(functions, 1.0);
  if (peers.empty()) table.add({.row = row, .ours_ns = ns[0], .peer = {}});
  for (std::size_t i = 0; i < peers.size(); ++i) table.add({.row = row, .ours_ns = ns[0], .peer = peers[i].first, .peer_ns = ns[i + 1]});
}

/// Brute force: the minimum over all pairs of the two groups, each pair with its own warm start.
class AllPairs {
 public:
  explicit AllPairs(const Motion& motion) : motion_(motion), distances_(motion) {
    const auto a = static_cast<std::size_t>(motion.plain.first_of_b);
    caches_.resize(a * (motion.colliders.size() - a));
  }
  double nearest(int step) {
    distances_.set(step);
    double minimum = std::numeric_limits<double>::infinity();
    std::size_t k = 0;
    for (int a = 0; a < motion_.plain.first_of_b; ++a)
      for (int b = motion_.plain.first_of_b; b < static_cast<int>(motion_.colliders.size()); ++b)
        minimum = std::min(minimum, distances_.distance(a, b, std::numeric_limits<double>::infinity(), caches_[k++]).distance);
    return minimum;
  }

 private:
  const Motion& motion_;
  Distances distances_;
  std::vector<PairCache> caches_;
};

void nearest_rows(Table& table, int characters) {
  const int links = 20 * characters;
  const std::string row = (characters == 1 ? "two characters of " : "two groups of ") + std::to_string(links) + " links, closest pair";
  const Motion motion = make_characters(characters);
  Distances distances(motion);
  collision::SuperiorTree tree(tree_bodies(motion));
  collision::ClosestPair query(0, 1);
  const auto nearest = [&](int step) {
    distances.set(step);
    tree.update(motion.at(step));
    return query.find(tree, distances).near.distance;
  };
  std::vector<std::unique_ptr<BodiesPeer>> peers;
  peers.push_back(make_fcl_bodies(motion.plain, 0));
  peers.push_back(make_bullet_bodies(motion.plain, 0));
  std::erase(peers, nullptr);
  AllPairs all(motion);
  std::vector<double> ours, brute;
  std::vector<std::vector<double>> theirs(peers.size());
  for (int step = 0; step < motion.plain.steps; ++step) {
    ours.push_back(nearest(step));
    if (characters == 1 || step % 10 == 0)
      brute.push_back(all.nearest(step));
    else
      brute.push_back(ours.back());
    for (std::size_t i = 0; i < peers.size(); ++i) theirs[i].push_back(peers[i]->nearest(step));
  }
  require_same(ours, brute, 1e-10, row + ", all pairs");
  for (std::size_t i = 0; i < peers.size(); ++i) require_same(ours, theirs[i], 2e-3, row + ", " + peers[i]->name());
  std::vector<Steps> at(peers.size() + 2, Steps{motion.plain.steps});
  std::vector<std::pair<std::string, std::function<void()>>> functions;
  for (std::size_t i = 0; i < peers.size(); ++i)
    functions.push_back({peers[i]->name(), [&, i] { (void)peers[i]->nearest(at[i + 2].next()); }});
  functions.push_back({"ours, all pairs, warm", [&] { (void)all.nearest(at[1].next()); }});
  compare(table, row, [&] { (void)nearest(at[0].next()); }, functions);
}

void characters_of_20(Table& table) { nearest_rows(table, 1); }
void characters_of_200(Table& table) { nearest_rows(table, 10); }
const RowRegistration register_20(300, characters_of_20);
const RowRegistration register_200(310, characters_of_200);

/// Adds the row of pairs within a margin. All libraries use Ugoki's closed-form functions for the distances of their pairs.
void swarm(Table& table) {
  constexpr int bodies = 2000;
  constexpr double margin = 0.02;
  const std::string row = std::to_string(bodies) + " capsules, pairs within 20 mm";
  const Motion motion = make_swarm(bodies);
  Distances distances(motion);
  collision::SuperiorTree tree(tree_bodies(motion));
  collision::PairsWithin query({});
  std::vector<collision::NearPair> found;
  const auto count = [&](int step) {
    distances.set(step);
    tree.update(motion.at(step));
    query.find(tree, margin, distances, found);
    return static_cast<int>(found.size());
  };
  struct Plain {
    Distances& distances;
    PairCache cache;
  } plain{distances, {}};
  const PlainDistance distance = [](void* context, int i, int j) {
    auto& p = *static_cast<Plain*>(context);
    return p.distances.distance(i, j, margin, p.cache).distance;
  };
  std::vector<std::unique_ptr<BodiesPeer>> peers;
  peers.push_back(make_fcl_bodies(motion.plain, margin));
  peers.push_back(make_bullet_bodies(motion.plain, margin));
  std::erase(peers, nullptr);
  for (int step = 0; step < motion.plain.steps; ++step) {
    const int ours = count(step);
    for (const auto& p : peers) {
      const int theirs = p->count_within(step, margin, distance, &plain);
      if (theirs != ours)
        throw std::runtime_error(row + ": " + std::to_string(ours) + " pairs, " + p->name() + " " + std::to_string(theirs));
    }
  }
  std::vector<Steps> at(peers.size() + 1, Steps{motion.plain.steps});
  std::vector<std::pair<std::string, std::function<void()>>> functions;
  for (std::size_t i = 0; i < peers.size(); ++i)
    functions.push_back({peers[i]->name(), [&, i] {
                           const int step = at[i + 1].next();
                           distances.set(step);
                           (void)peers[i]->count_within(step, margin, distance, &plain);
                         }});
  compare(table, row, [&] { (void)count(at[0].next()); }, functions);
}
const RowRegistration register_swarm(320, swarm);

}  // namespace
}  // namespace ugoki::benchmarks
