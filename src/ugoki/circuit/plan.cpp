#include "ugoki/circuit/plan.h"

#include <algorithm>
#include <queue>

namespace ugoki::circuit {
namespace {

const FlatLsi& at(const FlatCircuit& flat, int i) { return flat.lsis[static_cast<std::size_t>(i)]; }
const OutputPin& output_of(const FlatCircuit& flat, const Source& s) {
  return at(flat, s.lsi).lsi_class->outputs[static_cast<std::size_t>(s.pin)];
}

/// Location for messages: "circuit/lsis/3 'arm'".
std::string location_of(const FlatLsi& lsi) { return lsi.location + " '" + lsi.id + "'"; }

/// Calls visit(lsi, pin, source) for every wire: indices of the consuming LSI and its input, and the output that feeds it.
template <class Visit>
void each_wire(const FlatCircuit& flat, Visit visit) {
  for (std::size_t i = 0; i < flat.lsis.size(); ++i)
    for (std::size_t pin = 0; pin < flat.lsis[i].inputs.size(); ++pin)
      for (const Source& s : flat.lsis[i].inputs[pin].sources) visit(static_cast<int>(i), static_cast<int>(pin), s);
}

void resolve_sizes(const FlatCircuit& flat, std::vector<Setup>& setups, Error& problems) {
  const std::size_t n = flat.lsis.size();
  std::vector<std::vector<int>> consumers(n);
  each_wire(flat, [&](int lsi, int, const Source& s) { consumers[static_cast<std::size_t>(s.lsi)].push_back(lsi); });
  std::vector<char> waiting(n, 1);
  std::vector<int> visits(n, 0);
  std::queue<int> work;
  for (std::size_t i = 0; i < n; ++i) work.push(static_cast<int>(i));
  while (!work.empty()) {
    const auto i = static_cast<std::size_t>(work.front());
    work.pop();
    waiting[i] = 0;
    const FlatLsi& lsi = flat.lsis[i];
    Setup& setup = setups[i];
    for (std::size_t pin = 0; pin < lsi.inputs.size(); ++pin) {
      std::vector<Shape> shapes;
      for (const Source& s : lsi.inputs[pin].sources)
        shapes.push_back(setups[static_cast<std::size_t>(s.lsi)].outputs()[static_cast<std::size_t>(s.pin)]);
      setup.set_in(pin, std::move(shapes));
    }
    const std::vector<Shape> before = setup.outputs();
    setup.follow_inputs();
    if (lsi.lsi_class->configure) lsi.lsi_class->configure(setup);
    if (setup.outputs() == before) continue;
    if (++visits[i] > 64) {  // a size usually changes once or twice; in a cycle of wires it could change without end
      problems.add(ErrorCode::structure, location_of(lsi),
                   "The output sizes of '" + lsi.id + "' depend on themselves through a cycle of wires.",
                   "Insert a delay whose parameter 'count' is set into this cycle.");
      return;
    }
    for (const int c : consumers[i]) {
      if (waiting[static_cast<std::size_t>(c)]) continue;
      waiting[static_cast<std::size_t>(c)] = 1;
      work.push(c);
    }
  }
}

void check_sizes(const FlatCircuit& flat, const std::vector<Setup>& setups, Error& problems) {
  for (std::size_t i = 0; i < flat.lsis.size(); ++i) {
    const FlatLsi& lsi = flat.lsis[i];
    for (std::size_t pin = 0; pin < lsi.lsi_class->outputs.size(); ++pin)
      if (setups[i].outputs()[pin].count == 0)
        problems.add(ErrorCode::structure, location_of(lsi),
                     "The size of '" + lsi.id + "." + lsi.lsi_class->outputs[pin].name + "' is undefined.",
                     "Wire its inputs, or set the size with a parameter of the LSI.");
  }
  if (!problems.empty()) return;
  each_wire(flat, [&](int i, int pin, const Source& s) {
    const InputPin& in = at(flat, i).lsi_class->inputs[static_cast<std::size_t>(pin)];
    const std::uint32_t wanted = in.count ? in.count : pin_type(in.type).default_count;
    const std::uint32_t got = setups[static_cast<std::size_t>(s.lsi)].outputs()[static_cast<std::size_t>(s.pin)].count;
    if (wanted != 0 && wanted != got)
      problems.add(ErrorCode::structure, location_of(at(flat, i)),
                   "'" + at(flat, s.lsi).id + "." + output_of(flat, s).name + "' has " + std::to_string(got) + " elements, but '" +
                       at(flat, i).id + "." + in.name + "' takes " + std::to_string(wanted) + ".",
                   "Wire an output of " + std::to_string(wanted) + " elements.");
    if (at(flat, s.lsi).every == 0 && at(flat, i).every != 0)
      problems.add(ErrorCode::structure, location_of(at(flat, i)),
                   "'" + at(flat, i).id + "' runs at every tick but reads '" + at(flat, s.lsi).id + "." + output_of(flat, s).name +
                       "', which is computed on demand only.",
                   "Set \"every\" of '" + at(flat, s.lsi).id + "' to 1.");
  });
  for (const FlatLsi& lsi : flat.lsis)
    if (lsi.every == 0 && lsi.lsi_class->advance)
      problems.add(ErrorCode::structure, location_of(lsi),
                   "'" + lsi.id + "' has a state that changes at every tick, so it cannot run on demand only.", "Set \"every\" to 1.");
}

/// Finds a cycle among the LSIs that could not be ordered.
/// @return wires of the cycle, from its LSI with the smallest id on: each is an output and the (LSI, input) that the output feeds
std::vector<std::pair<Source, std::pair<int, int>>> find_cycle(const FlatCircuit& flat, const std::vector<int>& open_edges) {
  // Walk backwards from the first unordered LSI along unordered producers until an LSI is reached for the second time.
  const auto n = flat.lsis.size();
  int current = -1;
  for (std::size_t i = 0; i < n && current < 0; ++i)
    if (open_edges[i] > 0) current = static_cast<int>(i);
  std::vector<std::pair<Source, std::pair<int, int>>> path;
  std::vector<int> seen_at(n, -1);
  while (seen_at[static_cast<std::size_t>(current)] < 0) {
    seen_at[static_cast<std::size_t>(current)] = static_cast<int>(path.size());
    bool found = false;
    const FlatLsi& lsi = at(flat, current);
    for (std::size_t pin = 0; pin < lsi.inputs.size() && !found; ++pin) {
      if (!lsi.lsi_class->inputs[pin].direct) continue;
      for (const Source& s : lsi.inputs[pin].sources) {
        if (output_of(flat, s).delayed || open_edges[static_cast<std::size_t>(s.lsi)] <= 0) continue;
        path.push_back({s, {current, static_cast<int>(pin)}});
        current = s.lsi;
        found = true;
        break;
      }
    }
    if (!found) return path;
  }
  path.erase(path.begin(), path.begin() + seen_at[static_cast<std::size_t>(current)]);
  std::reverse(path.begin(), path.end());
  const auto smallest = std::min_element(path.begin(), path.end(), [](const auto& a, const auto& b) { return a.first.lsi < b.first.lsi; });
  std::rotate(path.begin(), smallest, path.end());
  return path;
}

/// Returns the LSIs sorted by depth (plan.h), then by id. @param wave_ends  receives the end index of each depth in the result
std::vector<int> order_steps(const FlatCircuit& flat, std::vector<std::uint32_t>& wave_ends, Error& problems) {
  const std::size_t n = flat.lsis.size();
  std::vector<int> open_edges(n, 0);
  std::vector<std::vector<int>> consumers(n);
  each_wire(flat, [&](int lsi, int pin, const Source& s) {
    if (output_of(flat, s).delayed || !at(flat, lsi).lsi_class->inputs[static_cast<std::size_t>(pin)].direct) return;
    consumers[static_cast<std::size_t>(s.lsi)].push_back(lsi);
    ++open_edges[static_cast<std::size_t>(lsi)];
  });
  std::vector<int> order, wave;
  order.reserve(n);
  for (std::size_t i = 0; i < n; ++i)
    if (open_edges[i] == 0) wave.push_back(static_cast<int>(i));
  while (!wave.empty()) {
    order.insert(order.end(), wave.begin(), wave.end());
    wave_ends.push_back(static_cast<std::uint32_t>(order.size()));
    std::vector<int> next;
    for (const int i : wave)
      for (const int c : consumers[static_cast<std::size_t>(i)])
        if (--open_edges[static_cast<std::size_t>(c)] == 0) next.push_back(c);
    std::sort(next.begin(), next.end());  // LSIs are numbered in the order of their ids, so the smallest id comes first
    wave = std::move(next);
  }
  if (order.size() == n) return order;

  std::string names;
  std::string last;
  for (const auto& [source, sink] : find_cycle(flat, open_edges)) {
    const FlatLsi& to = at(flat, sink.first);
    last = at(flat, source.lsi).id + "." + output_of(flat, source).name;
    names += (names.empty() ? "" : ", ") + last + " -> " + to.id + "." + to.lsi_class->inputs[static_cast<std::size_t>(sink.second)].name;
  }
  problems.add(ErrorCode::structure, "circuit", "Values form a cycle within one tick: " + names + ".",
               "Insert a delay after '" + last + "'.");
  return order;
}

}  // namespace

Plan make_plan(const FlatCircuit& flat, const Resources* resources, double dt, Error& problems) {
  Plan plan;
  plan.setups.reserve(flat.lsis.size());
  for (const FlatLsi& lsi : flat.lsis)
    plan.setups.emplace_back(lsi.id, location_of(lsi), *lsi.lsi_class, lsi.parameters, resources, dt, problems).set_every(lsi.every);
  plan.order = order_steps(flat, plan.wave_ends, problems);
  resolve_sizes(flat, plan.setups, problems);
  if (!problems.empty()) return plan;
  check_sizes(flat, plan.setups, problems);
  return plan;
}

}  // namespace ugoki::circuit
