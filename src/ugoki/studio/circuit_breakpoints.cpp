#include "ugoki/studio/circuit_breakpoints.h"

#include <algorithm>
#include <span>
#include <utility>

#include "ugoki/circuit/breakpoint.h"

namespace ugoki::studio {

void CircuitBreakpoints::set(std::vector<std::string> conditions) {
  conditions_ = std::move(conditions);
  reported_.clear();
  install();
}

void CircuitBreakpoints::attach(circuit::Interpreter* circuit) {
  circuit_ = circuit;
  install();
}

void CircuitBreakpoints::install() {
  installed_.clear();
  problems_.clear();
  if (!circuit_) return;
  std::vector<circuit::Breakpoint> all;
  for (const std::string& condition : conditions_) {
    const Result<circuit::Breakpoint> b = circuit::read_breakpoint(condition);
    // Try each breakpoint separately, so that a breakpoint that the circuit refuses does not disable the others.
    const Result<void> fits = b ? circuit_->set_breakpoints(std::span(&*b, 1)) : fail(b.error());
    if (!fits) {
      const Problem& why = fits.error().problems.front();
      problems_.push_back("The breakpoint '" + condition + "' does not fit the circuit and is inactive: " + why.message + " " + why.remedy);
      continue;
    }
    installed_.push_back({condition, *b});
    all.push_back(*b);
  }
  // Cannot fail: the circuit accepted each of these breakpoints separately.
  [[maybe_unused]] const Result<void> done = circuit_->set_breakpoints(all);
}

CircuitBreakpoints::Hit CircuitBreakpoints::hit() const {
  const Installed& p = installed_[static_cast<std::size_t>(circuit_->breakpoint_hit())];
  Hit hit{p.condition, p.breakpoint.pin, p.breakpoint.component, 0, circuit_->ticks() - 1};
  if (const Result<circuit::PinView> view = circuit_->find_output(p.breakpoint.pin);
      view && p.breakpoint.component < view->numbers().size())
    hit.value = view->numbers()[p.breakpoint.component];
  return hit;
}

std::vector<std::string> CircuitBreakpoints::take_problems() {
  std::vector<std::string> fresh;
  for (const std::string& sentence : problems_)
    if (std::ranges::find(reported_, sentence) == reported_.end()) fresh.push_back(sentence);
  reported_ = std::exchange(problems_, {});
  return fresh;
}

}  // namespace ugoki::studio
