// Members of Interpreter for live inputs of a user while the simulation runs (pull, push, keyboard, mouse and gamepads). Each input is
// recorded with its step and applied again at this step when the recording is recomputed.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/studio/interpreter.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

bool finite(const Vec3& v) { return is_finite(v) && norm(v) < 1e9; }

}  // namespace

Result<LiveInput> Interpreter::link_input(std::string_view character, std::string_view link) const {
  if (Result<void> r = require_content(); !r) return fail(std::move(r.error()));
  if (mode_ != PlayMode::simulate) {
    return fail(ErrorCode::structure, "mode", "Bodies can be pulled and pushed in Simulate mode only.", "Switch to Simulate mode.");
  }
  const std::vector<CastMember>& cast = simulation_->cast();
  const auto found = std::ranges::find(cast, character, &CastMember::id);
  if (found == cast.end()) {
    return fail(ErrorCode::unknown, "character", "There is no character \"" + std::string(character) + "\".",
                "Give the id of one of the scenario's characters.");
  }
  LiveInput input;
  input.character = static_cast<int>(found - cast.begin());
  const std::optional<long> index = parse_long(link);
  input.link =
      index ? (*index >= 0 && *index < found->links ? static_cast<int>(*index) : -1) : simulation_->find_link(input.character, link);
  if (input.link < 0) {
    return fail(ErrorCode::unknown, "link", "\"" + std::string(character) + "\" has no link \"" + std::string(link) + "\".",
                "Give a link's index, name or label.");
  }
  return input;
}

Result<void> Interpreter::grab(std::string_view character, std::string_view link, const Vec3& point, const Vec3& target) {
  Result<LiveInput> input = link_input(character, link);
  if (!input) return fail(std::move(input.error()));
  if (!finite(point) || !finite(target))
    return fail(ErrorCode::range, "target", "Points must be finite and closer than 1e9 m to the origin.", "Give metres.");
  input->type = LiveInput::Type::grab;
  input->a = point;
  input->b = target;
  return live_input(*input);
}

Result<void> Interpreter::push(std::string_view character, std::string_view link, const Vec3& force, double duration) {
  Result<LiveInput> input = link_input(character, link);
  if (!input) return fail(std::move(input.error()));
  if (!is_finite(force) || norm(force) > 1e5)
    return fail(ErrorCode::range, "force", "A push has at most 100 000 N.", "Give the force in newton.");
  if (!(duration > 0 && duration <= 10))
    return fail(ErrorCode::range, "duration", "A push lasts more than 0 and at most 10 s.", "Give the duration in seconds.");
  input->type = LiveInput::Type::push;
  input->a = force;
  input->duration = duration;
  return live_input(*input);
}

Result<void> Interpreter::drag(const Vec3& target) {
  if (Result<void> r = require_content(); !r) return r;
  if (!finite(target))
    return fail(ErrorCode::range, "target", "Points must be finite and closer than 1e9 m to the origin.", "Give metres.");
  const std::vector<LiveInput>& inputs = recording_->inputs();
  const auto last = std::find_if(inputs.rbegin(), inputs.rend(), [](const LiveInput& i) { return i.type != LiveInput::Type::hold; });
  if (mode_ != PlayMode::simulate || last == inputs.rend() || last->type == LiveInput::Type::release)
    return {};  // the drag message came too late: the grab has already been released
  LiveInput input;
  input.type = LiveInput::Type::drag;
  input.a = target;
  return live_input(input);
}

Result<void> Interpreter::release() {
  if (Result<void> r = require_content(); !r) return r;
  if (mode_ != PlayMode::simulate) return {};
  const std::vector<std::size_t> pull = pull_inputs(std::nullopt);
  LiveInput input;
  input.type = LiveInput::Type::release;
  if (Result<void> r = live_input(input); !r || pull.empty()) return r;
  report_pull(pull);
  return {};
}

/// Indices of the recorded inputs of one pull, from its grab to its release. @param step of the grab; none: the pull that lasts
std::vector<std::size_t> Interpreter::pull_inputs(std::optional<std::int64_t> step) const {
  std::vector<std::size_t> found;
  const std::vector<LiveInput>& inputs = recording_->inputs();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const LiveInput& input = inputs[i];
    if (input.type == LiveInput::Type::grab) {
      if (step && !found.empty()) return found;
      found.clear();
      if (!step || input.step == *step) found.push_back(i);
    } else if (input.type == LiveInput::Type::drag && !found.empty()) {
      found.push_back(i);
    } else if (input.type == LiveInput::Type::release && !found.empty()) {
      if (step) {
        found.push_back(i);
        return found;
      }
      found.clear();
    }
  }
  return found;
}

/// Sends the pull that has just ended, in the form of an event of the scenario.
void Interpreter::report_pull(const std::vector<std::size_t>& indices) {
  const std::vector<LiveInput>& inputs = recording_->inputs();
  const LiveInput& grab = inputs[indices.front()];
  const std::int64_t end = simulation_->step_count();
  if (end <= grab.step) return;  // a click
  Json path = Json::array();
  for (const std::size_t i : indices) {
    const LiveInput& input = inputs[i];
    if (input.step >= end) continue;
    const Vec3& target = input.type == LiveInput::Type::grab ? input.b : input.a;
    Json entry = {time_of(input.step - grab.step), target.x, target.y, target.z};
    if (!path.empty() && path.back()[0] == entry[0])
      path.back() = std::move(entry);  // of several positions before the same step, the last one acts
    else
      path.push_back(std::move(entry));
  }
  sink_.message(Json{{"event", "pulled"},
                     {"character", simulation_->cast()[static_cast<std::size_t>(grab.character)].id},
                     {"link", grab.link},
                     {"point", {grab.a.x, grab.a.y, grab.a.z}},
                     {"time", time_of(grab.step)},
                     {"duration", time_of(end - grab.step)},
                     {"path", std::move(path)}}
                    .dump());
}

Result<void> Interpreter::forget_pull(double time) {
  if (Result<void> r = require_content(); !r) return r;
  const std::vector<std::size_t> indices = pull_inputs(step_at(time));
  if (indices.empty())
    return fail(ErrorCode::unknown, "time", "No pull of the recorded simulation begins at this time.",
                "Give the time of the event `pulled`.");
  const auto applied = static_cast<std::size_t>(std::ranges::count_if(indices, [&](std::size_t i) { return i < next_input_; }));
  recording_->remove_inputs(indices);
  next_input_ -= applied;
  return {};
}

Result<void> Interpreter::input(const circuit::DeviceChange& change) {
  const circuit::DeviceState before = held_;
  circuit::apply(change, held_);
  const bool acts_now = simulation_ && simulation_->devices() && mode_ == PlayMode::simulate && playing_ && goal_ != Goal::seek;
  if (acts_now && simulation_->devices()->presses(before, held_)) replay_until_ = 0;   // the user's input replaces the recorded inputs
  if (!acts_now || shown_ >= head_time() - 0.5 * simulation_->step_size()) return {};  // the next computed step reads held_
  if (!simulation_->devices()->presses(before, held_)) return {};
  if (Result<void> r = truncate(step_at(shown_)); !r) return r;
  anchor();
  return record_held_devices();
}

/// Records the current device state as a live input if it differs from the state that the circuit has.
Result<void> Interpreter::record_held_devices() {
  if (!simulation_->devices() || simulation_->devices()->has(held_)) return {};
  LiveInput input;
  input.type = LiveInput::Type::hold;
  input.held = std::make_shared<const circuit::DeviceState>(held_);
  return live_input(std::move(input));
}

Result<void> Interpreter::live_input(LiveInput input) {
  if (goal_ == Goal::seek) {  // the input ends the seek; it acts at the head (end of the recording), not at the requested time
    goal_ = Goal::none;
    shown_ = head_time();
    anchor();
  }
  if (shown_ < head_time() - 0.5 * simulation_->step_size()) {
    if (Result<void> r = truncate(step_at(shown_)); !r) return r;
    anchor();
  }
  recording_->truncate(simulation_->step_count() + 1);  // drops recorded inputs after the head, not yet replayed
  replay_until_ = 0;
  apply_due_inputs();
  input.step = simulation_->step_count();
  recording_->add_input(input);
  next_input_ = recording_->inputs().size();
  apply(input);
  if (!playing_) show_head();
  return {};
}

void Interpreter::apply(const LiveInput& input) {
  switch (input.type) {
    case LiveInput::Type::push: simulation_->push(input.character, input.link, input.a, input.duration); break;
    case LiveInput::Type::grab: simulation_->grab(input.character, input.link, input.a, input.b); break;
    case LiveInput::Type::drag: simulation_->drag(input.a); break;
    case LiveInput::Type::release: simulation_->release(); break;
    case LiveInput::Type::hold: simulation_->hold(*input.held); break;
  }
}

void Interpreter::apply_due_inputs() {
  const std::vector<LiveInput>& inputs = recording_->inputs();
  for (; next_input_ < inputs.size() && inputs[next_input_].step <= simulation_->step_count(); ++next_input_) apply(inputs[next_input_]);
}

}  // namespace ugoki::studio
