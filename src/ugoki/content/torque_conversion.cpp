#include "ugoki/content/torque_conversion.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/hash.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/player.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/torques.h"

namespace ugoki::content {
namespace {

constexpr double degrees = 180 / pi;
constexpr double path_rate = 125;  // Hz: wanted rate of the coordinates that are stored with torques, for display

/// Sums of the deviations of one mechanism.
class DeviationSum {
 public:
  explicit DeviationSum(const Mechanism& m) : m_(&m), error_(static_cast<std::size_t>(m.nv())) {
    floating_ = m.link(0).joint.type == JointType::floating;
    for (const Link& link : m.links())
      for (int k = 0; k < link.joint.nv(); ++k) {
        using enum JointType;
        const JointType type = link.joint.type;
        turns_.push_back(!(type == prismatic || (type == cylindrical && k == 1) || (type == planar && k < 2) || type == floating));
      }
  }
  void add(std::span<const double> wanted, std::span<const double> q) {
    difference(*m_, wanted, q, error_);
    for (std::size_t i = 0; i < error_.size(); ++i) {
      if (!turns_[i]) continue;
      squares_ += error_[i] * error_[i];
      ++count_;
      sum_.max_deg = std::max(sum_.max_deg, std::fabs(error_[i]) * degrees);
    }
    if (!floating_) return;
    sum_.root_deg = std::max(sum_.root_deg, norm(Vec3{error_[0], error_[1], error_[2]}) * degrees);
    sum_.root_mm = std::max(sum_.root_mm, norm(Vec3{error_[3], error_[4], error_[5]}) * 1000);
  }
  [[nodiscard]] Deviation value() const {
    Deviation out = sum_;
    out.rms_deg = count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) * degrees : 0;
    return out;
  }

 private:
  const Mechanism* m_;
  bool floating_ = false;
  std::vector<bool> turns_;  // [nv] the DOF is the rotation of a joint, not of the root
  std::vector<double> error_;
  double squares_ = 0;
  std::size_t count_ = 0;
  Deviation sum_;
};

/// A character whose run is recorded.
struct Recorded {
  std::size_t index;  // in the executable data
  std::string id;
  MechanismPtr mechanism;
  std::vector<double> q;    // [steps + 1][nq]
  std::vector<double> tau;  // [steps][nv]
  std::vector<double> v0;
};

Error cancelled() { return Error(ErrorCode::cancelled, "conversion", "The conversion was cancelled.", "Start it again."); }

/// Runs the player for `steps` steps and records the characters. @param applied drive forces of all characters; null: not recorded
Result<void> record(Player& player, std::uint64_t steps, const circuit::PinView* applied, std::vector<Recorded>& characters,
                    const ConversionOptions& options, double begin, double share) {
  const auto keep = [&](Recorded& c) {
    const std::span<const double> q = player.q(static_cast<int>(c.index));
    c.q.insert(c.q.end(), q.begin(), q.end());
  };
  for (Recorded& c : characters) {
    keep(c);
    const std::span<const double> v = player.v(static_cast<int>(c.index));
    c.v0.assign(v.begin(), v.end());
  }
  for (std::uint64_t k = 0; k < steps; ++k) {
    if (k % 64 == 0 && options.progress && !options.progress(begin + share * static_cast<double>(k) / static_cast<double>(steps)))
      return fail(cancelled());
    if (Result<void> done = player.step(); !done) return done;
    for (Recorded& c : characters) {
      keep(c);
      if (!applied) continue;
      std::size_t at = 0;
      for (std::size_t i = 0; i < c.index; ++i) at += player.v(static_cast<int>(i)).size();
      const std::span<const double> tau = applied->numbers().subspan(at, c.v0.size());
      c.tau.insert(c.tau.end(), tau.begin(), tau.end());
    }
  }
  return {};
}

std::vector<Recorded> characters_of(const Player& player, ControlMode mode, bool only) {
  std::vector<Recorded> out;
  const Executable& content = player.content();
  for (std::size_t i = 0; i < content.characters.size(); ++i) {
    const ExecutableCharacter& c = content.characters[i];
    if (c.control.mode == ControlMode::passive || c.track.empty() || (only && c.control.mode != mode)) continue;
    out.push_back({i, c.id, content.mechanisms[static_cast<std::size_t>(c.mechanism)], {}, {}, {}});
  }
  return out;
}

std::uint64_t step_count(const Scenario& scenario, const ConversionOptions& options) {
  const double duration = options.duration > 0 ? options.duration : scenario.duration;
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(duration / scenario.step)));
}

/// Sets the parameter `constant drives` of every LSI `dynamics`. @return number of these LSIs
int make_drives_constant(circuit::Circuit& circuit) {
  int count = 0;
  for (circuit::Instance& lsi : circuit.lsis) {
    if (lsi.type != "dynamics") continue;
    std::erase_if(lsi.parameters, [](const circuit::NamedValue& p) { return p.first == "constant drives"; });
    lsi.parameters.emplace_back("constant drives", 1.0);
    ++count;
  }
  return count;
}

std::string add_motion(Resources& resources, Motion motion) {
  Hash64 hash;
  const std::vector<std::byte> bytes = formats::write_motion(motion);
  hash.add_bytes(bytes.data(), bytes.size());
  std::string id = "n-" + hash.hex();
  resources.motions[id] = std::make_shared<const Motion>(std::move(motion));
  return id;
}

/// Makes the track of a character one clip with this motion.
void play(Scenario& scenario, const std::string& character, const std::string& motion, double duration, ControlMode mode) {
  ScenarioCharacter& c = *scenario.find_character(character);
  ScenarioClip clip;
  clip.id = c.track.empty() ? character + "-clip" : c.track.front().id;
  clip.motion = motion;
  clip.length = duration;
  clip.blend = 0;
  c.track = {clip};
  c.control.mode = mode;
}

/// Every `stride`-th frame of a recorded run as a motion.
Motion motion_of(const Recorded& c, std::size_t stride, double step, const std::string& name) {
  Motion out;
  out.name = name;
  out.mechanism = c.mechanism->name();
  out.rate = 1 / (static_cast<double>(stride) * step);
  out.nq = c.mechanism->nq();
  const auto nq = static_cast<std::size_t>(out.nq);
  for (std::size_t k = 0; (k + 1) * nq <= c.q.size(); k += stride) {
    out.q.insert(out.q.end(), c.q.begin() + static_cast<std::ptrdiff_t>(k * nq), c.q.begin() + static_cast<std::ptrdiff_t>((k + 1) * nq));
    ++out.frames;
  }
  return out;
}

std::string source_name(const Scenario& scenario, const Resources& resources, const std::string& character) {
  const ScenarioCharacter* const c = scenario.find_character(character);
  if (!c || c->track.empty()) return character;
  const auto it = resources.motions.find(c->track.front().motion);
  return it == resources.motions.end() || it->second->name.empty() ? character : it->second->name;
}

/// Forces on the root and torques above their limits.
void measure_torques(const Recorded& c, const Vec3& gravity, ConversionReport& report) {
  const Mechanism& m = *c.mechanism;
  const auto nv = static_cast<std::size_t>(m.nv());
  const bool floating = m.link(0).joint.type == JointType::floating;
  const double weight = m.mass() * norm(gravity);
  double squares = 0;
  std::size_t over = 0, count = 0;
  const std::size_t steps = c.tau.size() / nv;
  for (std::size_t k = 0; k < steps; ++k) {
    const double* const tau = c.tau.data() + k * nv;
    if (floating && weight > 0) {
      const double force = norm(Vec3{tau[3], tau[4], tau[5]}) / weight;
      squares += force * force;
      report.root_max_bw = std::max(report.root_max_bw, force);
    }
    for (std::size_t i = floating ? 6 : 0; i < nv; ++i, ++count) over += std::fabs(tau[i]) > m.dof(static_cast<int>(i)).effort ? 1 : 0;
  }
  report.root_rms_bw = std::sqrt(squares / static_cast<double>(steps));
  report.over_effort = count > 0 ? static_cast<double>(over) / static_cast<double>(count) : 0;
}

}  // namespace

Result<TorqueConversion> to_torques(const Scenario& scenario, const Resources& resources, const ConversionOptions& options) {
  if (!options.own_control && !scenario.circuit.empty())
    return fail(ErrorCode::unsupported, "circuit", "The content has a circuit of its own, which decides how its characters are driven.",
                "Convert it with its own control (--own-control), or reset the circuit to the generated one.");
  Scenario exact = scenario;  // the tracks as they are, for the run without own control and for comparison
  for (ScenarioCharacter& c : exact.characters)
    if (c.control.mode == ControlMode::track) c.control.mode = ControlMode::path;
  exact.circuit.clear();
  const Scenario& source = options.own_control ? scenario : exact;
  Scenario driven = source;
  Result<circuit::Circuit> circuit =
      circuit::read_circuit(driven.circuit.empty() ? default_circuit(played_part(driven)) : driven.circuit, "circuit");
  if (!circuit) return fail(std::move(circuit.error()));
  if (make_drives_constant(*circuit) != 1)
    return fail(ErrorCode::unsupported, "circuit", "The circuit does not contain exactly one LSI of the type `dynamics`.",
                "Reset the circuit to the generated one.");
  std::string pin;
  for (const circuit::Instance& lsi : circuit->lsis)
    if (lsi.type == "dynamics") pin = lsi.id + ".applied";
  driven.circuit = circuit::write_circuit(*circuit);

  const Result<std::vector<std::byte>> ugx = generate(driven, resources);
  if (!ugx) return fail(ugx.error());
  Result<Player> player = Player::open(*ugx, scenario.name);
  if (!player) return fail(std::move(player.error()));
  std::vector<Recorded> characters = characters_of(*player, ControlMode::track, false);
  if (characters.empty())
    return fail(ErrorCode::structure, "characters", "No character follows a track, so no motion can be converted.",
                "Give a character a clip, and the control mode \"track\".");
  const Result<circuit::PinView> applied = player->interpreter().find_output(pin);
  if (!applied) return fail(applied.error());
  const std::uint64_t steps = step_count(scenario, options);
  if (Result<void> done = record(*player, steps, &*applied, characters, options, 0, 0.6); !done) return fail(std::move(done.error()));
  const std::uint64_t hash = player->state_hash();

  const Result<std::vector<std::byte>> paths = generate(exact, resources);
  if (!paths) return fail(paths.error());
  const Result<Executable> path_content = read_executable(*paths, scenario.name);
  if (!path_content) return fail(path_content.error());
  const lsi::World path_world = make_world(*path_content);

  TorqueConversion out{{source, resources}, {}, false};
  out.content.scenario.circuit.clear();
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::floor(1 / (path_rate * scenario.step) + 0.5)));
  for (const Recorded& c : characters) {
    ConversionReport report;
    report.character = c.id;
    DeviationSum deviation(*c.mechanism);
    const lsi::TrackSampler& track = *path_world.characters()[c.index].track;
    std::vector<double> reference(track.layout().size());
    const std::size_t nq = static_cast<std::size_t>(c.mechanism->nq());
    for (std::size_t k = 0; k <= steps; ++k) {
      track.sample(static_cast<double>(k) * scenario.step, reference);
      deviation.add(std::span<const double>(reference).first(nq), std::span<const double>(c.q).subspan(k * nq, nq));
    }
    report.deviation = deviation.value();
    measure_torques(c, scenario.gravity, report);
    Motion motion = motion_of(c, stride, scenario.step, source_name(scenario, resources, c.id) + " (torques)");
    auto torques = std::make_shared<MotionTorques>();
    torques->step = scenario.step;
    torques->q0.assign(c.q.begin(), c.q.begin() + static_cast<std::ptrdiff_t>(nq));
    torques->v0 = c.v0;
    torques->tau = c.tau;
    torques->path = path_hash(motion);
    motion.torques = std::move(torques);
    const double duration = std::max(motion.duration(), 0.001);
    report.motion = add_motion(out.content.resources, std::move(motion));
    play(out.content.scenario, c.id, report.motion, duration, ControlMode::torque);
    out.characters.push_back(std::move(report));
  }

  const Result<std::vector<std::byte>> replay_data = generate(out.content.scenario, out.content.resources);
  if (!replay_data) return fail(replay_data.error());
  Result<Player> replay = Player::open(*replay_data, scenario.name);
  if (!replay) return fail(std::move(replay.error()));
  std::vector<Recorded> none;
  if (Result<void> done = record(*replay, steps, nullptr, none, options, 0.6, 0.4); !done) return fail(std::move(done.error()));
  out.replays = replay->state_hash() == hash;
  return out;
}

Result<AngleConversion> to_angles(const Scenario& scenario, const Resources& resources, const ConversionOptions& options) {
  const Result<std::vector<std::byte>> ugx = generate(scenario, resources);
  if (!ugx) return fail(ugx.error());
  Result<Player> player = Player::open(*ugx, scenario.name);
  if (!player) return fail(std::move(player.error()));
  std::vector<Recorded> characters = characters_of(*player, ControlMode::torque, true);
  if (characters.empty())
    return fail(ErrorCode::structure, "characters", "No character has the control mode \"torque\", so no torques can be converted.",
                "Convert a motion with `ugoki motion torques` first.");
  std::uint64_t steps = step_count(scenario, options);
  const auto stride =
      options.rate > 0 ? static_cast<std::size_t>(std::max(1.0, std::floor(1 / (options.rate * scenario.step) + 0.5))) : std::size_t{1};
  steps -= steps % stride;
  steps = std::max<std::uint64_t>(steps, stride);
  if (Result<void> done = record(*player, steps, nullptr, characters, options, 0, 1); !done) return fail(std::move(done.error()));
  AngleConversion out{{scenario, resources}, {}};
  for (const Recorded& c : characters) {
    ConversionReport report;
    report.character = c.id;
    Motion motion = motion_of(c, stride, scenario.step, source_name(scenario, resources, c.id) + " (angles)");
    DeviationSum deviation(*c.mechanism);
    const std::size_t nq = static_cast<std::size_t>(c.mechanism->nq());
    std::vector<double> q(nq);
    for (std::size_t k = 0; k <= steps; ++k) {
      sample(motion, *c.mechanism, static_cast<double>(k) * scenario.step, q);
      deviation.add(q, std::span<const double>(c.q).subspan(k * nq, nq));
    }
    report.deviation = deviation.value();
    const Placement place = root_placement(*c.mechanism, {motion.frame(0), nq});
    const double duration = motion.duration();
    report.motion = add_motion(out.content.resources, std::move(motion));
    play(out.content.scenario, c.id, report.motion, duration, ControlMode::path);
    out.content.scenario.find_character(c.id)->place = {place.x, place.y, 0, place.heading * degrees};
    out.characters.push_back(std::move(report));
  }
  return out;
}

}  // namespace ugoki::content
