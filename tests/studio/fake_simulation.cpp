#include "fake_simulation.h"

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "ugoki/content/display_frame.h"
#include "ugoki/content/executable.h"

namespace ugoki::studio::test {
namespace {

class FakeSimulation final : public Simulation {
 public:
  explicit FakeSimulation(const nlohmann::json& j) {
    step_ = j.value("step", 0.002);
    duration_ = j.value("duration", 4.0);
    rate_ = j.value("rate", 60.0);
    constexpr double never = std::numeric_limits<double>::infinity();
    blow_up_ = j.value("blow_up", never);
    crash_ = j.value("crash", never);
    hang_ = j.value("hang", never);
    unsolved_ = j.value("unsolved", never);
    split_ = j.value("split", never);
    wind_ = j.value("wind", 1.0);
    start_ = j.value("start", 0.0);
    for (const auto& c : j.value("cast", nlohmann::json::array())) cast_.push_back({c.value("id", "a"), c.value("links", 1)});
    s_.x.resize(cast_.size());
    s_.v.resize(cast_.size());
    s_.push.resize(cast_.size());
    s_.push_end.resize(cast_.size(), -1);
  }

  double step_size() const override { return step_; }
  double duration() const override { return duration_; }
  double frame_rate() const override { return rate_; }
  const std::vector<CastMember>& cast() const override { return cast_; }
  int find_link(int character, std::string_view name) const override {
    return name == "chest" && cast_[static_cast<std::size_t>(character)].links > 1 ? 1 : -1;
  }
  std::int64_t step_count() const override { return s_.step; }
  content::PlayerStepQuality step_quality() const override {
    const double time = static_cast<double>(s_.step) * step_;
    const bool unsolved = time > unsolved_, split = time > split_;
    return {unsolved ? 2u : 0u, split ? 1u : 0u, split ? 4u : 1u, unsolved ? 1u : 0u};
  }

  Result<void> step() override {
    const double time = static_cast<double>(s_.step) * step_;
    if (time >= crash_) std::abort();
    while (time >= hang_) ::usleep(1000);
    if (time >= blow_up_)
      return fail(ErrorCode::range, "body a, joint hip, 1.000 s", "The velocity is not finite.", "Take a smaller step.");
    for (std::size_t c = 0; c < cast_.size(); ++c) {
      double force = wind_ * std::sqrt(1 + s_.x[c] * s_.x[c]);
      if (static_cast<double>(s_.step) < s_.push_end[c]) force += s_.push[c];
      if (s_.grabbed == static_cast<double>(c)) force += 50 * (s_.target - s_.x[c]);
      s_.v[c] += force * step_;
      s_.x[c] += s_.v[c] * step_;
    }
    ++s_.step;
    return {};
  }

  void save(std::vector<std::byte>& out) override {
    std::vector<double> all = {static_cast<double>(s_.step), s_.grabbed, s_.target};
    for (const auto* part : {&s_.x, &s_.v, &s_.push, &s_.push_end}) all.insert(all.end(), part->begin(), part->end());
    out.resize(all.size() * sizeof(double));
    std::memcpy(out.data(), all.data(), out.size());
  }
  Result<void> restore(std::span<const std::byte> state) override {
    std::vector<double> all(state.size() / sizeof(double));
    std::memcpy(all.data(), state.data(), state.size());
    s_.step = static_cast<std::int64_t>(all[0]);
    s_.grabbed = all[1];
    s_.target = all[2];
    std::size_t at = 3;
    for (auto* part : {&s_.x, &s_.v, &s_.push, &s_.push_end}) {
      for (double& value : *part) value = all[at++];
    }
    return {};
  }

  void push(int character, int, const Vec3& force, double duration) override {
    s_.push[static_cast<std::size_t>(character)] = force.x;
    s_.push_end[static_cast<std::size_t>(character)] = static_cast<double>(s_.step) + duration / step_;
  }
  void grab(int character, int, const Vec3&, const Vec3& target) override {
    s_.grabbed = character;
    s_.target = target.x;
  }
  void drag(const Vec3& target) override { s_.target = target.x; }
  void release() override { s_.grabbed = -1; }

  void encode_frame(std::vector<std::byte>& out) override { encode(out, s_.x, content::CharacterState::tracking); }
  void encode_pose(double time, std::vector<std::byte>& out) override {
    encode(out, std::vector<double>(cast_.size(), time * 10 + start_), content::CharacterState::edit);
  }

  CharacterSummary summary(int character) override {
    CharacterSummary summary;
    summary.foot_skate_cm = s_.x[static_cast<std::size_t>(character)];
    summary.fell = summary.foot_skate_cm > 1000;
    return summary;
  }
  MomentMeasures moment(int character) override {
    const auto x = static_cast<float>(s_.x[static_cast<std::size_t>(character)]);
    MomentMeasures out;
    out.fill(-1);
    using enum naturalness::MeasureId;
    out[naturalness::index_of(tracking)] = x;
    out[naturalness::index_of(assist)] = 2 * x;
    out[naturalness::index_of(slip)] = static_cast<float>(s_.step);
    out[naturalness::index_of(penetration)] = 0.25f;
    out[naturalness::index_of(fall)] = s_.step >= 500 ? 1 : 0;
    return out;
  }
  RunMeasures run_measures(int) override {
    RunMeasures out;
    out.fill(naturalness::value_of(naturalness::Reason::no_walk));
    out[naturalness::index_of(naturalness::MeasureId::slip)] = 2.5;
    return out;
  }
  std::uint8_t feet_on_ground(int) override {
    return static_cast<std::uint8_t>(s_.step / 250 % 2 == 0 ? 2 : 1);
  }  // the standing foot changes every 250 steps

 private:
  struct State {
    std::int64_t step = 0;
    double grabbed = -1, target = 0;
    std::vector<double> x, v, push, push_end;
  };

  void encode(std::vector<std::byte>& out, const std::vector<double>& x, content::CharacterState state) {
    content::DisplayFrame frame;
    if (s_.grabbed >= 0) {
      frame.grabbed = true;
      frame.grab_point = {s_.x[static_cast<std::size_t>(s_.grabbed)], 0, 1};
      frame.grab_target = {s_.target, 0, 1};
    }
    for (std::size_t c = 0; c < cast_.size(); ++c) {
      content::DisplayCharacter& character = frame.characters.emplace_back();
      character.state = state;
      character.assist_force = {1, 2, 3};
      character.assist_moment = {4, 5, 6};
      character.assist_ratio = 0.25;
      character.weight = 700;
      character.centre_of_mass = {x[c], 0, 1};
      for (int l = 0; l < cast_[c].links; ++l) character.links.push_back({{x[c], static_cast<double>(l), 1}, axis_angle({0, 0, 1}, 0.5)});
    }
    if (!cast_.empty()) frame.contacts.push_back({{1, 2, 3}, {0, 0, 700}, {0, 0, 1}, 0, 0});
    content::encode_frame(frame, 0, 0, out);
  }

  double step_ = 0, duration_ = 0, rate_ = 0, blow_up_ = 0, crash_ = 0, hang_ = 0, wind_ = 0, start_ = 0, unsolved_ = 0, split_ = 0;
  std::vector<CastMember> cast_;
  State s_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  T take() {
    T value{};
    if (at_ + sizeof(T) > bytes_.size()) {
      bad_ = true;
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  template <std::size_t n>
  void take(float (&out)[n]) {
    for (float& f : out) f = take<float>();
  }
  [[nodiscard]] bool at_end() const { return !bad_ && at_ == bytes_.size(); }
  [[nodiscard]] bool bad() const { return bad_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool bad_ = false;
};

/// Settings of the fake simulation for real executable data: step, duration, rate and cast are taken from the data, the others from the
/// scenario's name if it is a JSON object.
nlohmann::json settings_of(const content::Executable& executable) {
  nlohmann::json j = nlohmann::json::parse(executable.name, nullptr, false);
  if (!j.is_object()) j = nlohmann::json::object();
  j["step"] = executable.step;
  j["duration"] = executable.duration;
  j["rate"] = executable.frame_rate;
  j["cast"] = nlohmann::json::array();
  for (const content::ExecutableCharacter& c : executable.characters) {
    j["cast"].push_back({{"id", c.id}, {"links", executable.mechanisms[static_cast<std::size_t>(c.mechanism)]->link_count()}});
    if (!c.track.empty() && !j.contains("start")) j["start"] = c.track[0].clip.start;
  }
  return j;
}

}  // namespace

Result<std::unique_ptr<Simulation>> open_fake_simulation(std::span<const std::byte> executable) {
  if (Result<content::Executable> real = content::read_executable(executable, "content.ugx")) {
    return std::unique_ptr<Simulation>(std::make_unique<FakeSimulation>(settings_of(*real)));
  }
  const auto j = nlohmann::json::parse(reinterpret_cast<const char*>(executable.data()),
                                       reinterpret_cast<const char*>(executable.data()) + executable.size(), nullptr, false);
  if (!j.is_object()) return fail(ErrorCode::syntax, "content.ugx", "This is not executable data.", "Generate it again.");
  return std::unique_ptr<Simulation>(std::make_unique<FakeSimulation>(j));
}

Frame parse_frame(std::span<const std::byte> bytes) {
  Frame f;
  Reader r(bytes);
  if (r.take<std::uint32_t>() != 0x46474b55 || r.take<std::uint32_t>() != 1) return f;
  f.time = r.take<double>();
  f.number = r.take<std::uint32_t>();
  f.flags = r.take<std::uint32_t>();
  const auto characters = r.take<std::uint32_t>(), contacts = r.take<std::uint32_t>();
  r.take(f.grab);
  const auto pairs = r.take<std::uint32_t>();
  const bool normals = r.take<std::uint32_t>() == 1;
  for (std::uint32_t c = 0; c < characters && !r.bad(); ++c) {
    Frame::Character& ch = f.characters.emplace_back();
    const auto links = r.take<std::uint32_t>();
    ch.state = r.take<std::uint32_t>();
    r.take(ch.assist_force);
    r.take(ch.assist_moment);
    ch.assist_over_cap = r.take<float>();
    ch.weight = r.take<float>();
    r.take(ch.centre);
    r.take<float>();
    for (std::uint32_t l = 0; l < links && !r.bad(); ++l) {
      std::array<float, 7>& link = ch.links.emplace_back();
      for (float& value : link) value = r.take<float>();
    }
  }
  for (std::uint32_t k = 0; k < contacts && !r.bad(); ++k) {
    Frame::Contact& contact = f.contacts.emplace_back();
    r.take(contact.point);
    r.take(contact.force);
    contact.character = r.take<std::uint32_t>();
    contact.link = r.take<std::uint32_t>();
  }
  for (std::uint32_t k = 0; normals && k < 3 * contacts && !r.bad(); ++k) r.take<float>();
  for (std::uint32_t k = 0; k < 8 * pairs && !r.bad(); ++k) r.take<float>();
  f.good = r.at_end();
  return f;
}

}  // namespace ugoki::studio::test
