// Breakpoints and single ticks: where a run stops, and how it goes on from there.

#include <nlohmann/json.hpp>

#include "ugoki/studio/interpreter.h"

namespace ugoki::studio {

using Json = nlohmann::json;

void Interpreter::look_at(circuit::Interpreter* circuit) {
  watch_.attach(circuit);
  breakpoints_.attach(circuit);
  for (const std::string& sentence : breakpoints_.take_problems()) tell(sentence);
}

void Interpreter::set_breakpoints(std::vector<std::string> conditions) {
  breakpoints_.set(std::move(conditions));
  for (const std::string& sentence : breakpoints_.take_problems()) tell(sentence);
  if (!simulation_ || mode_ != PlayMode::simulate || !playing_ || goal_ != Goal::none || !breakpoints_.active()) return;
  if (const Result<void> r = compute_again(); !r) tell(r.error().text());
  anchor();
}

void Interpreter::tell(const std::string& warning) {
  const Json event{{"event", "log"}, {"level", "warning"}, {"text", warning}};
  sink_.message(event.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// Puts the head at what is shown, so that its steps are computed again, with the same inputs.
Result<void> Interpreter::compute_again() {
  if (shown_ >= head_time() - 0.5 * simulation_->step_size()) return {};
  const std::int64_t step = step_at(shown_), head = simulation_->step_count();
  const std::vector<LiveInput> inputs = recording_->inputs();
  if (Result<void> r = truncate(step); !r) return r;
  for (const LiveInput& input : inputs)
    if (input.step >= step) recording_->add_input(input);
  again_until_ = head;
  return {};
}

Result<void> Interpreter::step_tick() {
  if (Result<void> r = require_content(); !r) return r;
  if (mode_ != PlayMode::simulate)
    return fail(ErrorCode::structure, "mode", "Single ticks are computed in Simulate only.", "Switch to Simulate.");
  if (goal_ == Goal::seek) shown_ = head_time();
  goal_ = Goal::none;
  playing_ = false;
  status_ = "paused";
  if (shown_ >= simulation_->duration() - 0.5 * simulation_->step_size())
    return fail(ErrorCode::range, "ticks", "The content ends here.", "Go back, or make it longer.");
  if (Result<void> r = compute_again(); !r) return r;
  if (blown_up_)
    return fail(ErrorCode::structure, "transport", "The simulation cannot go on from here.", "Restart it, or change the content.");
  apply_due_inputs();
  if (simulation_->step_count() >= again_until_)
    if (Result<void> r = hold(); !r) return r;
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
