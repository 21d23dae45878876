#include "ugoki/studio/circuit_breakpoints.h"

#include <algorithm>
#include <span>
#include <utility>

#include "ugoki/circuit/breakpoint.h"

namespace ugoki::studio {

void CircuitBreakpoints::set(std::vector<std::string> conditions) {
  conditions_ = std::move(conditions);
  told_.clear();
  place();
}

void CircuitBreakpoints::attach(circuit::Interpreter* circuit) {
  circuit_ = circuit;
  place();
}

void CircuitBreakpoints::place() {
  placed_.clear();
  problems_.clear();
  if (!circuit_) return;
  std::vector<circuit::Breakpoint> all;
  for (const std::string& condition : conditions_) {
    const Result<circuit::Breakpoint> b = circuit::read_breakpoint(condition);
    // Each by itself: one that the circuit refuses leaves the others.
    const Result<void> fits = b ? circuit_->set_breakpoints(std::span(&*b, 1)) : fail(b.error());
    if (!fits) {
      const Problem& why = fits.error().problems.front();
      problems_.push_back("The breakpoint '" + condition + "' waits: " + why.message + " " + why.remedy);
      continue;
    }
    placed_.push_back({condition, *b});
    all.push_back(*b);
  }
  // Those that fitted by themselves fit together.
  [[maybe_unused]] const Result<void> done = circuit_->set_breakpoints(all);
}

CircuitBreakpoints::Hit CircuitBreakpoints::hit() const {
  const Placed& p = placed_[static_cast<std::size_t>(circuit_->breakpoint_hit())];
  Hit hit{p.condition, p.what.pin, p.what.component, 0, circuit_->ticks() - 1};
  if (const Result<circuit::PinView> view = circuit_->find_output(p.what.pin); view && p.what.component < view->numbers().size())
    hit.value = view->numbers()[p.what.component];
  return hit;
}

std::vector<std::string> CircuitBreakpoints::take_problems() {
  std::vector<std::string> fresh;
  for (const std::string& sentence : problems_)
    if (std::ranges::find(told_, sentence) == told_.end()) fresh.push_back(sentence);
  told_ = std::exchange(problems_, {});
  return fresh;
}

}  // namespace ugoki::studio
