// Members of Interpreter for breakpoints and single ticks.

#include <nlohmann/json.hpp>

#include "ugoki/studio/interpreter.h"

namespace ugoki::studio {

using Json = nlohmann::json;

void Interpreter::attach_circuit(circuit::Interpreter* circuit) {
  watch_.attach(circuit);
  breakpoints_.attach(circuit);
  for (const std::string& sentence : breakpoints_.take_problems()) log_warning(sentence);
}

void Interpreter::set_breakpoints(std::vector<std::string> conditions) {
  breakpoints_.set(std::move(conditions));
  for (const std::string& sentence : breakpoints_.take_problems()) log_warning(sentence);
  if (!simulation_ || mode_ != PlayMode::simulate || !playing_ || goal_ != Goal::none || !breakpoints_.active()) return;
  if (const Result<void> r = rewind_to_shown(); !r) log_warning(r.error().text());
  anchor();
}

void Interpreter::log_warning(const std::string& warning) {
  const Json event{{"event", "log"}, {"level", "warning"}, {"text", warning}};
  sink_.message(event.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Moves the head (the end of the recording) back to the shown time, so that later steps are recomputed with the recorded inputs.
Result<void> Interpreter::rewind_to_shown() {
  if (shown_ >= head_time() - 0.5 * simulation_->step_size()) return {};
  const std::int64_t step = step_at(shown_), head = simulation_->step_count();
  const std::vector<LiveInput> inputs = recording_->inputs();
  if (Result<void> r = truncate(step); !r) return r;
  for (const LiveInput& input : inputs)
    if (input.step >= step) recording_->add_input(input);
  replay_until_ = head;
  return {};
}

Result<void> Interpreter::step_tick() {
  if (Result<void> r = require_content(); !r) return r;
  if (mode_ != PlayMode::simulate)
    return fail(ErrorCode::structure, "mode", "Single ticks are available in Simulate mode only.", "Switch to Simulate mode.");
  if (goal_ == Goal::seek) shown_ = head_time();
  goal_ = Goal::none;
  playing_ = false;
  status_ = "paused";
  if (shown_ >= simulation_->duration() - 0.5 * simulation_->step_size())
    return fail(ErrorCode::range, "ticks", "The shown time is the end of the content.",
                "Seek to an earlier time, or make the content longer.");
  if (Result<void> r = rewind_to_shown(); !r) return r;
  if (blown_up_)
    return fail(ErrorCode::structure, "transport", "The simulation cannot continue from the shown time.",
                "Restart the simulation, or change the content.");
  apply_due_inputs();
  if (simulation_->step_count() >= replay_until_)
    if (Result<void> r = record_held_devices(); !r) return r;
  const bool good = advance_head();
  show_head();
  anchor();
  summary_due_ = true;
  if (good) report_transport();
  if (good && breakpoints_.met()) report_breakpoint();
  return {};
}

void Interpreter::report_breakpoint() {
  const CircuitBreakpoints::Hit hit = breakpoints_.hit();
  const Json event{{"event", "breakpoint"}, {"condition", hit.condition},
                   {"pin", hit.pin},        {"component", hit.component},
                   {"value", hit.value},    {"time", shown_},
                   {"tick", hit.tick}};
  sink_.message(event.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace ugoki::studio
