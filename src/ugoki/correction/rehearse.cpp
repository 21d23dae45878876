#include "ugoki/correction/rehearse.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "ugoki/base/number.h"
#include "ugoki/correction/assisted_run.h"
#include "ugoki/correction/observe.h"
#include "ugoki/correction/sample_cost.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/world/world.h"

namespace ugoki::correction {
namespace {

constexpr double window = 0.1;       // s
constexpr double ramp = 0.04;        // s: time in which the offsets of a window replace those of the one before
constexpr double spread = 0.08;      // rad: standard deviation of the offsets in the first round of a window
constexpr int rounds = 3;            // of a window: each further round samples around the best ones with half the deviation
constexpr double persistence = 0.8;  // share of the offsets that the next window begins with
constexpr double bend = 0.2;         // rad: error of a joint at which its servo uses the whole torque limit
constexpr double damping = 0.0573;   // s: damping of a joint divided by its stiffness, as in GetUpOptions
constexpr double strong = 0.6;       // joints with at least this share of the largest torque limit get offsets
constexpr double effort_cost = 0.3;  // of a squared offset, rad^-2

/// Random numbers with the same bits on every machine (Steele, Lea, Flood 2014: SplitMix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// Approximately normal, mean 0 and standard deviation 1: the sum of twelve uniform numbers.
  double normal() {
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += static_cast<double>(next() >> 11U) * 0x1.0p-53;
    return sum;
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
};

/// The end of a window: the state, and the offsets of the joints that led to it.
struct Sample {
  world::WorldState state;
  std::vector<double> offsets;  // [nv] rad
  double cost = 0;
  int parent = -1;  // index in the window before
  bool lost = false;
};

class Rehearsal {
 public:
  Rehearsal(const MechanismPtr& mechanism, const Motion& motion, const RehearseOptions& options)
      : m_(*mechanism),
        options_(options),
        world_({mechanism}, world_options(options)),
        stepper_(world_),
        windows_(std::max(1, static_cast<int>(std::ceil(motion.duration() / window - 1e-9)))),
        cost_(m_),
        random_(options.seed),
        state_(world_) {
    run_ = run_assisted(mechanism, motion, world_, windows_ * window_steps());
    const std::size_t nv = world_.nv();
    for (std::vector<double>* x : {&tau_, &gain_, &velocity_, &offset_, &error_, &limit_}) x->resize(nv);
    target_.resize(world_.nq());
    double strongest = 0;
    for (std::size_t i = 6; i < nv; ++i) {
      const double effort = m_.dof(static_cast<int>(i)).effort;
      limit_[i] = std::isfinite(effort) ? effort : 9.81 * m_.mass();  // N m: a drive without a limit holds the weight at 1 m
      strongest = std::max(strongest, limit_[i]);
    }
    for (std::size_t i = 6; i < nv; ++i)
      if (limit_[i] > 0 && limit_[i] >= strong * strongest) dofs_.push_back(static_cast<int>(i));
  }

  /// @param reached [out] s
  Result<std::vector<std::vector<double>>> run(const std::string& where, double& reached) {
    if (run_.steps() < windows_ * window_steps() || dofs_.empty())
      return fail(ErrorCode::structure, where, "The motion cannot be simulated.", "Check masses and joint limits of the mechanism.");
    std::vector<std::vector<Sample>> tree(1);
    std::ranges::copy(run_.q[0], state_.q(0).begin());
    std::ranges::copy(run_.v[0], state_.v(0).begin());
    tree[0].push_back({state_, std::vector<double>(world_.nv()), 0, -1, false});
    for (int w = 0; w < windows_; ++w) {
      if (options_.progress && !options_.progress(static_cast<double>(w) / windows_))
        return fail(ErrorCode::cancelled, "", "The correction was cancelled.");
      tree.push_back(sample_window(w, tree.back()));
      if (tree.back().empty() || tree.back().front().lost)
        return fail(ErrorCode::range, where, "The body loses the motion after " + to_fixed(reached, 1) + " s.",
                    "Make the motion slower there, give it more support, or use more samples.");
      reached = (w + 1) * window;
    }
    return replay(tree);
  }

  [[nodiscard]] const RecordedRun& assisted() const { return run_; }

 private:
  static world::WorldOptions world_options(const RehearseOptions& options) {
    world::WorldOptions o;
    o.stepper.gravity = {0, 0, -options.gravity};
    o.ground.friction = options.friction;
    return o;
  }
  [[nodiscard]] int window_steps() const { return static_cast<int>(std::lround(window / run_.step)); }

  /// Simulates a window from `from`: the recorded torques, and servos towards the recorded states plus offsets, which change from `before`
  /// to `offsets`. @param record [out] positions after each step; may be null @return false: a step has failed
  bool simulate(int w, const world::WorldState& from, const std::vector<double>& before, const std::vector<double>& offsets,
                std::vector<std::vector<double>>* record) {
    stepper_.load(from);
    state_ = from;
    const double h = run_.step;
    for (int k = 0; k < window_steps(); ++k) {
      const auto step = static_cast<std::size_t>(w * window_steps() + k);
      const double share = std::min(1.0, (k + 1) * h / ramp);
      for (const int i : dofs_) {
        const auto d = static_cast<std::size_t>(i);
        offset_[d] = before[d] + (offsets[d] - before[d]) * share;
      }
      integrate(m_, run_.q[step + 1], offset_, 1, target_);
      difference(m_, state_.q(0), target_, error_);
      for (std::size_t i = 6; i < limit_.size(); ++i) {
        const double kp = limit_[i] / bend, kd = kp * damping;
        tau_[i] = std::clamp(run_.tau[step][i], -limit_[i], limit_[i]);
        gain_[i] = kd + h * kp;
        if (!(gain_[i] > 0)) continue;
        // kp (error - h v') + kd (v_recorded - v') = gain (velocity - v')
        const double wanted = (kp * error_[i] + kd * run_.v[step + 1][i]) / gain_[i], v = state_.v(0)[i];
        velocity_[i] = std::clamp(wanted, v + (-limit_[i] - tau_[i]) / gain_[i], v + (limit_[i] - tau_[i]) / gain_[i]);
      }
      if (stepper_.step({tau_, gain_, velocity_}, h).status != contact::StepStatus::ok) return false;
      stepper_.store(state_);
      if (record) record->emplace_back(state_.q(0).begin(), state_.q(0).end());
    }
    return true;
  }

  /// The best states after window w.
  std::vector<Sample> sample_window(int w, const std::vector<Sample>& from) {
    const auto end = static_cast<std::size_t>((w + 1) * window_steps());
    cost_.set_goal(run_.q[end], run_.v[end], dofs_);
    std::vector<Sample> found;
    const auto keep_best = [&] {
      std::ranges::sort(found, {}, &Sample::cost);
      if (found.size() > static_cast<std::size_t>(options_.kept)) found.erase(found.begin() + options_.kept, found.end());
    };
    double deviation = spread;
    for (int round = 0; round < rounds; ++round, deviation *= 0.5) {
      const std::size_t base = found.size();
      if (round > 0 && base == 0) break;
      for (int k = 0; k < options_.samples / rounds; ++k) {
        const auto index = static_cast<std::size_t>(k) % (round == 0 ? from.size() : base);
        const int parent = round == 0 ? static_cast<int>(index) : found[index].parent;
        const Sample& start = from[static_cast<std::size_t>(parent)];
        std::vector<double> offsets(world_.nv());
        const bool plain = round == 0 && static_cast<std::size_t>(k) < from.size();
        for (const int i : dofs_) {
          const auto d = static_cast<std::size_t>(i);
          offsets[d] = (round == 0 ? persistence * start.offsets[d] : found[index].offsets[d]) + (plain ? 0 : deviation * random_.normal());
        }
        if (!simulate(w, start.state, start.offsets, offsets, nullptr)) continue;
        double cost = cost_(state_.q(0), state_.v(0));
        for (const int i : dofs_) cost += effort_cost * offsets[static_cast<std::size_t>(i)] * offsets[static_cast<std::size_t>(i)];
        found.push_back({state_, std::move(offsets), cost, parent, cost_.is_lost()});
      }
      keep_best();
    }
    return found;
  }

  /// Positions of the best simulation after each step; the first ones are those at time 0.
  std::vector<std::vector<double>> replay(const std::vector<std::vector<Sample>>& tree) {
    std::vector<const Sample*> path(tree.size());
    for (std::size_t w = tree.size(), index = 0; w-- > 0; index = static_cast<std::size_t>(std::max(0, path[w]->parent)))
      path[w] = &tree[w][index];
    std::vector<std::vector<double>> out{run_.q[0]};
    for (std::size_t w = 1; w < path.size(); ++w)
      simulate(static_cast<int>(w) - 1, path[w - 1]->state, path[w - 1]->offsets, path[w]->offsets, &out);
    return out;
  }

  const Mechanism& m_;
  const RehearseOptions& options_;
  world::World world_;
  world::WorldStepper stepper_;
  int windows_;
  RecordedRun run_;
  SampleCost cost_;
  Random random_;
  world::WorldState state_;
  std::vector<int> dofs_;  // velocity indices of the joints with offsets
  std::vector<double> tau_, gain_, velocity_, offset_, error_, limit_, target_;
};

}  // namespace

Result<Motion> rehearse_motion(const MechanismPtr& mechanism, const Motion& motion, const RehearseOptions& options,
                               RehearseReport* report) {
  const Mechanism& m = *mechanism;
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  const std::string where = "motion " + motion.name;
  if (m.link_count() == 0 || m.link(0).joint.type != JointType::floating)
    return fail(ErrorCode::structure, where, "The root of the mechanism is not floating, so that there is no balance to correct.",
                "Use a mechanism with a floating root.");
  if (!(options.gravity > 0 && options.gravity < 1000) || !(options.friction >= 0 && options.friction <= 10) || options.kept < 1 ||
      options.samples < options.kept || options.samples > 1000000)
    return fail(
        ErrorCode::range, where, "Gravity, friction or the number of samples is out of range.",
        "Use a gravity above 0 and below 1000 m/s^2, a friction from 0 to 10, and up to a million samples, at least as many as are kept.");
  RehearseReport unused;
  RehearseReport& reported = report ? *report : unused;
  reported = {};
  Rehearsal rehearsal(mechanism, motion, options);
  reported.assist_bw = rehearsal.assisted().assist_bw;
  const Result<std::vector<std::vector<double>>> states = rehearsal.run(where, reported.reached);
  if (!states) return fail(states.error());
  Motion out = motion;
  out.torques = nullptr;
  out.contacts.clear();
  out.cyclic = false;
  for (int f = 0; f < out.frames; ++f) {
    const double at = f / (out.rate * rehearsal.assisted().step);
    const auto step = std::min(static_cast<std::size_t>(at), states->size() - 2);
    interpolate(m, (*states)[step], (*states)[step + 1], std::min(1.0, at - static_cast<double>(step)),
                {out.frame(f), static_cast<std::size_t>(out.nq)});
  }
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(m, out, motion_edit::FootContactOptions{});
  if (!contacts.feet.empty()) motion_edit::set_labels(m, contacts, out);
  reported.change_deg = rms_change(m, motion, out, reported.root_move_cm);
  return out;
}

}  // namespace ugoki::correction
