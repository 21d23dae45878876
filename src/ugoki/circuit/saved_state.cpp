// Saves and restores the state of a circuit, and copies it into a rebuilt circuit.

#include <algorithm>
#include <cstring>

#include "ugoki/circuit/machine.h"

namespace ugoki::circuit {
namespace {

constexpr std::uint64_t saved_magic = 0x3253434b4f4755ULL;  // "UGOKCS2" in ASCII: marks the saved state of a circuit

struct SavedHeader {
  std::uint64_t magic, layout, ticks;
  std::uint64_t done;  ///< Machine::cursor: number of jobs of the current tick that step_lsi has run
  std::uint64_t arena_words, parameters, checksum;
};

/// Hash of the tick count and the content (FNV-1a by words of 8 bytes, which is fast: states are saved during playback).
std::uint64_t checksum_of(std::uint64_t ticks, std::span<const std::byte> content) {
  std::uint64_t hash = 0xcbf29ce484222325ULL ^ ticks;
  for (std::size_t at = 0; at + sizeof hash <= content.size(); at += sizeof hash) {
    std::uint64_t word;
    std::memcpy(&word, content.data() + at, sizeof word);
    hash = (hash ^ word) * 0x100000001b3ULL;
    hash ^= hash >> 32;
  }
  return hash;
}

/// The reason why the complete state of `from` cannot be copied to `to`; empty if it can.
std::string difference(const Unit& to, const Unit& from) {
  if (from.lsi_class->name != to.lsi_class->name) return "it was another LSI, '" + from.lsi_class->name + "'";
  if (from.lsi_class->version != to.lsi_class->version)
    return "its version was " + std::to_string(from.lsi_class->version) + ", now it is " + std::to_string(to.lsi_class->version);
  if (from.lsi_class->state_layout() != to.lsi_class->state_layout() || from.state.size() != to.state.size())
    return "its state has another layout";
  const auto& a = from.lsi_class->outputs;
  const auto& b = to.lsi_class->outputs;
  const bool same_pins = std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const OutputPin& x, const OutputPin& y) {
    return x.name == y.name && x.type == y.type && x.delayed == y.delayed;
  });
  return same_pins && from.outputs == to.outputs ? "" : "its outputs are different";
}

/// Copies the declared fields that both classes have with the same name, type and count.
/// @return a clause about each field that was not copied: "the field 'y' is new"; empty if all were copied
std::string copy_fields(const LsiClass& from, const std::byte* old_state, const LsiClass& to, std::byte* state, std::size_t& copied) {
  std::string left;
  const auto note = [&left](const std::string& text) { left += (left.empty() ? "" : ", ") + text; };
  for (const StateField& f : to.fields) {
    const auto same = std::find_if(from.fields.begin(), from.fields.end(), [&](const StateField& o) { return o.name == f.name; });
    if (same == from.fields.end()) {
      note("the field '" + f.name + "' is new");
    } else if (same->type != f.type || same->count != f.count) {
      note("the field '" + f.name + "' has another type or count");
    } else {
      std::memcpy(state + f.offset, old_state + same->offset, f.count * bytes_of(f.type));
      ++copied;
    }
  }
  return left;
}

}  // namespace

void Interpreter::save(std::vector<std::byte>& bytes) {
  Machine& m = *machine_;
  m.store_objects();
  SavedHeader header{saved_magic, m.layout, m.tick.index, m.cursor, m.arena.size(), m.parameters.size(), 0};
  const std::size_t arena_size = m.arena.size() * 8, parameter_size = m.parameters.size() * 8;
  bytes.resize(sizeof header + arena_size + parameter_size);
  std::byte* content = bytes.data() + sizeof header;
  std::memcpy(content, m.arena.data(), arena_size);
  if (parameter_size) std::memcpy(content + arena_size, m.parameters.data(), parameter_size);
  header.checksum = checksum_of(header.ticks, {content, arena_size + parameter_size});
  std::memcpy(bytes.data(), &header, sizeof header);
}

Result<void> Interpreter::restore(std::span<const std::byte> bytes) {
  Machine& m = *machine_;
  SavedHeader header{};
  if (bytes.size() >= sizeof header) std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != saved_magic)
    return ugoki::fail(ErrorCode::syntax, "saved state", "These bytes are not a saved state.", "Give the bytes that save wrote.");
  if (header.layout != m.layout || header.done > m.jobs.size() || header.arena_words != m.arena.size() ||
      header.parameters != m.parameters.size())
    return ugoki::fail(ErrorCode::conflict, "saved state",
                       "The state was saved with another circuit, other versions of its LSIs, or another time step.",
                       "Run from the beginning.");
  const std::size_t arena_size = m.arena.size() * 8, parameter_size = m.parameters.size() * 8;
  const std::span<const std::byte> content = bytes.subspan(sizeof header);
  if (content.size() != arena_size + parameter_size || header.checksum != checksum_of(header.ticks, content))
    return ugoki::fail(ErrorCode::truncated, "saved state", "The saved state is cut off or damaged.", "Run from the beginning.");
  std::memcpy(m.arena.data(), content.data(), arena_size);
  if (parameter_size) std::memcpy(m.parameters.data(), content.data() + arena_size, parameter_size);
  m.set_tick(header.ticks);
  m.cursor = static_cast<std::uint32_t>(header.done);
  m.breakpoint_hit = -1;
  m.log.next = 0;
  m.update_plain();
  m.is_stopped = false;
  m.recall_objects();
  return {};
}

Interpreter::Adoption Interpreter::adopt_report(Interpreter& other) {
  Machine& m = *machine_;
  Machine& o = *other.machine_;
  o.store_objects();
  Adoption report;
  const std::size_t to_back = m.back.begin - m.front.begin, from_back = o.back.begin - o.front.begin;
  for (std::size_t i = 0; i < m.units.size(); ++i) {
    const Unit& to = m.units[i];
    const int k = o.find_unit(to.id);
    if (k < 0) continue;
    const Unit& from = o.units[static_cast<std::size_t>(k)];
    const std::string reason = difference(to, from);
    if (!reason.empty()) {
      std::size_t copied = 0;
      std::string left;
      const bool same_meaning = from.lsi_class->name == to.lsi_class->name && from.lsi_class->version == to.lsi_class->version;
      if (same_meaning && to.state.size() && from.state.size())
        left = copy_fields(*from.lsi_class, o.bytes() + from.state.begin, *to.lsi_class, m.bytes() + to.state.begin, copied);
      if (copied)
        report.partly.push_back("'" + to.id + "' keeps " + std::to_string(copied) + " fields of its state" +
                                (left.empty() ? "." : "; " + left + "."));
      else if (to.state.size() || from.state.size())
        report.afresh.push_back("'" + to.id + "' starts from its initial state: " + reason + ".");
      continue;
    }
    if (to.state.size()) std::memcpy(m.bytes() + to.state.begin, o.bytes() + from.state.begin, to.state.size());
    for (std::size_t pin = 0; pin < to.outputs.size(); ++pin) {
      const std::size_t size = m.view({static_cast<int>(i), static_cast<int>(pin)}).bytes.size();
      std::memcpy(m.bytes() + to.output_offsets[pin], o.bytes() + from.output_offsets[pin], size);
      if (to.lsi_class->outputs[pin].delayed)
        std::memcpy(m.bytes() + to.output_offsets[pin] + to_back, o.bytes() + from.output_offsets[pin] + from_back, size);
    }
    if (to.lsi_class->recall) to.lsi_class->recall(&m.call_at(i));
    ++report.kept;
  }
  m.set_tick(o.tick.index);
  return report;
}

}  // namespace ugoki::circuit
