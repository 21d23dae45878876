#include "scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>

#include "ugoki/base/hash.h"
#include "ugoki/base/number.h"
#include "ugoki/body/body.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/gait/gait.h"
#include "ugoki/intake/intake.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/reference.h"
#include "ugoki/motion/torques.h"
#include "ugoki/samples/samples.h"

namespace ugoki::bench {
namespace {

/// Processor time used by this thread, s. It does not include other load on the machine.
double processor_time() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

Result<ClipFile> read_clip(const std::string& path) {
  if (path == "sample-dog-trot" || path == "sample-dog-stand") {
    const MechanismPtr dog = samples::make_dog();
    return ClipFile{
        path, dog,
        std::make_shared<const Motion>(path == "sample-dog-trot" ? samples::make_dog_trot(*dog) : samples::make_dog_stand(*dog))};
  }
  if (path == "sample-stand" || path == "sample-walk") {
    const MeasuredMotion measured = path == "sample-stand" ? samples::make_human_stand() : samples::make_human_walk();
    Result<body::Body> body = body::make_body(samples::make_human_walk());
    if (!body) return fail(std::move(body.error()));
    Motion motion = body::to_motion(*body, measured);
    motion.cyclic = true;
    return ClipFile{path, body->mechanism, std::make_shared<const Motion>(std::move(motion))};
  }
  if (path.starts_with("gait-")) {
    const std::optional<double> speed = parse_double(path.substr(5));
    if (!speed) return fail(ErrorCode::syntax, path, "This is not a gait.", "Give the speed in m/s, for example gait-1.25.");
    Result<body::Body> body = body::make_body(samples::make_human_walk());
    if (!body) return fail(std::move(body.error()));
    gait::GaitOptions options;
    options.stages = {{0, gait::GaitKind::walk, *speed, 0}};
    options.seconds = 60;
    Result<Motion> motion = gait::make_gait(body->mechanism, options);
    if (!motion) return fail(std::move(motion.error()));
    return ClipFile{path, body->mechanism, std::make_shared<const Motion>(std::move(*motion))};
  }
  Result<std::string> text = files::read_file(path);
  if (!text) return fail(std::move(text.error()));
  std::optional<formats::Asf> skeleton;
  if (intake::file_kind(path) == intake::FileKind::amc) {
    const std::string asf_path = intake::skeleton_name_for(path);
    Result<std::string> asf_text = files::read_file(asf_path);
    if (!asf_text) return fail(std::move(asf_text.error()));
    Result<formats::Asf> asf = formats::read_asf(*asf_text, asf_path, {});
    if (!asf) return fail(std::move(asf.error()));
    skeleton = std::move(*asf);
  }
  Result<intake::Intake> loaded = intake::take_in(*text, path, skeleton ? &*skeleton : nullptr, {});
  if (!loaded) return fail(std::move(loaded.error()));
  if (!loaded->motion) return fail(ErrorCode::structure, path, "The file has no motion.", "Specify a BVH or AMC file.");
  return ClipFile{std::filesystem::path(path).stem().string(), loaded->mechanism,
                  std::make_shared<const Motion>(std::move(*loaded->motion))};
}

MotionReference::MotionReference(MechanismPtr mechanism, const Motion& motion, double length)
    : mechanism_(std::move(mechanism)), motion_(make_reference(motion, *mechanism_, 0)) {
  clip_.length = length > 0 ? length : motion.duration();
  clip_.loop = motion.cyclic;
  if (motion.cyclic) clip_.cycle = cycle_of(motion, *mechanism_);
  if (!is_computed(motion)) return;
  for (const ContactTrack& track : motion.contacts)
    if (const int link = mechanism_->find_link(track.link); link >= 0) contacts_.emplace_back(link, track.on);
}

bool MotionReference::contacts(double t, std::span<std::uint8_t> on) const {
  if (contacts_.empty()) return false;
  const double time = phase_of(clip_, motion_.duration(), t).time;
  const auto frame =
      static_cast<std::size_t>(std::clamp(std::floor(time * motion_.rate() + 0.5), 0.0, static_cast<double>(motion_.frames() - 1)));
  std::ranges::fill(on, std::uint8_t{0});
  for (const auto& [link, labels] : contacts_) on[static_cast<std::size_t>(link)] = labels[frame];
  return true;
}

void MotionReference::sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const {
  ugoki::sample(clip_, motion_, *mechanism_, t, q, v, a);
}

namespace {

/// The character and the ground around it.
struct Surroundings {
  Surroundings(const MechanismPtr& mechanism, const RunSettings& settings, const Vec3& start, const Vec3& direction, const Vec3& middle)
      : centre(middle),
        ground{settings.terrain.level() ? 0.0 : -1000.0, settings.friction, 0},
        systems(settings.terrain.level()
                    ? std::vector{mechanism}
                    : std::vector{mechanism, make_terrain(settings.terrain, start, direction, middle, settings.friction)}),
        scene(systems, ground, {true, true, settings.self_collision}),
        workspace(scene),
        stepper(systems, {}),
        guard(scene, stepper) {}
  [[nodiscard]] control::GroundMap map() const { return {systems, 0, ground.height}; }

  Vec3 centre;  // m, world: where the terrain was built
  collision::Ground ground;
  std::vector<MechanismPtr> systems;
  collision::Scene scene;
  collision::Workspace workspace;
  contact::Stepper stepper;
  contact::GuardedStep guard;
};

/// Prints a line for each landing of a foot. Lengths along the heading of the character, in m; errors of the DCM, speeds in m/s.
class LandingTrace {
 public:
  void update(double t, const control::BalanceControl& control, const control::BalanceOutput& result, const control::BalanceState& memory) {
    const control::BalanceModel& model = control.model();
    const Vec3 ahead = model.heading(), left = model.left();
    const Vec3 centre = model.centroid.centre, v = model.centroid.velocity, e = result.dcm_error;
    for (std::size_t f = 0; f < control.feet().size(); ++f) {
      const bool on = memory.feet[f].stands != 0;
      if (on && !stood_[f] && t > 0) {
        const control::BalanceState::FootState& foot = memory.feet[f];
        const control::BalanceState::FootState& other = memory.feet[1 - f];
        const control::ScheduledFoot planned = control.schedule().at(f, memory.time);
        const Vec3 sole = model.sole(f), sole_ref = model.reference_sole(f);
        double low = 9, high = -9;
        int bearing = 0;
        for (const control::BearingPoint& b : control.support().bearing())
          if (b.foot == static_cast<int>(f)) {
            const double x = dot(b.p - sole, ahead);
            low = std::min(low, x), high = std::max(high, x), ++bearing;
          }
        std::printf(
            "landing %.3f foot %zu early %d ref %.3f untilend %.3f e %.4f %.4f shift %.4f %.4f place %.4f vz %.3f vzref %.3f v %.3f "
            "vref %.3f L %.4f Lref %.4f z %.4f to %.4f other %.4f lower %.4f bear %d %.3f %.3f rate %.2f h %.3f tilt %.3f w0 %.3f side "
            "%.4f reacts %d before %.4f %.4f pace %.3f\n",
            t, f, static_cast<int>(foot.early), memory.time, planned.stands ? memory.time - planned.begin : memory.time - planned.end,
            dot(e, ahead), dot(e, left), foot.shift[0] * ahead.x + foot.shift[1] * ahead.y, foot.shift[0] * left.x + foot.shift[1] * left.y,
            foot.place[0] * ahead.x + foot.place[1] * ahead.y, v.z, model.want.velocity.z, dot(v, ahead), dot(model.want.velocity, ahead),
            dot(sole - centre, ahead), dot(sole_ref - model.want.centre, ahead), sole.z, foot.to[2], other.to[2], memory.lower, bearing,
            low, high, memory.rate, centre.z - memory.z, dot(Vec3{memory.tilt[0], memory.tilt[1], 0}, ahead), model.w0,
            dot(sole - centre, left), static_cast<int>(reacted_[f]), dot(before_, ahead), dot(before_, left), memory.pace);
      }
      reacted_[f] = memory.feet[f].reacts != 0;
      stood_[f] = on;
    }
    before_ = e;
  }

 private:
  bool stood_[control::BalanceState::max_feet] = {}, reacted_[control::BalanceState::max_feet] = {};
  Vec3 before_;
};

}  // namespace

Outcome run(const MechanismPtr& mechanism, const std::shared_ptr<const control::ReferenceMotion>& reference, const RunSettings& settings) {
  const Mechanism& m = *mechanism;
  State state(m);
  std::vector<double> a(state.v.size()), error(state.v.size());
  reference->sample(0, state.q, state.v, a);
  const Vec3 start{state.q[0], state.q[1], 0};
  reference->sample(reference->end(), state.q, state.v, a);
  const Vec3 direction = normalized(Vec3{state.q[0], state.q[1], 0} - start, {1, 0, 0});
  reference->sample(0, state.q, state.v, a);
  auto place = std::make_unique<Surroundings>(mechanism, settings, start, direction, start);
  control::BalanceControl control(mechanism, reference, settings.control, 0, place->map());
  control::BalanceState memory;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  const std::vector<Pose> fixed(1);
  std::vector<std::span<const Pose>> poses{X};
  if (place->systems.size() > 1) poses.push_back(fixed);
  std::vector<collision::ContactPoint> contacts;
  int chest = 0;
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == "chest") chest = i;
  Outcome out;
  if (settings.trace)
    for (std::size_t f = 0; f < control.feet().size(); ++f) {
      std::printf("foot %s: stands", m.link(control.feet()[f].link).name.c_str());
      for (const control::Stance& s : control.schedule().stances(f)) std::printf(" %.2f-%.2f", s.begin, s.end);
      std::printf("; %zu links, %zu points; turns", control.feet()[f].parts.size(), control.feet()[f].points.size());
      for (const control::Stance& s : control.schedule().turns(f)) std::printf(" %.2f-%.2f", s.begin, s.end);
      std::printf("\n");
    }
  double square = 0, count = 0;
  const double end = std::min(settings.duration, reference->end());
  const auto ticks = static_cast<long>(std::floor(end / settings.dt + 1e-9));
  struct StanceOf {
    bool on = false;
    int age = 0;
    Vec3 slide;
  };
  std::vector<StanceOf> stances(control.feet().size());
  std::vector<Pose> before = X;
  double slips = 0, slip_sum = 0;
  std::vector<double> by_link(X.size());
  double control_time = 0, total_time = 0;
  LandingTrace landings;
  long k = 0;
  for (; k < ticks; ++k) {
    const double t = static_cast<double>(k) * settings.dt;
    if (memory.time >= reference->end()) break;
    const double t0 = processor_time();
    const Vec3 here{state.q[0], state.q[1], 0};
    if (place->systems.size() > 1 && norm(here - place->centre) > 0.5 * terrain_radius) {
      place = std::make_unique<Surroundings>(mechanism, settings, start, direction, here);
      control.set_ground(place->map());
    }
    calc_poses(m, state.q, X);
    place->workspace.forget();
    collision::find_contacts(place->scene, poses, 0.02, place->workspace, contacts);
    const double t1 = processor_time();
    const control::BalanceOutput result = control.step({state.q, state.v, contacts, 0, settings.dt}, memory, state.tau);
    const double t2 = processor_time();
    if (settings.landings) landings.update(t, control, result, memory);
    out.max_iterations = std::max(out.max_iterations, result.iterations);
    out.unsolved += result.solved ? 0 : 1;
    for (Vec6& w : state.external) w = {};
    if (t >= settings.push.time && t < settings.push.time + settings.push.duration) {
      const Vec3 p = X[static_cast<std::size_t>(chest)] * m.link(chest).inertia.centre();
      state.external[static_cast<std::size_t>(chest)] = {cross(p, settings.push.force), settings.push.force};
    }
    contact::StepSystem stepped[2] = {{state.q, state.v, state.tau, state.external, {}, {}}, {}};
    place->guard.forget();
    const contact::StepReport report = place->guard.step(std::span(stepped).first(place->systems.size()), contacts, settings.dt);
    total_time += processor_time() - t0;
    control_time += t2 - t1;
    if (report.status != contact::StepStatus::ok) {
      out.fell = true;
      break;
    }
    for (const collision::ContactPoint& c : contacts) out.penetration_mm = std::max(out.penetration_mm, -1e3 * c.distance);
    difference(m, state.q, control.reference(), error);
    for (int i = 1; i < m.link_count(); ++i) {
      const Link& link = m.link(i);
      double e = 0;
      for (int d = 0; d < link.joint.nv(); ++d)
        e += error[static_cast<std::size_t>(link.v_index + d)] * error[static_cast<std::size_t>(link.v_index + d)];
      if (link.joint.nv() > 0) square += e, count += 1;
      by_link[static_cast<std::size_t>(i)] += e;
    }
    // Net slip of a stance: at each tick the displacement of the foot's lowest point is added.
    for (std::size_t f = 0; f < stances.size(); ++f) {
      const control::Foot& foot = control.feet()[f];
      const LinkPoint* lowest = nullptr;
      double low = 1e9;
      for (const LinkPoint& p : foot.points) {
        const double z = (X[static_cast<std::size_t>(p.link)] * p.location.p).z - p.location.radius;
        if (z < low) low = z, lowest = &p;
      }
      const bool on = low < 5e-4;
      if (on) {
        const Pose& now = X[static_cast<std::size_t>(lowest->link)];
        const Vec3 at = lowest->location.p + transpose_times(now.R, Vec3{0, 0, -lowest->location.radius});
        if (stances[f].on) stances[f].slide += now * at - before[static_cast<std::size_t>(lowest->link)] * at;
        stances[f].age += 1;
      }
      if (stances[f].on && !on && stances[f].age > 25) {
        const double slip = 100 * std::hypot(stances[f].slide.x, stances[f].slide.y);
        slips += 1;
        slip_sum += slip;
        out.slip_worst_cm = std::max(out.slip_worst_cm, slip);
      }
      if (!on) stances[f].age = 0, stances[f].slide = {};
      stances[f].on = on;
    }
    before = X;
    if (settings.trace && k % 25 == 0) {
      std::printf("%6.3f ref %6.3f rate %.1f q (%.3f %.3f %.3f) ref (%.3f %.3f %.3f) dcm %.3f %.3f it %d res %.1e", t, memory.time,
                  memory.rate, state.q[0], state.q[1], state.q[2], control.reference()[0], control.reference()[1], control.reference()[2],
                  result.dcm_error.x, result.dcm_error.y, result.iterations, result.residual);
      std::printf(" limits %d %d ground %.3f lower %.3f", result.limits, result.joint_limits, memory.z, memory.lower);
      for (std::size_t f = 0; f < stances.size(); ++f) {
        const control::Foot& foot = control.feet()[f];
        const Vec3 sole = X[static_cast<std::size_t>(foot.link)] * foot.sole;
        int touching = 0;
        for (const collision::ContactPoint& c : contacts)
          for (const int part : foot.parts) touching += c.distance < 1e-3 && (c.link_a == part || c.link_b == part) ? 1 : 0;
        std::printf(" | %d%s%d z %.3f of %.3f shift %.2f %.2f", static_cast<int>(memory.feet[f].stands),
                    memory.feet[f].early    ? "e"
                    : memory.feet[f].reacts ? "r"
                                            : " ",
                    touching, sole.z, memory.feet[f].to[2], memory.feet[f].shift[0], memory.feet[f].shift[1]);
      }
      std::printf("\n");
    }
    double tilt = std::hypot(error[0], error[1]);
    if (control.reference()[2] - state.q[2] > 0.3 || tilt > 1) {
      out.fell = true;
      break;
    }
  }
  out.travel = std::hypot(state.q[0] - start.x, state.q[1] - start.y);
  out.time = static_cast<double>(k) * settings.dt;
  if (settings.trace)
    for (int i = 1; i < m.link_count(); ++i)
      std::printf("  %-20s %.2f deg\n", m.link(i).label.c_str(),
                  57.3 * std::sqrt(by_link[static_cast<std::size_t>(i)] / static_cast<double>(std::max(1L, k))));
  out.tracking_deg = count > 0 ? std::sqrt(square / count) * 180 / 3.14159265358979 : 0;
  const double n = static_cast<double>(std::max(1L, k));
  out.control_us = 1e6 * control_time / n;
  out.total_us = 1e6 * total_time / n;
  out.slip_mean_cm = slips > 0 ? slip_sum / slips : 0;
  out.hash = 1469598103934665603ull;
  for (const double x : state.q) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &x, sizeof bits);
    out.hash = (out.hash ^ bits) * 1099511628211ull;
  }
  return out;
}

}  // namespace ugoki::bench
