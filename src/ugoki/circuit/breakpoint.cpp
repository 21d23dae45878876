#include "ugoki/circuit/breakpoint.h"

#include <optional>
#include <utility>

#include "ugoki/base/number.h"

namespace ugoki::circuit {
namespace {

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

/// Reads a pin written "id.pin" or "id.pin[2]". @return false if the text has another form
bool read_pin(std::string_view text, Breakpoint& to) {
  text = trimmed(text);
  if (const auto open = text.rfind('['); open != std::string_view::npos && text.ends_with(']')) {
    constexpr long max_component = 1'000'000;  // keeps the conversion to an index safe; the interpreter checks the pin's own size
    const std::optional<long> component = parse_long(text.substr(open + 1, text.size() - open - 2));
    if (!component || *component < 0 || *component > max_component) return false;
    to.component = static_cast<std::size_t>(*component);
    text = trimmed(text.substr(0, open));
  }
  to.pin = text;
  const auto dot = text.rfind('.');
  return dot != std::string_view::npos && dot > 0 && dot + 1 < text.size();
}

}  // namespace

Result<Breakpoint> read_breakpoint(std::string_view text) {
  constexpr std::pair<std::string_view, Comparison> words[] = {{" changes", Comparison::changed}, {" becomes true", Comparison::above}};
  constexpr std::pair<std::string_view, Comparison> signs[] = {{"!=", Comparison::not_equal},
                                                               {"==", Comparison::equal},
                                                               {">", Comparison::above},
                                                               {"<", Comparison::below},
                                                               {"=", Comparison::equal}};
  const auto wrong = [&] {
    return fail(ErrorCode::syntax, "condition", "'" + std::string(text) + "' is not a condition.",
                "Write it as \"id.pin > 3\", \"id.pin[2] < 0\", \"id.pin becomes true\" or \"id.pin changes\".");
  };
  Breakpoint b;
  const std::string_view all = trimmed(text);
  for (const auto& [word, comparison] : words) {
    if (!all.ends_with(word)) continue;
    b.comparison = comparison;
    if (!read_pin(all.substr(0, all.size() - word.size()), b)) return wrong();
    return b;
  }
  for (const auto& [sign, comparison] : signs) {
    const auto at = all.rfind(sign);
    if (at == std::string_view::npos) continue;
    const std::optional<double> value = parse_double(trimmed(all.substr(at + sign.size())));
    if (!value || !read_pin(all.substr(0, at), b)) return wrong();
    b.comparison = comparison;
    b.value = *value;
    return b;
  }
  return wrong();
}

}  // namespace ugoki::circuit
