#include "ugoki/studio/player_simulation.h"

#include <algorithm>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/content/player.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/shelf.h"

namespace ugoki::studio {
namespace {

class PlayerSimulation final : public Simulation {
 public:
  explicit PlayerSimulation(content::Player player) : player_(std::move(player)) {
    for (const content::ExecutableCharacter& c : player_.content().characters) {
      cast_.push_back({c.id, player_.content().mechanisms[static_cast<std::size_t>(c.mechanism)]->link_count()});
    }
  }

  double step_size() const override { return player_.step_size(); }
  double duration() const override { return player_.content().duration; }
  double frame_rate() const override { return player_.content().frame_rate; }
  const std::vector<CastMember>& cast() const override { return cast_; }
  int find_link(int character, std::string_view name) const override { return player_.find_link(character, name); }

  std::int64_t step_count() const override { return static_cast<std::int64_t>(player_.step_count()); }
  std::uint64_t state_hash() const override { return player_.state_hash(); }
  Result<void> step() override {
    pending_input_ = PendingInput::none;
    return player_.step();
  }
  void save(std::vector<std::byte>& out) override { player_.save(out); }
  Result<void> restore(std::span<const std::byte> state) override {
    pending_input_ = PendingInput::none;
    return player_.restore(state);
  }

  void push(int character, int link, const Vec3& force, double duration) override { player_.push(character, link, force, duration); }
  void grab(int character, int link, const Vec3& point, const Vec3& target) override {
    player_.grab(character, link, point, target);
    pending_input_ = PendingInput::grab;
    grab_character_ = static_cast<std::size_t>(character);
    grab_link_ = static_cast<std::size_t>(link);
    grab_point_ = point;
    grab_target_ = target;
  }
  void drag(const Vec3& target) override {
    player_.drag(target);
    if (pending_input_ == PendingInput::none) pending_input_ = PendingInput::drag;
    grab_target_ = target;
  }
  void release() override {
    player_.release();
    pending_input_ = PendingInput::release;
  }
  void hold(const circuit::DeviceState& state) override { player_.hold(state); }
  const circuit::DeviceFeed* devices() const override { return &player_.devices(); }

  void reset() override {
    pending_input_ = PendingInput::none;
    player_.reset();
  }
  Result<std::vector<std::string>> change_library() override {
    Result<circuit::Interpreter::Adoption> report = player_.change_library(lsi_library().library());
    if (!report) return fail(std::move(report.error()));
    pending_input_ = PendingInput::none;
    std::vector<std::string> sentences = std::move(report->partly);
    sentences.insert(sentences.end(), report->afresh.begin(), report->afresh.end());
    return sentences;
  }
  circuit::Interpreter* circuit() override { return &player_.interpreter(); }

  std::vector<MechanismPtr> mechanisms() const override { return player_.world().mechanisms(); }
  content::PlayerStepQuality step_quality() const override { return player_.step_quality(); }
  std::vector<std::string> touches() override {
    std::vector<std::string> sentences;
    player_.touches(touches_);
    for (const content::PlayerTouch& t : touches_) {
      if (t.omitted > 0) sentences.push_back(to_fixed(t.time, 2) + " s: " + t.words);
      if (!t.ended || t.omitted > 0) continue;
      const std::vector<int>& feet = player_.world().characters()[static_cast<std::size_t>(t.character_a)].feet;
      const bool step = t.character_b < 0 && std::ranges::find(feet, t.link_a) != feet.end();
      if (step) continue;
      sentences.push_back(to_fixed(t.time - t.duration, 2) + " s: " + name_of(t.character_a, t.link_a) + " touched " +
                          name_of(t.character_b, t.link_b) + ", " + to_fixed(norm(t.impulse), norm(t.impulse) < 10 ? 2 : 1) + " N s in " +
                          to_fixed(t.duration, 2) + " s");
    }
    return sentences;
  }

  void encode_frame(std::vector<std::byte>& out) override {
    player_.display_frame(frame_);
    show_pending_input();
    content::encode_frame(frame_, 0, 0, out);
  }
  void encode_pose(double time, std::vector<std::byte>& out) override {
    player_.pose_at(time, frame_);
    content::encode_frame(frame_, 0, 0, out);
  }

  CharacterSummary summary(int character) override {
    const content::PlayerMeasures m = player_.measures(character);
    return {m.assist_rms_bw, m.foot_skate_cm, m.tracking_rms_deg, m.penetration_mm, m.fell};
  }
  MomentMeasures moment(int character) override {
    const content::PlayerMeasures m = player_.measures(character);
    MomentMeasures out{};
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = static_cast<float>(m.now[k]);
    return out;
  }
  RunMeasures run_measures(int character) override { return player_.measures(character).totals; }
  std::uint8_t feet_on_ground(int character) override {
    const int feet = player_.measures(character).feet_on_ground;
    return feet < 0 ? 255 : static_cast<std::uint8_t>(feet);
  }

 private:
  /// Name of a link, body or the ground in messages: "left hand of Human", "Ball", "the ground".
  [[nodiscard]] std::string name_of(int character, int link) const {
    if (character < 0) return "the ground";
    const content::ExecutableCharacter& c = player_.content().characters[static_cast<std::size_t>(character)];
    const Mechanism& m = *player_.content().mechanisms[static_cast<std::size_t>(c.mechanism)];
    if (m.link_count() == 1 || link < 0 || link >= m.link_count()) return c.name;
    const Link& l = m.link(link);
    return (l.label.empty() ? l.name : l.label) + " of " + c.name;
  }

  /// The user's input since the last step. The player applies it in the next step; frames show it immediately.
  enum class PendingInput { none, grab, drag, release };

  void show_pending_input() {
    if (pending_input_ == PendingInput::release) frame_.grabbed = false;
    if (pending_input_ == PendingInput::drag && frame_.grabbed) frame_.grab_target = grab_target_;
    if (pending_input_ != PendingInput::grab) return;
    const content::DisplayPose& link = frame_.characters[grab_character_].links[grab_link_];
    frame_.grabbed = true;
    frame_.grab_point = link.p + rotate(link.r, grab_point_);
    frame_.grab_target = grab_target_;
  }

  content::Player player_;
  std::vector<CastMember> cast_;
  content::DisplayFrame frame_;
  std::vector<content::PlayerTouch> touches_;
  PendingInput pending_input_ = PendingInput::none;
  std::size_t grab_character_ = 0, grab_link_ = 0;
  Vec3 grab_point_, grab_target_;
};

}  // namespace

plugin::LiveLibrary& lsi_library() {
  static plugin::LiveLibrary library(lsi::standard_library(), plugin::default_shelf());
  return library;
}

Result<std::unique_ptr<Simulation>> open_player(std::span<const std::byte> executable) {
  Result<content::Player> player =
      content::Player::open(executable, "content", {.library = lsi_library().library(), .activity = &plugin::process_activity()});
  if (!player) return fail(std::move(player.error()));
  return std::unique_ptr<Simulation>(std::make_unique<PlayerSimulation>(std::move(*player)));
}

}  // namespace ugoki::studio
