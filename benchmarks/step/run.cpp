#include "run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <stdexcept>

namespace ugoki::benchmarks {
namespace {

constexpr int repetitions = 3;
constexpr int sample_steps = 25;         // number of steps from one computation of the energy to the next
constexpr double time_limit = 10;        // s: a repetition ends after this time
constexpr double energy_slack = 0.05;    // maximum growth as a fraction of the initial energy; the energy leaves out springs
constexpr double fall_tolerance = 2e-4;  // m, maximum difference from Ugoki's positions after 0.1 s, because integrators and springs differ

struct Engine {
  std::string name;
  std::function<StepWorldPtr(const StepSource&)> make;
  bool armature;  ///< true: joints have armature; false: it is part of the links' inertia, and the check of the conversion omits it
};

const std::vector<Engine>& engines() {
  static const std::vector<Engine> all = {{"Ugoki", make_ugoki, true},
                                          {"MuJoCo 2.2 Newton", make_mujoco_newton, true},
                                          {"MuJoCo 2.2 PGS", make_mujoco_pgs, true},
                                          {"Bullet 3.24", make_bullet, false},
                                          {"DART 6.12", make_dart, false}};
  return all;
}

/// One engine's run of a scene.
struct Run {
  const Engine* engine = nullptr;
  std::vector<double> ns;                                                            ///< [steps] ns, minimum over the repetitions
  std::vector<double> depth;                                                         ///< [steps] m, maximum penetration
  std::vector<int> contacts;                                                         ///< [steps] number of contact points
  double begin_energy = 0, lowest_energy = 0, last_kinetic = 0, last_potential = 0;  ///< J
  std::vector<Frame> end;                                                            ///< poses after the last step
  bool repeats = true;                                                               ///< true: all repetitions end in the same positions
  std::string failure;                                                               ///< empty: all checks passed
};

/// Kinetic and potential energy of the motion between two instants.
struct Energy {
  double kinetic = 0, potential = 0;  ///< J
  double lowest = 0;                  ///< m, height of the lowest centre of mass
};

Energy energy_of(const StepScene& scene, const std::vector<Frame>& before, const std::vector<Frame>& after) {
  Energy out;
  out.lowest = std::numeric_limits<double>::infinity();
  std::size_t k = 0;
  for (const StepBody& b : scene.bodies)
    for (const StepLink& l : b.links) {
      if (l.mass == 0) continue;
      const Frame x = before.at(k) * l.principal, y = after.at(k) * l.principal;
      ++k;
      double v2 = 0;
      for (int i = 0; i < 3; ++i) v2 += (y.p[i] - x.p[i]) * (y.p[i] - x.p[i]);
      Frame turn = inverse(x) * y;  // small rotation; w is its rotation vector in the link
      const double w[3] = {0.5 * (turn.R[7] - turn.R[5]), 0.5 * (turn.R[2] - turn.R[6]), 0.5 * (turn.R[3] - turn.R[1])};
      double spin = 0;
      for (int i = 0; i < 3; ++i) spin += l.moments[i] * w[i] * w[i];
      out.kinetic += 0.5 * (l.mass * v2 + spin) / (scene.dt * scene.dt);
      out.potential += l.mass * scene.gravity * y.p[2];
      out.lowest = std::min(out.lowest, y.p[2]);
    }
  return out;
}

std::string check(const StepScene& scene, Run& run, int step, const Energy& e) {
  const double total = e.kinetic + e.potential;
  char text[160];
  if (!std::isfinite(total)) return "the state is not finite at step " + std::to_string(step);
  if (step == 0) run.begin_energy = run.lowest_energy = total;
  run.last_kinetic = e.kinetic;
  run.last_potential = e.potential;
  if (total > run.lowest_energy + energy_slack * run.begin_energy) {
    std::snprintf(text, sizeof text, "the energy grows from %.4g J to %.4g J at step %d (%.4g J at the beginning)", run.lowest_energy,
                  total, step, run.begin_energy);
    return text;
  }
  run.lowest_energy = std::min(run.lowest_energy, total);
  if (e.lowest < -scene.sunk) {
    std::snprintf(text, sizeof text, "a link is at z = %.3g m at step %d", e.lowest, step);
    return text;
  }
  return {};
}

void repeat(const StepSource& source, Run& run, int repetition) {
  using Clock = std::chrono::steady_clock;
  const int steps = repetition == 0 ? source.steps() : static_cast<int>(run.ns.size());
  std::vector<Frame> before, after;
  double spent = 0;
  try {
    const StepWorldPtr world = run.engine->make(source);
    int i = 0;
    for (; i < steps && spent < time_limit * 1e9; ++i) {
      const bool sample = repetition == 0 && (i % sample_steps == 0 || i == steps - 1);
      if (sample) world->poses(before);
      const auto begin = Clock::now();
      world->step();
      const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
      spent += ns;
      if (repetition > 0) {
        run.ns[static_cast<std::size_t>(i)] = std::min(run.ns[static_cast<std::size_t>(i)], ns);
        continue;
      }
      run.ns.push_back(ns);
      run.depth.push_back(world->depth());
      run.contacts.push_back(world->contacts());
      if (!sample) continue;
      world->poses(after);
      run.failure = check(source, run, i, energy_of(source, before, after));
      if (!run.failure.empty()) return;
    }
    world->poses(after);
    if (repetition == 0) run.end = after;
    if (i < static_cast<int>(run.ns.size())) return;  // this repetition completed fewer steps than the first
    for (std::size_t k = 0; k < std::min(after.size(), run.end.size()); ++k)
      run.repeats = run.repeats && std::equal(after[k].p, after[k].p + 3, run.end[k].p);
  } catch (const StepLimit& limit) {
    if (repetition == 0)
      std::printf("  %s: %s stops at step %d: %s\n", source.name.c_str(), run.engine->name.c_str(), static_cast<int>(run.ns.size()),
                  limit.what());
  } catch (const std::exception& error) {
    run.failure = error.what();
    return;
  }
  if (repetition == 0 && run.last_potential < source.stands * run.begin_energy) run.failure = "it has fallen";
  if (repetition == 0 && static_cast<int>(run.ns.size()) == steps && run.last_kinetic > source.rest_energy * run.begin_energy) {
    char text[160];
    std::snprintf(text, sizeof text, "not at rest at the end: %.3g J of %.4g J", run.last_kinetic, run.begin_energy);
    run.failure = text;
  }
}

/// Compares mass, DOFs and the free fall of the first 0.1 s of an engine with Ugoki's. Returns the maximum distance [m] between
/// corresponding centres of mass.
double check_conversion(const StepSource& source, const Engine& engine) {
  const StepSource probe = source.probe(0.5, 100, engine.armature);
  const StepWorldPtr ours = make_ugoki(probe), peer = engine.make(probe);
  if (peer->dofs() != ours->dofs())
    throw std::runtime_error(std::to_string(peer->dofs()) + " DOFs instead of " + std::to_string(ours->dofs()));
  if (!(std::fabs(peer->mass() - ours->mass()) <= 1e-5 * ours->mass()))
    throw std::runtime_error("mass " + std::to_string(peer->mass()) + " kg instead of " + std::to_string(ours->mass()));
  for (int i = 0; i < 50; ++i) {
    ours->step();
    peer->step();
  }
  std::vector<Frame> a, b;
  ours->poses(a);
  peer->poses(b);
  double worst = 0;
  std::size_t k = 0;
  for (const StepBody& body : probe.bodies)
    for (const StepLink& l : body.links) {
      if (l.mass == 0) continue;
      const Frame x = a.at(k) * l.principal, y = b.at(k) * l.principal;
      ++k;
      const double distance = std::hypot(x.p[0] - y.p[0], x.p[1] - y.p[1], x.p[2] - y.p[2]);
      worst = distance <= worst ? worst : distance;  // a NaN distance stays NaN
    }
  return worst;
}

double mean(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += x[i];
  return sum / static_cast<double>(end - begin);
}

void add_rows(Table& table, const StepSource& source, const std::vector<Run>& runs) {
  const Run& ours = runs[0];
  std::size_t begin = 0;
  for (const StepPhase& phase : source.phases) {
    const std::size_t end = begin + static_cast<std::size_t>(phase.steps);
    for (const Run& peer : runs) {
      const std::size_t last = std::min({end, ours.ns.size(), peer.ns.size()});
      if ((&peer == &ours && runs.size() > 1) || last < begin + 10) continue;
      const auto percentile = [&](const Run& r, double fraction) {
        std::vector<double> ns(r.ns.begin() + static_cast<std::ptrdiff_t>(begin), r.ns.begin() + static_cast<std::ptrdiff_t>(last));
        std::ranges::sort(ns);
        return ns[static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(ns.size()))) - 1];
      };
      const double p999 = percentile(ours, 0.999), max = percentile(ours, 1);
      const auto depth = [&](const Run& r) {
        return 1e3 *
               *std::max_element(r.depth.begin() + static_cast<std::ptrdiff_t>(begin), r.depth.begin() + static_cast<std::ptrdiff_t>(last));
      };
      const auto count = [&](const Run& r) { return mean({r.contacts.begin(), r.contacts.end()}, begin, last); };
      Row row{.row = phase.row, .ours_ns = mean(ours.ns, begin, last), .peer = {}};
      row.extra = {{"ours_p999_ns", p999}, {"ours_max_ns", max}, {"ours_depth_mm", depth(ours)}, {"ours_contacts", count(ours)}};
      char text[160];
      std::snprintf(text, sizeof text, "p99.9 %6.0f us, max %6.0f us; depth %6.2f mm", 1e-3 * p999, 1e-3 * max, depth(ours));
      row.note = text;
      if (&peer != &ours) {
        row.peer = peer.engine->name;
        row.peer_ns = mean(peer.ns, begin, last);
        row.extra.emplace_back("peer_p999_ns", percentile(peer, 0.999));
        row.extra.emplace_back("peer_depth_mm", depth(peer));
        row.extra.emplace_back("peer_contacts", count(peer));
        std::snprintf(text, sizeof text, ", peer %6.2f mm; contacts %.0f, peer %.0f", depth(peer), count(ours), count(peer));
        row.note += text;
      }
      if (last < end) row.note += "; first " + std::to_string(last - begin) + " steps";
      if (last < end) row.extra.emplace_back("steps", static_cast<double>(last - begin));
      if (!peer.repeats) row.note += "; the peer's repetitions differ";
      if (!peer.failure.empty()) row.note += "; FAILED";
      table.add(row);
    }
    begin = end;
  }
}

}  // namespace

void run_scene(Table& table, const StepSource& source) {
  if (std::ranges::none_of(source.phases, [](const StepPhase& p) { return is_selected(p.row); })) return;
  if (source.partly_excluded > 0)
    std::printf("  %s: %d pairs of links are partly excluded in ours and wholly in the peers\n", source.name.c_str(),
                source.partly_excluded);
  std::vector<Run> runs;
  std::string failures;
  const auto fail = [&](const Engine& e, const std::string& what) { failures += (failures.empty() ? "" : "; ") + e.name + ": " + what; };
  for (const Engine& e : engines()) {
    try {
      if (e.make(source) == nullptr) {
        std::printf("  %s: %s is not installed\n", source.name.c_str(), e.name.c_str());
        continue;
      }
    } catch (const std::exception& error) {  // a limitation of the peer, not a failure of the run
      std::printf("  %s: left out: %s\n", source.name.c_str(), error.what());
      continue;
    }
    if (&e == engines().data()) {
      runs.emplace_back().engine = &e;
      continue;
    }
    try {
      const double distance = check_conversion(source, e);
      std::printf("  %s: %s: free fall differs by %.3g mm\n", source.name.c_str(), e.name.c_str(), 1e3 * distance);
      if (!(distance <= fall_tolerance)) fail(e, "falls freely in another way, by " + std::to_string(distance) + " m after 0.1 s");
    } catch (const std::exception& error) {
      fail(e, error.what());
      continue;
    }
    runs.emplace_back().engine = &e;
  }
  for (int k = 0; k < repetitions; ++k)  // engines alternate; every repetition runs as many steps as the first one
    for (Run& run : runs)
      if (k == 0 || !run.ns.empty()) repeat(source, run, k);
  for (const Run& run : runs)
    if (!run.failure.empty()) fail(*run.engine, run.failure);
  if (!runs.empty() && runs[0].engine == engines().data()) add_rows(table, source, runs);
  if (!failures.empty()) throw std::runtime_error(source.name + ": " + failures);
}

}  // namespace ugoki::benchmarks
